"""The paper's second experiment: objects that no scene of the data has, next to each other."""

from __future__ import annotations

import re
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import DatasetFormatError, Scene, TriangleMesh
from spatial_relations_ros.datasets.object_files import load_object_model, model_paths
from spatial_relations_ros.datasets.solidify import solid_from_cloud, watertight
from spatial_relations_ros.evaluation.generalization.cases import DENSITY, Experiment
from spatial_relations_ros.evaluation.generalization.pairing import Reference, paired_experiment
from spatial_relations_ros.evaluation.generalization.placed_scenes import scene_of_placed
from spatial_relations_ros.placement.body import Body, Placed
from spatial_relations_ros.placement.model import ObjectModel
from spatial_relations_ros.placement.resting import about_z, half_width

UNKNOWN = 'unknown'
LARGEST_EXTENT = 0.15

_GAP = 0.05
_STREAM = 12
FloatArray = NDArray[np.float64]

_Y_UP: FloatArray = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
# -z up, so that the box opens upwards.
_TURNED_OVER: FloatArray = np.diag([1.0, -1.0, -1.0])
# Where the paper's objects have their upper side; others have z up.
UPRIGHT: Mapping[str, FloatArray] = {
    'armadillo': _Y_UP,
    'bunny': _Y_UP,
    'teapot': _Y_UP,
    'torus': np.eye(3),
    'open_box': _TURNED_OVER,
}


@dataclass(frozen=True, eq=False)
class StandingPair:
    """Two objects next to each other on the table z = 0."""

    name: str
    scene: Scene


def load_unknown_objects(folder: Path) -> list[ObjectModel]:
    """Reads all models of a folder, sorted by name, as solids.

    Each is turned upright, scaled to 15 cm in its largest extent, and made watertight: clouds are
    taken for the surface of a solid. Its frame is in the middle of its bounding box.

    Raises:
        DatasetFormatError: for a folder without two models.
        CloudFormatError: for a file that cannot be read.
    """
    paths = model_paths(folder.iterdir()) if folder.is_dir() else {}
    if len(paths) < 2:
        raise DatasetFormatError(
            f'{folder} holds {len(paths)} models (ply, pcd, obj, stl, off); pairs need two'
        )
    return [_load(name, paths[name]) for name in sorted(paths)]


def _load(name: str, path: Path) -> ObjectModel:
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')  # units are not metres: everything is scaled anyway
        mesh, points = load_object_model(path)
    turn = UPRIGHT.get(name, np.eye(3))
    scale = LARGEST_EXTENT / float(np.ptp(points, axis=0).max())
    if mesh is None:
        solid = solid_from_cloud(_upright(points, turn, scale))
    else:
        solid = watertight(TriangleMesh(_upright(mesh.vertices, turn, scale), mesh.triangles))
    low, high = solid.vertices.min(axis=0), solid.vertices.max(axis=0)
    centred = TriangleMesh(solid.vertices - 0.5 * (low + high), solid.triangles)
    # Scene names join object names by underscores.
    return ObjectModel(re.sub(r'[\W_]', '', name), '', centred, {}, None, DENSITY)


def _upright(points: NDArray[np.float32], turn: FloatArray, scale: float) -> NDArray[np.float32]:
    return (scale * (points.astype(np.float64) @ turn.T)).astype(np.float32)


def pairs_of(models: Sequence[ObjectModel], *, seed: int) -> list[StandingPair]:
    """All ordered pairs, each standing upright 5 cm apart at random headings.

    Raises:
        DatasetFormatError: for an object that stands in no way.
    """
    bodies = [Body.of(model) for model in models]
    pairs: list[StandingPair] = []
    for base in bodies:
        for relative in bodies:
            if relative is base:
                continue
            rng = np.random.default_rng([seed, _STREAM, len(pairs)])
            fixed, moving = (
                _standing(body, rng.uniform(0.0, 2.0 * np.pi)) for body in (base, relative)
            )
            axis = np.array([1.0, 0.0, 0.0])
            reach = half_width(fixed, axis) + half_width(moving, axis) + _GAP
            middles = [_middle(placed) for placed in (fixed, moving)]
            moving = moving.moved(axis * (middles[0] + reach - middles[1]))
            pairs.append(
                StandingPair(
                    f'{base.model.name}_{relative.model.name}_{len(pairs)}',
                    scene_of_placed(fixed, moving),
                )
            )
    return pairs


def _standing(body: Body, heading_rad: float) -> Placed:
    """A body on the table, in that way to rest in which its z axis is most upright."""
    poses = body.model.rest_poses
    if not poses:
        raise DatasetFormatError(f'{body.model.name} stands on no side')
    pose = max(poses, key=lambda pose: pose.rotation[2, 2])
    return Placed(body, about_z(heading_rad) @ pose.rotation, np.zeros(3)).on_table()


def _middle(placed: Placed) -> float:
    """Middle of a body's extent along x, metres."""
    along = placed.world_vertices[:, 0]
    return 0.5 * float(along.min() + along.max())


def unknown_experiment(
    references: Sequence[Reference], pairs: Sequence[StandingPair]
) -> Experiment:
    """All references imitated with all pairs, less impossible ones."""
    tests = [(pair.name, pair.scene) for pair in pairs]
    return paired_experiment(
        UNKNOWN,
        f'{len(references)} scenes, each imitated with {len(pairs)} pairs of objects that stand '
        'next to each other; both objects may move',
        [(reference, tests) for reference in references],
    )
