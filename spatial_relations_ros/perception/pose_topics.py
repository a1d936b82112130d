"""Which topic holds the poses of which object."""

from __future__ import annotations

from collections.abc import Sequence

from spatial_relations_ros.core import ConfigError


def pose_topics(entries: Sequence[str], *, name: str = 'pose_topics') -> dict[str, str]:
    """Object ids and their topics of PoseStamped messages.

    ``/simtrack/bowl`` is the topic of the object ``bowl``; ``cup=/some/pose`` names the object.

    Args:
        entries: topics.
        name: of the parameter or option that holds them.

    Raises:
        ConfigError: for an entry without an object id or a topic, or two of one object.
    """
    topics: dict[str, str] = {}
    for entry in entries:
        object_id, separator, topic = entry.partition('=')
        if not separator:
            object_id, topic = entry.rstrip('/').rpartition('/')[2], entry
        if not object_id or not topic:
            raise ConfigError(f'{name} has {entry!r}; expected "/topic/id" or "id=/topic"')
        if object_id in topics:
            raise ConfigError(
                f'{name} has {topics[object_id]} and {topic} of one object {object_id!r}; '
                f'name the objects, as in "cup={topic}"'
            )
        topics[object_id] = topic
    return topics
