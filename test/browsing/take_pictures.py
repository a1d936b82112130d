"""Makes pictures of the documentation, with the demonstration's bag and nodes: panel and markers.

``python test/browsing/take_pictures.py docs/images`` in the package's environment.
"""

from __future__ import annotations

import argparse
import os
import tempfile
from pathlib import Path

import rclpy
from chromium import Browser, running_browser
from PIL import Image
from rclpy.node import Node
from visualization_msgs.msg import MarkerArray

from spatial_relations_ros.nodes.bag_player import BagPlayer
from spatial_relations_ros.nodes.demo_plan import DemoPlan, read_demo_plan
from spatial_relations_ros.ros.domains import free_domain_id
from spatial_relations_ros.ros.marker_pictures import draw_markers
from spatial_relations_ros.ros.processes import NodeProcesses, local_graph
from spatial_relations_ros.ros.qos import ANSWERS
from spatial_relations_ros.visualization import write_image

ROOT = Path(__file__).resolve().parents[2]
PORT = 8791
START_SEC = 300.0


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('folder', type=Path)
    parser.add_argument('--all', action='store_true', help='both themes and two window sizes')
    arguments = parser.parse_args()
    plan = read_demo_plan(ROOT / 'bags' / 'demo.yaml')
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        domain_id = free_domain_id()
        environment = local_graph(domain_id, folder)
        os.environ.update(environment)
        rclpy.init(domain_id=domain_id)
        node = Node('pictures')
        arrays: list[MarkerArray] = []
        node.create_subscription(MarkerArray, 'imitate_node/markers', arrays.append, ANSWERS)
        with NodeProcesses(environment, folder) as processes, running_browser(folder) as browser:
            start_nodes(processes, plan, folder)
            player = BagPlayer(node, plan.bag)
            topics = [plan.points_topic, plan.tracked_objects_topic]
            player.wait_for_subscribers(topics, START_SEC)
            player.play()
            use_panel(browser, processes, plan)
            while not arrays:
                rclpy.spin_once(node)
            markers = arguments.folder / 'markers.png'
            write_image(markers, draw_markers(arrays[-1].markers))
            small(markers)
            looks = [('light', 1280)]
            if arguments.all:
                looks = [(theme, width) for theme in ('light', 'dark') for width in (1280, 420)]
            for theme, width in looks:
                browser.show(size=(width, 900), theme=theme)
                suffix = f'_{theme}_{width}' if arguments.all else ''
                small(browser.picture(arguments.folder / f'panel{suffix}.png'))
        node.destroy_node()
        rclpy.shutdown()


def start_nodes(processes: NodeProcesses, plan: DemoPlan, folder: Path) -> None:
    models = {'models_path': str(plan.models_path)}
    processes.start(
        'perception_node',
        parameters={**models, 'reliable_points': True, 'max_age': 0.0},
        remappings={
            '~/points': plan.points_topic,
            '~/tracked_objects': plan.tracked_objects_topic,
        },
    )
    processes.start('metric_node', parameters={'memory_path': str(folder / 'memory.sqlite3')})
    processes.start('imitate_node', parameters={**models, 'standalone': False})
    camera = {'camera_frame': 'kinect2_ir_optical_frame'}
    processes.start('panel_node', parameters={**models, **camera, 'port': PORT})


def use_panel(browser: Browser, processes: NodeProcesses, plan: DemoPlan) -> None:
    """Remembers the demonstration and imitates it."""
    processes.check()
    browser.open(f'http://127.0.0.1:{PORT}/')
    browser.wait('views.seen.viewer.items.length >= 7', 'the objects', START_SEC)
    planned = plan.imitations[0]
    for name, ids in (('reference', planned.reference_ids), ('test', planned.test_ids)):
        for role, object_id in zip(('base', 'relative'), ids, strict=True):
            browser.choose(f'#{name}-{role}', object_id)
    browser.type('#name', f'{planned.reference_ids[1]} on {planned.reference_ids[0]}')
    browser.click('#remember')
    browser.wait("byId('relations').children.length", 'the remembered relation', START_SEC)
    browser.type('#answers-wanted', '3')
    browser.click('#imitate')
    browser.wait('document.body.dataset.result', 'the answers', START_SEC)
    browser.wait('views.test.viewer.items.length >= 3', 'the objects at their targets')
    browser.wait("document.body.dataset.running === 'false'", 'the end')


def small(path: Path) -> None:
    """256 colours: a third of the size, and no difference that one sees."""
    picture = Image.open(path).convert('RGB')
    picture.quantize(256, dither=Image.Dither.FLOYDSTEINBERG).save(path, optimize=True)


if __name__ == '__main__':
    main()
