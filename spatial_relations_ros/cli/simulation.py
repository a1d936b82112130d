"""Letting go what an imitation placed, in MuJoCo: ``--physics``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from spatial_relations_ros.core import Scene
    from spatial_relations_ros.imitation import ImitationResult

ROLES = ('base', 'relative')


def require_mujoco() -> None:
    """Fails before the work and not after it.

    Raises:
        ConfigError: where MuJoCo is not installed.
    """
    from spatial_relations_ros.placement.physics import settle

    settle(())


def simulated_answers(
    result: ImitationResult, test: Scene, table_height: float | None
) -> list[dict[str, Any]]:
    """How far the objects of each answer move within a second; nothing is held fixed.

    Args:
        result: of the imitation.
        test: the objects where they stood.
        table_height: of the table, metres; None takes the lowest point of the test objects.
    """
    from spatial_relations_ros.imitation.contact import Body, lowest_point
    from spatial_relations_ros.imitation.shape import shape_of
    from spatial_relations_ros.imitation.solids import solid_of
    from spatial_relations_ros.placement.physics import settle

    shapes = [shape_of(item) for item in test.objects]
    bodies = [
        Body(shape, item.world_from_object)
        for shape, item in zip(shapes, test.objects, strict=True)
    ]
    table = lowest_point(bodies) if table_height is None else table_height
    entries = []
    for answer in result.answers:
        motions = settle(
            [
                solid_of(shape, 1.0).placed(placement.target, (0.0, 0.0, table))
                for shape, placement in zip(shapes, answer.placements, strict=True)
            ]
        )
        entry: dict[str, Any] = {
            role: {'shift': round(motion.shift, 4), 'turn_rad': round(motion.turn_rad, 4)}
            for role, motion in zip(ROLES, motions, strict=True)
        }
        entries.append({**entry, 'stays': all(motion.stayed for motion in motions)})
    return entries
