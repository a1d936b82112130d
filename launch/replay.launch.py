"""The three nodes and a bag: ros2 launch spatial_relations_ros replay.launch.py bag:=PATH."""

from launch.actions import DeclareLaunchArgument, ExecuteProcess, IncludeLaunchDescription
from launch.conditions import IfCondition, UnlessCondition
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration

from launch import LaunchDescription
from spatial_relations_ros.core import share_path


def generate_launch_description() -> LaunchDescription:
    bag = LaunchConfiguration('bag')
    nodes = IncludeLaunchDescription(
        PythonLaunchDescriptionSource(str(share_path('launch', 'live.launch.py'))),
        launch_arguments={
            name: LaunchConfiguration(name)
            for name in ('points', 'tracked_objects', 'models_path', 'weights')
        }.items(),
    )
    is_looped = LaunchConfiguration('loop')
    return LaunchDescription(
        [
            DeclareLaunchArgument('bag', description='Folder of a rosbag2'),
            DeclareLaunchArgument('loop', default_value='true'),
            DeclareLaunchArgument('points', default_value='/kinect2/qhd/points'),
            DeclareLaunchArgument('tracked_objects', default_value='/tracked_objects'),
            DeclareLaunchArgument('models_path', default_value=''),
            DeclareLaunchArgument('weights', default_value=''),
            nodes,
            ExecuteProcess(
                cmd=['ros2', 'bag', 'play', bag, '--loop'],
                condition=IfCondition(is_looped),
                output='screen',
            ),
            ExecuteProcess(
                cmd=['ros2', 'bag', 'play', bag],
                condition=UnlessCondition(is_looped),
                output='screen',
            ),
        ]
    )
