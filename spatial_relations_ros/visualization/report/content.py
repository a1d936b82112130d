"""The data of a report page, as JSON can hold it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from spatial_relations_ros.core import Pose, Scene
from spatial_relations_ros.visualization.palette import OBJECT_COLOURS
from spatial_relations_ros.visualization.report.models import ModelStore
from spatial_relations_ros.visualization.shown_imitation import (
    ShownAnswer,
    ShownImitation,
    ShownStep,
    lowest_point,
    way_to,
)

ROLES = ('base', 'relative')


def report_content(
    imitations: Sequence[ShownImitation], *, title: str, num_triangles: int
) -> dict[str, Any]:
    """Everything that the page's script needs.

    Keys: ``title``, ``colours`` (of base and relative, sRGB 0 to 1), ``models`` (see
    :class:`ModelStore`), ``cases`` (one an imitation: ``reference`` and ``test`` scenes,
    ``answers`` with their ``way`` of steps and table of ``checks``, ``history``, ``facts``).
    Poses are [x, y, z, qw, qx, qy, qz], world_from_object, metres.
    """
    store = ModelStore(num_triangles)
    cases = [_case(shown, store) for shown in imitations]
    return {
        'title': title,
        'colours': [list(colour) for colour in OBJECT_COLOURS[:2]],
        'models': store.models,
        'cases': cases,
    }


def _case(shown: ShownImitation, store: ModelStore) -> dict[str, Any]:
    return {
        'title': shown.title,
        'success': shown.success,
        'message': shown.message,
        'reference': scene_content(shown.reference, lowest_point(shown.reference), store),
        'test': scene_content(shown.before, shown.table, store),
        'answers': [_answer(shown, idx, answer) for idx, answer in enumerate(shown.answers)],
        'history': [_number(value) for value in shown.history],
        'facts': [list(fact) for fact in shown.facts],
    }


def scene_content(scene: Scene, table: float, store: ModelStore) -> dict[str, Any]:
    """A scene: ``table`` (world z) and ``objects`` with ``role``, ``id``, ``model``, ``pose``."""
    return {
        'table': round(table, 6),
        'objects': [
            {
                'role': role,
                'id': item.object_id,
                'model': store.add(item),
                'pose': pose_content(item.world_from_object),
            }
            for role, item in zip(ROLES, scene.objects, strict=True)
        ],
    }


def _answer(shown: ShownImitation, idx: int, answer: ShownAnswer) -> dict[str, Any]:
    way = way_to(shown, idx)
    return {
        'distance': _number(answer.distance),
        'feasible': answer.feasible,
        'checks': [[check.name, check.value, check.passed] for check in answer.checks],
        'way': [_step(step) for step in way],
        # Else a straight line that nobody walked, whose distances were measured afterwards.
        'recorded': idx == 0 and len(way) > 2 and way is not answer.way,
    }


def _step(step: ShownStep) -> dict[str, Any]:
    return {
        'poses': [pose_content(pose) for pose in step.poses],
        'distance': _number(step.distance),
        'step': step.step,
        'feasible': step.feasible,
    }


def pose_content(pose: Pose) -> list[float]:
    """A pose as [x, y, z, qw, qx, qy, qz]."""
    return [round(float(value), 6) for value in (*pose.translation, *pose.quat_wxyz)]


def _number(value: float | None) -> float | None:
    """JSON has no NaN."""
    return None if value is None or not math.isfinite(value) else round(float(value), 6)
