"""Options about the robot and what else stands around."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from spatial_relations_ros.cli.options import file_option

if TYPE_CHECKING:
    from spatial_relations_ros.core import Pose, Scene
    from spatial_relations_ros.imitation import ArmReach, Obstacle

ObstaclesOption = Annotated[
    list[Path] | None,
    file_option(
        '--obstacles',
        what='Cloud or mesh, in the world frame, that must not be touched; may be repeated.',
    ),
]
GraspOption = Annotated[
    Path | None,
    file_option(
        '--grasp', what='JSON of object_from_gripper of "base", "relative" or both.'
    ),
]  # fmt: skip
ShoulderOption = Annotated[
    list[str] | None,
    typer.Option(
        '--shoulder', metavar='X,Y,Z', show_default=False,
        help="An arm's shoulder in the world, metres; may be repeated. Without, reach is free.",
    ),
]  # fmt: skip
ReachNearest = Annotated[
    float | None,
    typer.Option(
        '--reach-min', min=0.0, show_default=False, help='From the shoulder, metres; 0.25.'
    ),
]
ReachFarthest = Annotated[
    float | None,
    typer.Option(
        '--reach-max', min=0.0, show_default=False, help='From the shoulder, metres; 0.85.'
    ),
]
ApproachOption = Annotated[
    float | None,
    typer.Option(
        '--approach-height', min=0.0, show_default=False,
        help='Length of the straight way into the target, metres; 0.1.',
    ),
]  # fmt: skip


def robot_options(
    test: Scene,
    obstacles: list[Path] | None,
    grasp: Path | None,
    approach_height: float | None,
    shoulders: list[str] | None,
    reach: tuple[float | None, float | None],
) -> dict[str, Any]:
    """The arguments of ``ImitationOptions`` that the command line gives.

    Raises:
        SpatialRelationsError: for files that cannot be used.
        typer.BadParameter: for a shoulder that is no position, or a reach without one.
    """
    given: dict[str, Any] = {'obstacles': tuple(_obstacle(path) for path in obstacles or ())}
    if grasp is not None:
        given['grasps'] = _grasps(grasp, test)
    if approach_height is not None:
        given['approach_height'] = approach_height
    if shoulders:
        given['arm'] = _arm(shoulders, reach)
    elif reach != (None, None):
        raise typer.BadParameter('--reach-min and --reach-max need --shoulder X,Y,Z')
    return given


def _obstacle(path: Path) -> Obstacle:
    from spatial_relations_ros.core import Pose, SceneObject
    from spatial_relations_ros.datasets.object_files import load_object_model
    from spatial_relations_ros.imitation import Obstacle

    mesh, points = load_object_model(path, may_have_holes=True)
    if mesh is None:
        return Obstacle.of_cloud(points, path.stem)
    return Obstacle.of_object(SceneObject(path.stem, points, Pose(), mesh=mesh))


def _grasps(path: Path, test: Scene) -> dict[str, Pose]:
    from spatial_relations_ros.cli.pose_files import read_grasp_file

    return {
        getattr(test, role).object_id: object_from_gripper
        for role, object_from_gripper in read_grasp_file(path).items()
    }


def _arm(shoulders: list[str], reach: tuple[float | None, float | None]) -> ArmReach:
    import numpy as np

    from spatial_relations_ros.imitation import ArmReach

    positions = []
    for text in shoulders:
        try:
            position = [float(part) for part in text.split(',')]
        except ValueError:
            position = []
        if len(position) != 3:
            raise typer.BadParameter(f'--shoulder is {text!r}; expected X,Y,Z in metres')
        positions.append(position)
    nearest, farthest = reach
    return ArmReach(
        np.array(positions),
        ArmReach.nearest if nearest is None else nearest,
        ArmReach.farthest if farthest is None else farthest,
    )
