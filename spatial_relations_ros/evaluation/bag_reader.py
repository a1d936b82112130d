"""Reads bags without ROS, as the frames that the live nodes make of the same messages."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any

from rosbags.rosbag2 import Reader
from rosbags.typesys.store import Typestore

from spatial_relations_ros.core import BagError, CloudFormatError, SpatialRelationsError
from spatial_relations_ros.evaluation.bag_types import (
    DETECTIONS,
    POINT_CLOUD,
    POSE_STAMPED,
    TF_MESSAGE,
    TRACKED_OBJECTS,
    bag_typestore,
)
from spatial_relations_ros.perception.assembler import FrameAssembler
from spatial_relations_ros.perception.border import Frame
from spatial_relations_ros.perception.messages import (
    read_detections,
    read_pose_stamped,
    read_tracked_objects,
    read_transforms,
    stamp_ns,
)
from spatial_relations_ros.perception.point_cloud2 import read_xyz

STATIC_TF_TOPIC = '/tf_static'


@dataclass(frozen=True)
class RawMessage:
    """A message as it was recorded.

    Attributes:
        topic: its topic.
        msgtype: such as ``sensor_msgs/msg/PointCloud2``.
        time_ns: when it was received.
        data: its bytes in CDR, as rclpy publishes them.
    """

    topic: str
    msgtype: str
    time_ns: int
    data: bytes


@dataclass(frozen=True)
class BagTopics:
    """Which topics of a bag are read.

    Attributes:
        points: the clouds.
        tracked_objects: topics with TrackedObjectArray or Detection3DArray messages.
        pose_topics: object id -> its PoseStamped topic.
    """

    points: str
    tracked_objects: tuple[str, ...] = ()
    pose_topics: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class DroppedMessage:
    """A message that could not be used, and why."""

    topic: str
    time_ns: int
    reason: str


class _UndecodableError(SpatialRelationsError):
    """One message whose bytes are not those of its type."""


class BagReader:
    """Reads one bag: mcap or sqlite3, compressed or not; use it in a ``with`` block.

    Args:
        path: the bag's folder, or a single .mcap or .db3 file.
        topics: which topics to read; found by their types when left out: the cloud topic with
            the most messages, all arrays of tracked objects, or without those every PoseStamped
            topic, whose last part is the object's id.

    Attributes:
        dropped: what could not be used so far.

    Raises:
        BagError: when the bag is missing, damaged or empty, or a topic is not in it.
    """

    def __init__(self, path: Path | str, topics: BagTopics | None = None) -> None:
        self.path = Path(path)
        self._wanted = topics
        self.dropped: list[DroppedMessage] = []
        with _bag_errors(self.path):
            self._reader = Reader(self.path)

    def __enter__(self) -> BagReader:
        with _bag_errors(self.path):
            self._reader.open()
            self._types: Typestore = bag_typestore(self._reader.connections)
        if self._reader.message_count == 0:
            self._reader.close()
            raise BagError(f'{self.path} holds no messages')
        return self

    def __exit__(
        self,
        exc_type: type[BaseException] | None,
        exc_value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._reader.close()

    @property
    def contents(self) -> dict[str, tuple[str, int]]:
        """Topic -> its type and number of messages, sorted by topic."""
        counts: Counter[tuple[str, str]] = Counter()
        for item in self._reader.connections:
            counts[item.topic, item.msgtype] += item.msgcount
        return {topic: (msgtype, counts[topic, msgtype]) for topic, msgtype in sorted(counts)}

    @property
    def start_ns(self) -> int:
        """When the first message was received."""
        return self._reader.start_time

    @property
    def duration_ns(self) -> int:
        """From the first to the last message."""
        return self._reader.duration

    def raw(self) -> Iterator[RawMessage]:
        """All messages in the order in which they were received."""
        with _bag_errors(self.path):
            for connection, time_ns, data in self._reader.messages():
                yield RawMessage(connection.topic, connection.msgtype, time_ns, bytes(data))

    def topics(self) -> BagTopics:
        """The topics that ``frames`` reads.

        Raises:
            BagError: when the bag has no clouds, or lacks a topic that was asked for.
        """
        contents = self.contents
        if self._wanted is None:
            return self._found_topics(contents)
        for topic, allowed in (
            (self._wanted.points, {POINT_CLOUD}),
            *((topic, {TRACKED_OBJECTS, DETECTIONS}) for topic in self._wanted.tracked_objects),
            *((topic, {POSE_STAMPED}) for topic in self._wanted.pose_topics.values()),
        ):
            if contents.get(topic, ('', 0))[0] not in allowed:
                raise BagError(f'no {" or ".join(sorted(allowed))} on {topic}; {self._describe()}')
        return self._wanted

    def frames(self) -> Iterator[Frame]:
        """One frame for each cloud, in the order in which they were received.

        Messages that cannot be used are left out and noted in ``dropped``.

        Raises:
            BagError: when the topics are missing or the bag is damaged.
        """
        topics = self.topics()
        object_ids = {topic: object_id for object_id, topic in topics.pose_topics.items()}
        used = {topics.points, *topics.tracked_objects, *object_ids}
        connections = [
            item
            for item in self._reader.connections
            if item.topic in used or item.msgtype == TF_MESSAGE
        ]
        assembler = FrameAssembler()
        with _bag_errors(self.path):
            for connection, time_ns, data in self._reader.messages(connections):
                topic, msgtype = connection.topic, connection.msgtype
                dropped = assembler.dropped.copy()
                try:
                    message = self._deserialized(data, msgtype)
                    if msgtype == POINT_CLOUD:
                        cloud, stamp = read_xyz(message), stamp_ns(message.header.stamp)
                        assembler.add_cloud(stamp, message.header.frame_id, cloud, time_ns)
                    else:
                        _gather(assembler, topic, msgtype, message, object_ids)
                except (CloudFormatError, _UndecodableError) as error:
                    self.dropped.append(DroppedMessage(topic, time_ns, str(error)))
                for reason in (assembler.dropped - dropped).elements():
                    self.dropped.append(DroppedMessage(topics.points, time_ns, reason))
                while (frame := assembler.take(time_ns)) is not None:
                    yield frame
            while (frame := assembler.take(None)) is not None:
                yield frame

    def _deserialized(self, data: bytes, msgtype: str) -> Any:
        try:
            return self._types.deserialize_cdr(data, msgtype)
        except Exception as error:
            # One damaged message must not end the replay; its decoder raises what it likes.
            raise _UndecodableError(f'cannot be decoded as {msgtype}: {error!r}') from error

    def _found_topics(self, contents: Mapping[str, tuple[str, int]]) -> BagTopics:
        clouds = {topic: count for topic, (kind, count) in contents.items() if kind == POINT_CLOUD}
        if not clouds:
            raise BagError(f'no {POINT_CLOUD} in {self.path}; {self._describe()}')
        arrays = tuple(
            topic for topic, (kind, _) in contents.items() if kind in (TRACKED_OBJECTS, DETECTIONS)
        )
        poses: dict[str, str] = {}
        for topic, (kind, _) in contents.items():
            if kind == POSE_STAMPED and not arrays:
                object_id = topic.rsplit('/', 1)[-1]
                if object_id in poses:
                    raise BagError(
                        f'{poses[object_id]} and {topic} of {self.path} both end with '
                        f'{object_id!r}; name topics and objects, as in --pose-topic "cup={topic}"'
                    )
                poses[object_id] = topic
        points = max(clouds, key=lambda topic: clouds[topic])
        return BagTopics(points, arrays, poses)

    def _describe(self) -> str:
        topics = [f'{topic} ({kind}, {count})' for topic, (kind, count) in self.contents.items()]
        return f'the bag has {", ".join(topics) or "no topics"}'


def iter_raw(path: Path | str) -> Iterator[RawMessage]:
    """All messages of a bag as they were recorded, to be published again.

    Raises:
        BagError: when the bag is missing, damaged or empty.
    """
    with BagReader(path) as reader:
        yield from reader.raw()


def read_frames(path: Path | str, topics: BagTopics | None = None) -> Iterator[Frame]:
    """All frames of a bag.

    Raises:
        BagError: when the bag is missing, damaged or empty, or lacks the topics.
    """
    with BagReader(path, topics) as reader:
        yield from reader.frames()


def _gather(
    assembler: FrameAssembler,
    topic: str,
    msgtype: str,
    message: Any,
    object_ids: Mapping[str, str],
) -> None:
    if msgtype == TF_MESSAGE:
        is_static = topic.endswith(STATIC_TF_TOPIC)
        assembler.add_transforms(*read_transforms(message, is_static=is_static))
    elif msgtype == POSE_STAMPED:
        assembler.add_tracks(*read_pose_stamped(message, object_ids[topic]))
    elif msgtype == DETECTIONS:
        assembler.add_tracks(*read_detections(message))
    else:
        assembler.add_tracks(*read_tracked_objects(message))


@contextmanager
def _bag_errors(path: Path) -> Iterator[None]:
    """Names the bag in whatever goes wrong with it."""
    try:
        yield
    except (BagError, GeneratorExit):
        raise
    except FileNotFoundError as error:
        raise BagError(f'{path} is not a bag: {error}') from error
    except Exception as error:
        # A damaged file surfaces as errors of yaml, zstd, struct, sqlite or the reader itself.
        raise BagError(f'{path} cannot be read: {type(error).__name__}: {error}') from error
