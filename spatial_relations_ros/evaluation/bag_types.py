"""Message types for reading and writing bags without ROS."""

from __future__ import annotations

import contextlib
from collections.abc import Iterable
from pathlib import Path

from rosbags.interfaces import Connection, MessageDefinitionFormat
from rosbags.interfaces.typing import Typesdict
from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from spatial_relations_ros.core import ConfigError, share_path

POINT_CLOUD = 'sensor_msgs/msg/PointCloud2'
POSE_STAMPED = 'geometry_msgs/msg/PoseStamped'
TF_MESSAGE = 'tf2_msgs/msg/TFMessage'
TRACKED_OBJECTS = 'spatial_relations_msgs/msg/TrackedObjectArray'
DETECTIONS = 'vision_msgs/msg/Detection3DArray'


def package_typestore() -> Typestore:
    """ROS 2 Jazzy's messages and those of ``spatial_relations_msgs``.

    Raises:
        ConfigError: when the definitions of the own messages are not there; they are part of the
            repository.
    """
    store = get_typestore(Stores.ROS2_JAZZY)
    store.register(_own_types(share_path('msg_defs', 'msg')))
    return store


def bag_typestore(connections: Iterable[Connection]) -> Typestore:
    """The messages of a bag, by the definitions that are stored in it.

    Bags without stored definitions are read with those of ROS 2 Jazzy and of this package.
    """
    store = get_typestore(Stores.ROS2_JAZZY)
    for connection in connections:
        definition = connection.msgdef
        if connection.msgtype in store.types:
            continue
        if definition.format == MessageDefinitionFormat.MSG:
            _register_new(store, get_types_from_msg(definition.data, connection.msgtype))
        elif definition.format == MessageDefinitionFormat.IDL:
            _register_new(store, get_types_from_idl(definition.data))
    with contextlib.suppress(ConfigError):
        _register_new(store, _own_types(share_path('msg_defs', 'msg')))
    return store


def _register_new(store: Typestore, types: Typesdict) -> None:
    store.register({name: item for name, item in types.items() if name not in store.types})


def _own_types(folder: Path) -> Typesdict:
    types: Typesdict = {}
    for path in sorted(folder.glob('*.msg')):
        name = f'spatial_relations_msgs/msg/{path.stem}'
        types.update(get_types_from_msg(path.read_text(encoding='utf-8'), name))
    return types
