"""What ``relations imitate`` writes for people: pictures, a report page, an animation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from rich.markup import escape

from spatial_relations_ros.cli.output import Output, check_file, progress_bar

if TYPE_CHECKING:
    from spatial_relations_ros.core import Pose, Scene
    from spatial_relations_ros.imitation import (
        ImitationAnswer,
        ImitationResult,
        ObjectPlacement,
    )
    from spatial_relations_ros.learning import RelationMetric
    from spatial_relations_ros.visualization import (
        ShownAnswer,
        ShownCheck,
        ShownImitation,
        ShownStep,
    )

REPORT_SUFFIXES = ('.html', '.htm')
ANIMATION_SUFFIXES = ('.gif', '.webp', '.mp4')
NUM_MOMENTS = 13


def check_suffix(path: Path | None, option: str, suffixes: tuple[str, ...]) -> None:
    """Refuses a file before the work that could not be written after it.

    Raises:
        typer.BadParameter: naming what would do.
    """
    if path is not None and path.suffix.lower() not in suffixes:
        raise typer.BadParameter(
            f'{option} takes a file that ends with {" or ".join(suffixes)}, got {path.name!r}'
        )
    check_file(path, option)


def shown_imitation(
    metric: RelationMetric,
    reference: Scene,
    test: Scene,
    result: ImitationResult,
    *,
    steps: Sequence[ShownStep] = (),
    table_height: float | None = None,
    title: str = '',
    is_timed: bool = True,
) -> ShownImitation:
    """The result as pages and animations take it; distances on the ways there are measured.

    Without ``is_timed`` it is the same each time.
    """
    from spatial_relations_ros.visualization import ShownImitation

    base, relative = test.object_ids
    facts = [
        ('demonstration', f'{reference.relative.object_id} to {reference.base.object_id}'),
        ('test objects', f'{relative} to {base}'),
        ('distance before', f'{result.initial_distance:.4f}'),
        *([('time', f'{result.duration_sec:.2f} s')] if is_timed else []),
        ('optimiser steps', str(result.num_steps)),
        ('weights', metric.model_hash[:12]),
    ]
    return ShownImitation(
        title
        or f'{relative} to {base} as {reference.relative.object_id} to {reference.base.object_id}',
        reference,
        test,
        tuple(
            _shown_answer(answer, result, measured_way(metric, reference, test, answer))
            for answer in result.answers
        ),
        tuple(steps),
        tuple(float(value) for value in result.distance_history),
        result.success,
        result.message,
        tuple(facts),
        table_height,
    )


def measured_way(
    metric: RelationMetric, reference: Scene, test: Scene, answer: ImitationAnswer
) -> tuple[ShownStep, ...]:
    """Moments on the straight way to an answer, with the distances that scenes there have."""
    import numpy as np

    from spatial_relations_ros.visualization import ShownStep, straight_way

    start = test.base.world_from_object, test.relative.world_from_object
    end = answer.placements[0].target, answer.placements[1].target
    ways = straight_way(start, end, NUM_MOMENTS)
    embeddings = metric.embed_scenes([reference, *(test.with_poses(*poses) for poses in ways)])
    distances = np.linalg.norm(embeddings[1:] - embeddings[0], axis=1)
    return tuple(
        ShownStep(poses, float(distance)) for poses, distance in zip(ways, distances, strict=True)
    )


def write_shown(
    output: Output, shown: ShownImitation, report: Path | None, animation: Path | None
) -> None:
    """Writes the files that were asked for, and says so."""
    from spatial_relations_ros.visualization import (
        animate_imitation,
        write_animation,
        write_report,
    )
    from spatial_relations_ros.visualization.animations import NUM_FRAMES

    if report is not None:
        write_report(report, [shown], title=shown.title)
        output.say(f'report: [bold]{escape(str(report))}[/]')
    if animation is not None:
        with progress_bar('pictures') as advance:
            frames = animate_imitation(shown, on_frame=lambda done: advance(done, NUM_FRAMES))
        write_animation(animation, frames)
        output.say(f'animation: [bold]{escape(str(animation))}[/]')


def _shown_answer(
    answer: ImitationAnswer, result: ImitationResult, way: tuple[ShownStep, ...]
) -> ShownAnswer:
    from spatial_relations_ros.visualization import ShownAnswer, ShownCheck

    nearer = answer.distance < result.initial_distance
    checks = [
        ShownCheck(
            'distance', f'{answer.distance:.4f}, before {result.initial_distance:.4f}', nearer
        ),
        ShownCheck('confidence', f'{100.0 * answer.confidence:.0f} %'),
        ShownCheck('feasible', 'yes' if answer.feasible else 'no', answer.feasible),
    ]
    checks += [ShownCheck('violated', violation, False) for violation in answer.violations]
    for role, placement in zip(('base', 'relative'), answer.placements, strict=True):
        checks += _placement_checks(role, placement)
    return ShownAnswer(
        (answer.placements[0].target, answer.placements[1].target),
        float(answer.distance),
        answer.feasible,
        tuple(checks),
        way,
    )


def _placement_checks(role: str, placement: ObjectPlacement) -> list[ShownCheck]:
    from spatial_relations_ros.visualization import ShownCheck

    name = f'{role} {placement.object_id}'
    if placement.current.is_close(placement.target, metres=1e-4, angle_rad=1e-3):
        return [ShownCheck(name, 'stays')]
    shift, turn = _motion(placement.current, placement.target)
    t = ', '.join(f'{value:.3f}' for value in placement.target.translation)
    q = ', '.join(f'{value:.3f}' for value in placement.target.quat_wxyz)
    return [
        ShownCheck(name, f'moves {100.0 * shift:.1f} cm, turns {turn:.0f}°'),
        ShownCheck('  target', f't {t}; q_wxyz {q}'),
        ShownCheck(
            '  deepest overlap', f'{1000.0 * placement.penetration:.1f} mm',
            placement.penetration < 0.005,
        ),
        ShownCheck('  carried from below', _word(placement.supported), placement.supported),
        ShownCheck('  way in is free', _word(placement.approach_clear), placement.approach_clear),
        ShownCheck('  in reach', _word(placement.reachable), placement.reachable),
    ]  # fmt: skip


def _motion(current: Pose, target: Pose) -> tuple[float, float]:
    """Metres and degrees between two poses."""
    import numpy as np

    shift = float(np.linalg.norm(target.translation - current.translation))
    cosine = abs(float(np.dot(current.quat_wxyz, target.quat_wxyz)))
    return shift, math.degrees(2.0 * math.acos(min(cosine, 1.0)))


def _word(passed: bool) -> str:
    return 'yes' if passed else 'no'
