"""Builds the Python package, for colcon (ament_python) and for pip."""

from pathlib import Path

from setuptools import find_packages, setup

PACKAGE_NAME = 'spatial_relations_ros'
ROOT = Path(__file__).resolve().parent


def share_files(folder: str) -> tuple[str, list[str]]:
    """The data_files entry of one folder of the repository; empty folders are fine."""
    files = sorted(path for path in (ROOT / folder).glob('*') if path.is_file())
    return f'share/{PACKAGE_NAME}/{folder}', [str(path.relative_to(ROOT)) for path in files]


setup(
    name=PACKAGE_NAME,
    version='0.1.0',
    packages=find_packages(include=[PACKAGE_NAME, f'{PACKAGE_NAME}.*']),
    package_data={
        PACKAGE_NAME: ['py.typed'],
        f'{PACKAGE_NAME}.visualization.report': ['*.html', '*.css', '*.js'],
        f'{PACKAGE_NAME}.nodes.panel': ['static/*'],
    },
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{PACKAGE_NAME}']),
        (f'share/{PACKAGE_NAME}', ['package.xml']),
        share_files('config'),
        share_files('launch'),
        share_files('models'),
        # Read without ROS, to decode bags that lack the definitions.
        share_files('msg_defs/msg'),
    ],
    python_requires='>=3.11',
    install_requires=['setuptools'],
    extras_require={
        'test': ['pytest'],
        # Whether generated scenes stay put in simulation; never in the live path.
        'physics': ['mujoco>=3.2'],
        # Replays of many bags over several machines.
        'cluster': ['ray>=2.9'],
        # The page that panel_node serves.
        'panel': ['aiohttp>=3.9'],
        # Recordings for Rerun; needs numpy 2.
        'viz': ['rerun-sdk>=0.41,<0.42'],
    },
    zip_safe=False,
    maintainer='spatial_relations_ros maintainers',
    maintainer_email='maintainers@users.noreply.github.com',
    description='Live imitation of spatial relations between objects',
    license='Apache-2.0',
    entry_points={
        'console_scripts': [
            f'perception_node = {PACKAGE_NAME}.nodes.perception_node:main',
            f'metric_node = {PACKAGE_NAME}.nodes.metric_node:main',
            f'imitate_node = {PACKAGE_NAME}.nodes.imitate_node:main',
            f'play_bag = {PACKAGE_NAME}.nodes.play_bag:main',
            f'panel_node = {PACKAGE_NAME}.nodes.panel_node:main',
            f'relations = {PACKAGE_NAME}.cli.main:main',
        ],
    },
)
