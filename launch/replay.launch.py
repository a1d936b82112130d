"""The three nodes and a bag: ros2 launch spatial_relations_ros replay.launch.py bag:=PATH.

All other arguments of live.launch.py can be given too, panel:=true for example.
"""

from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.conditions import IfCondition, UnlessCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchDescription
from spatial_relations_ros.core import share_path

PASSED_ON = ('points', 'tracked_objects', 'models_path', 'weights')
# Until the nodes have loaded what they need; else a bag that is played once begins without them.
WAIT_SEC = '120'


def generate_launch_description() -> LaunchDescription:
    nodes = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(str(share_path('launch', 'live.launch.py'))),
        launch_arguments={name: LaunchConfiguration(name) for name in PASSED_ON}.items(),
    )
    play = [LaunchConfiguration('bag'), '--rate', LaunchConfiguration('rate')]
    play += ['--wait', WAIT_SEC, '--wait-for', LaunchConfiguration('points')]
    is_looped = LaunchConfiguration('loop')
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                'bag', description='Folder of a rosbag2, or its file: mcap or sqlite3, also zstd'
            ),
            DeclareLaunchArgument(
                'loop', default_value='true', description='Whether the bag starts again at its end'
            ),
            DeclareLaunchArgument(
                'rate', default_value='1.0', description='Times faster than recorded'
            ),
            DeclareLaunchArgument(
                'points',
                default_value='/kinect2/qhd/points',
                description="The bag's topic of PointCloud2",
            ),
            DeclareLaunchArgument(
                'tracked_objects',
                default_value='/tracked_objects',
                description="The bag's topic of TrackedObjectArray",
            ),
            DeclareLaunchArgument(
                'models_path', default_value='', description='Folder of object models'
            ),
            DeclareLaunchArgument(
                'weights', default_value='', description='Weights file; empty: those shipped'
            ),
            nodes,
            _player([*play, '--loop'], IfCondition(is_looped)),
            _player(play, UnlessCondition(is_looped)),
        ]
    )


def _player(arguments: list[object], condition: IfCondition) -> Node:
    # As the camera's driver: clouds lie in the memory of who publishes them.
    profile = str(share_path('config', 'fastdds_large_clouds.xml'))
    return Node(
        package='spatial_relations_ros',
        executable='play_bag',
        arguments=arguments,
        additional_env={'FASTRTPS_DEFAULT_PROFILES_FILE': profile},
        condition=condition,
        output='screen',
    )
