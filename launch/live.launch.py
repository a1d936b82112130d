"""The nodes on a live camera: ros2 launch spatial_relations_ros live.launch.py panel:=true."""

from pathlib import Path

from launch.actions import DeclareLaunchArgument, SetEnvironmentVariable
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchDescription
from spatial_relations_ros.core import share_path

RESPAWN_DELAY_SEC = 2.0


def generate_launch_description() -> LaunchDescription:
    config: Path = share_path('config')
    models_path = LaunchConfiguration('models_path')
    enclaves = LaunchConfiguration('enclaves')
    namespace = LaunchConfiguration('namespace')
    arguments = [
        DeclareLaunchArgument('namespace', default_value='', description='Of all nodes'),
        DeclareLaunchArgument(
            'enclaves', default_value='', description='Put before the enclaves of SROS2: /robot1'
        ),
        DeclareLaunchArgument(
            'points', default_value='/kinect2/qhd/points', description='PointCloud2 topic'
        ),
        DeclareLaunchArgument(
            'tracked_objects', default_value='/tracked_objects', description='TrackedObjectArray'
        ),
        DeclareLaunchArgument(
            'detections',
            default_value='/detections',
            description='Detection3DArray, where vision_msgs is installed',
        ),
        DeclareLaunchArgument(
            'world_frame',
            default_value='world',
            description='Frame of all that is published, z up against gravity',
        ),
        DeclareLaunchArgument(
            'models_path', default_value='', description='Folder of object models'
        ),
        DeclareLaunchArgument(
            'weights', default_value='', description='Weights file; empty: those shipped'
        ),
        DeclareLaunchArgument(
            'panel', default_value='false', description='Serve a page at panel_port; needs aiohttp'
        ),
        DeclareLaunchArgument(
            'panel_port', default_value='8765', description='Of the page; 0 takes a free one'
        ),
        DeclareLaunchArgument(
            'respawn', default_value='false', description='Start nodes again that end on their own'
        ),
        DeclareLaunchArgument(
            'rviz', default_value='false', description='Show all in RViz; needs rviz2'
        ),
    ]
    world_frame = {'world_frame': LaunchConfiguration('world_frame')}
    # A pause, so that a node that cannot be set up does not take the machine.
    lasting = {'respawn': LaunchConfiguration('respawn'), 'respawn_delay': RESPAWN_DELAY_SEC}
    perception = Node(
        package='spatial_relations_ros',
        executable='perception_node',
        name='perception_node',
        namespace=namespace,
        ros_arguments=['--enclave', [enclaves, '/perception_node']],
        output='screen',
        **lasting,
        parameters=[
            str(config / 'perception_node.yaml'),
            {'models_path': models_path},
            world_frame,
        ],
        remappings=[
            ('~/points', LaunchConfiguration('points')),
            ('~/tracked_objects', LaunchConfiguration('tracked_objects')),
            ('~/detections', LaunchConfiguration('detections')),
        ],
    )
    weights = {'weights': LaunchConfiguration('weights')}
    metric = Node(
        package='spatial_relations_ros',
        executable='metric_node',
        name='metric_node',
        namespace=namespace,
        ros_arguments=['--enclave', [enclaves, '/metric_node']],
        output='screen',
        **lasting,
        parameters=[str(config / 'metric_node.yaml'), weights, world_frame],
    )
    imitate = Node(
        package='spatial_relations_ros',
        executable='imitate_node',
        name='imitate_node',
        namespace=namespace,
        ros_arguments=['--enclave', [enclaves, '/imitate_node']],
        output='screen',
        **lasting,
        parameters=[
            str(config / 'imitate_node.yaml'),
            weights,
            world_frame,
            {'models_path': models_path, 'standalone': 'false'},
        ],
    )
    panel = Node(
        package='spatial_relations_ros',
        executable='panel_node',
        name='panel_node',
        namespace=namespace,
        ros_arguments=['--enclave', [enclaves, '/panel_node']],
        output='screen',
        **lasting,
        parameters=[
            str(config / 'panel_node.yaml'),
            world_frame,
            {'models_path': models_path, 'port': LaunchConfiguration('panel_port')},
        ],
        condition=IfCondition(LaunchConfiguration('panel')),
    )
    rviz = Node(
        package='rviz2',
        executable='rviz2',
        arguments=['-d', str(config / 'relations.rviz')],
        condition=IfCondition(LaunchConfiguration('rviz')),
    )
    # Messages up to the size of a Kinect cloud; the default profile loses most of them.
    profile = SetEnvironmentVariable(
        'FASTRTPS_DEFAULT_PROFILES_FILE', str(config / 'fastdds_nodes.xml')
    )
    return LaunchDescription([*arguments, profile, perception, metric, imitate, panel, rviz])
