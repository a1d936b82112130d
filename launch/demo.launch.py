"""The demonstration of `make demo` on a ROS host: nodes, bag and request, results in out/demo."""

import sys

from launch.actions import DeclareLaunchArgument, EmitEvent, ExecuteProcess, RegisterEventHandler
from launch.event_handlers import OnProcessExit
from launch.events import Shutdown
from launch.substitutions import LaunchConfiguration

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    demo = ExecuteProcess(
        cmd=[
            sys.executable,
            '-m',
            'spatial_relations_ros.nodes.demo',
            '--bags',
            LaunchConfiguration('bags'),
            '--out',
            LaunchConfiguration('out'),
        ],
        output='screen',
    )
    return LaunchDescription(
        [
            DeclareLaunchArgument('bags', description="The repository's folder bags/"),
            DeclareLaunchArgument(
                'out', default_value='out/demo', description='Folder for the results'
            ),
            demo,
            RegisterEventHandler(
                OnProcessExit(target_action=demo, on_exit=[EmitEvent(event=Shutdown())])
            ),
        ]
    )
