"""An imitation as markers for RViz: what was shown, what is to move, where to and how."""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import Point
from std_msgs.msg import Header
from visualization_msgs.msg import Marker, MarkerArray

from spatial_relations_ros.core import Scene
from spatial_relations_ros.imitation import ImitationAnswer, ObjectPlacement
from spatial_relations_ros.ros.markers import (
    color_to_msg,
    delete_all,
    name_marker,
    shape_marker,
    text_marker,
)
from spatial_relations_ros.visualization.palette import OBJECT_COLOURS, RIGHT, WRONG

GHOST_ALPHA = 0.45
SHAFT, HEAD, HEAD_LENGTH = 0.008, 0.02, 0.025
LINE_HEIGHT = 0.035
MAX_LINES = 4


def imitation_markers(
    answer: ImitationAnswer, reference: Scene, test: Scene, header: Header
) -> MarkerArray:
    """The best answer.

    Namespaces: ``reference`` and ``test`` (the objects as they stand, base blue and relative
    orange), ``targets`` (what moves, translucent at its target), ``approach`` (an arrow into each
    target, green where the way is free, else red), ``names``, and ``text`` (distance, and what is
    violated).

    Args:
        answer: to show.
        reference: the demonstration; a remembered one stands where it once stood.
        test: the test scene as it stands.
        header: of all markers, the world frame.
    """
    array = MarkerArray(markers=[delete_all(header)])
    colors = OBJECT_COLOURS[:2]
    for namespace, scene in (('reference', reference), ('test', test)):
        for idx, (item, color) in enumerate(zip(scene.objects, colors, strict=True)):
            array.markers.append(
                shape_marker(item, header, color_to_msg(color), namespace=namespace, idx=idx)
            )
    for idx, item in enumerate((*reference.objects, *test.objects)):
        text = f'shown: {item.object_id}' if idx < 2 else item.object_id
        array.markers.append(name_marker(item, header, text, namespace='names', idx=idx))
    placed = answer.scene(test).objects
    for idx, (placement, item, color) in enumerate(
        zip(answer.placements, placed, colors, strict=True)
    ):
        if placement.current.is_close(placement.target, metres=1e-4, angle_rad=1e-3):
            continue
        ghost = color_to_msg(color, GHOST_ALPHA)
        array.markers += [
            shape_marker(item, header, ghost, namespace='targets', idx=idx),
            _arrow(placement, header, idx),
        ]
    top = np.max([item.world_points.max(axis=0) for item in placed], axis=0)
    middle = np.mean([item.world_points.mean(axis=0) for item in placed], axis=0)
    lines = _lines(answer)
    for idx, line in enumerate(lines):
        height = float(top[2]) + (len(lines) - idx + 1) * LINE_HEIGHT
        position = (float(middle[0]), float(middle[1]), height)
        array.markers.append(text_marker(position, header, line, namespace='text', idx=idx))
    return array


def _arrow(placement: ObjectPlacement, header: Header, idx: int) -> Marker:
    """From the approach pose's origin to the target's."""
    color = color_to_msg(RIGHT if placement.approach_clear else WRONG)
    ends = [placement.approach.translation, placement.target.translation]
    marker = Marker(
        header=header, ns='approach', id=idx, type=Marker.ARROW, action=Marker.ADD, color=color,
        points=[Point(x=x, y=y, z=z) for x, y, z in (end.tolist() for end in ends)],
    )  # fmt: skip
    marker.scale.x, marker.scale.y, marker.scale.z = SHAFT, HEAD, HEAD_LENGTH
    return marker


def _lines(answer: ImitationAnswer) -> list[str]:
    feasible = 'feasible' if answer.feasible else 'not feasible'
    lines = [f'distance {answer.distance:.2f}, {feasible}', *answer.violations]
    if len(lines) > MAX_LINES:
        lines = [*lines[: MAX_LINES - 1], f'and {len(lines) - MAX_LINES + 1} more']
    return lines
