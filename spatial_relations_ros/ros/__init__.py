"""The border to ROS 2: messages, parameters, diagnostics, and the way a node runs."""

try:
    import spatial_relations_msgs  # noqa: F401
except ImportError as error:
    raise ImportError(
        'the interface package spatial_relations_msgs is not built or not sourced. Without a ROS '
        'installation run `make build`. In a colcon workspace build both packages with '
        '`colcon build --base-paths src "src/*/msg_defs"`, then source install/setup.bash.'
    ) from error
