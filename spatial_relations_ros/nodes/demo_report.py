"""What a demonstration leaves behind: numbers, a table to read, and pictures."""

from __future__ import annotations

import dataclasses
import json
import math
import platform
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from spatial_relations_ros import __version__
from spatial_relations_ros.core import Pose, Scene, atomic_write
from spatial_relations_ros.learning import RelationMetric
from spatial_relations_ros.nodes.demo_plan import PlannedImitation
from spatial_relations_ros.perception.messages import read_pose
from spatial_relations_ros.visualization import write_imitation_pictures

SCHEMA = 'spatial_relations_ros/demo/1'


@dataclass(frozen=True, eq=False)
class DemoOutcome:
    """One request and what came of it.

    Attributes:
        plan: what was asked.
        reference: the demonstration as perception saw it.
        test: the objects to place, where they stood.
        response: of the service.
        target_poses: PoseArray received on the topic, None when none came.
    """

    plan: PlannedImitation
    reference: Scene
    test: Scene
    response: Any
    target_poses: Any | None

    @property
    def targets(self) -> tuple[Pose, ...]:
        """``world_from_object`` of the test objects, as received on the topic."""
        if self.target_poses is None:
            return ()
        return tuple(read_pose(pose) for pose in self.target_poses.poses)

    @property
    def final_distance(self) -> float:
        """Metric distance of the best answer; NaN without one."""
        answers = self.response.answers
        return float(answers[0].distance) if answers else math.nan

    @property
    def problem(self) -> str:
        """Why this is not what was asked for; empty when it is."""
        if not self.response.answers:
            return self.response.message or 'no answer'
        if self.target_poses is None:
            return f'no target poses were published: {self.response.message}'
        if not self.final_distance < self.response.initial_distance:
            return 'the distance did not fall'
        return ''

    def after(self) -> Scene | None:
        """The test scene with the objects at their received targets."""
        return self.test.with_poses(*self.targets) if len(self.targets) == 2 else None

    def as_json(self) -> dict[str, Any]:
        """Everything in numbers; poses are in the world frame, metres."""
        best = self.response.answers[0] if self.response.answers else None
        return {
            **dataclasses.asdict(self.plan),
            'success': bool(self.response.success),
            'message': self.response.message,
            'problem': self.problem,
            'frame_id': self.test.frame_id,
            'stamp_ns': self.test.stamp_ns,
            'target_poses': {
                object_id: _pose_json(pose)
                for object_id, pose in zip(self.plan.test_ids, self.targets, strict=False)
            },
            'current_poses': {
                item.object_id: _pose_json(item.world_from_object) for item in self.test.objects
            },
            'initial_distance': float(self.response.initial_distance),
            'final_distance': self.final_distance,
            'feasible': bool(best.feasible) if best else None,
            'violations': list(best.violations) if best else [],
            'confidence': float(best.confidence) if best else None,
            'penetration': {t.object_id: float(t.penetration) for t in best.targets}
            if best
            else {},
            'num_answers': len(self.response.answers),
            'duration_sec': float(self.response.duration),
            'distance_history': [float(value) for value in self.response.distance_history],
        }


def _pose_json(pose: Pose) -> dict[str, list[float]]:
    return {'t': pose.translation.tolist(), 'q_wxyz': pose.quat_wxyz.tolist()}


def write_result(
    path: Path, outcomes: list[DemoOutcome], *, seen: dict[str, int], model_hash: str
) -> None:
    """Writes result.json.

    Args:
        path: of the file.
        outcomes: of all requests.
        seen: number of scenes received of each "base/relative".
        model_hash: of the weights.
    """
    content = {
        'schema': SCHEMA,
        'success': all(not outcome.problem for outcome in outcomes),
        'imitations': [outcome.as_json() for outcome in outcomes],
        'scenes_received': seen,
        'model_sha256': model_hash,
        'versions': {
            'spatial_relations_ros': __version__,
            'python': platform.python_version(),
            **{name: version(name) for name in ('torch', 'numpy', 'open3d')},
        },
    }
    with atomic_write(path) as temporary:
        temporary.write_text(json.dumps(_finite(content), indent=2, allow_nan=False) + '\n')


def _finite(value: Any) -> Any:
    """The value for JSON, which has no NaN: null in its place."""
    if isinstance(value, dict):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def write_pictures(folder: Path, outcome: DemoOutcome, metric: RelationMetric) -> int:
    """Writes the pictures of one outcome, without an answer those of before; returns how many."""
    paths = write_imitation_pictures(
        folder,
        reference=outcome.reference,
        before=outcome.test,
        after=outcome.after(),
        projections=metric.projections,
        distance_history=list(outcome.response.distance_history),
    )
    return len(paths)


def print_outcome(console: Console, outcome: DemoOutcome) -> None:
    """A table of one outcome."""
    plan, response = outcome.plan, outcome.response
    table = Table(
        title=f'{" / ".join(plan.test_ids)}  like  {" / ".join(plan.reference_ids)}',
        title_justify='left',
    )
    for column in ('object', 'target x y z (m)', 'target quaternion w x y z', 'moved (m)'):
        table.add_column(column)
    for item, target in zip(outcome.test.objects, outcome.targets, strict=False):
        moved = target.translation - item.world_from_object.translation
        table.add_row(
            item.object_id,
            _numbers(target.translation.tolist()),
            _numbers(target.quat_wxyz.tolist()),
            f'{float((moved**2).sum()) ** 0.5:.3f}',
        )
    console.print(table)
    best = response.answers[0] if response.answers else None
    feasible = 'no answer' if best is None else 'yes' if best.feasible else 'no'
    console.print(
        f'  distance {response.initial_distance:.3f} before, {outcome.final_distance:.3f} after; '
        f'feasible: {feasible}; {response.duration:.1f} s'
    )
    for violation in best.violations if best else ():
        console.print(f'  violation: {violation}', markup=False, soft_wrap=True)
    if outcome.problem:
        console.print('  [red]problem:[/red]', end=' ')
        console.print(outcome.problem, markup=False, soft_wrap=True)


def _numbers(values: list[float]) -> str:
    return ' '.join(f'{value:+.3f}' for value in values)
