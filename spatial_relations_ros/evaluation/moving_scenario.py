"""The table of the demonstration while a person changes a relation: the cup leaves the plate."""

from __future__ import annotations

import dataclasses

import numpy as np

from spatial_relations_ros.core import Pose
from spatial_relations_ros.evaluation.demo_scenario import IMITATIONS, TABLE_HEIGHT, DemoObject

MOVED_ID = IMITATIONS[0].reference_ids[1]
# Where the cup is put down, from where it stood on the plate; towards the camera, on free table.
SHIFT = (-0.21, 0.0)
LIFT = 0.06
# Shares of the recording: it stands still, is lifted, carried and put down, stands still.
BEGIN, LIFTED, CARRIED, END = 0.25, 0.35, 0.60, 0.70


def objects_at(objects: tuple[DemoObject, ...], share: float) -> tuple[DemoObject, ...]:
    """The objects at a moment of the recording.

    Args:
        objects: at its begin.
        share: of the recording that is over, 0 to 1.
    """
    return tuple(
        dataclasses.replace(item, world_from_object=_carried(item, share))
        if item.object_id == MOVED_ID
        else item
        for item in objects
    )


def _carried(item: DemoObject, share: float) -> Pose:
    start = item.world_from_object.translation
    end_height = TABLE_HEIGHT + float(item.model.half_extents[2])
    top_height = start[2] + LIFT
    up, along, down = (
        _smooth((share - begin) / (end - begin))
        for begin, end in ((BEGIN, LIFTED), (LIFTED, CARRIED), (CARRIED, END))
    )
    height = start[2] + up * LIFT + down * (end_height - top_height)
    place = start[:2] + along * np.array(SHIFT)
    return Pose(np.array([*place, height]), item.world_from_object.quat_wxyz)


def _smooth(share: float) -> float:
    """From 0 to 1 without a jerk."""
    share = min(max(share, 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share)
