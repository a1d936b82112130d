"""How well wrong poses are told from right ones, and what refinement gains, on simulated captures.

    python -m spatial_relations_ros.evaluation.tracking_accuracy --scenes 3

The table of the demonstration with drawn objects before a simulated Kinect2; each object's true
pose is moved in random directions and turned about random axes.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from spatial_relations_ros.core import Pose, SpatialRelationsError, atomic_write
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.datasets.kinect_simulator import SD_CAMERA, KinectSimulator
from spatial_relations_ros.evaluation.demo_scenario import (
    TABLE_HEIGHT,
    DemoObject,
    make_scenario,
    scenario_surfaces,
    world_from_camera,
)
from spatial_relations_ros.perception.camera import estimate_camera
from spatial_relations_ros.perception.evidence import SupportConfig, support_at
from spatial_relations_ros.perception.object_models import KnownModel
from spatial_relations_ros.perception.point_cloud2 import PointCloud
from spatial_relations_ros.perception.refine import PoseRefiner
from spatial_relations_ros.perception.table import Plane
from spatial_relations_ros.perception.view import View

# Shift in metres and turn in degrees of a wrong pose.
ERRORS = (
    (0.0, 0),
    (0.005, 2),
    (0.01, 3),
    (0.02, 6),
    (0.03, 8),
    (0.05, 10),
    (0.08, 15),
    (0.12, 20),
)
REFINED_ERRORS = ((0.003, 1), (0.01, 3), (0.02, 6))
MODEL_POINTS = 20_000


@dataclass(frozen=True)
class SupportRow:
    """Support of poses with one error.

    Attributes:
        shift: of the pose, metres.
        turn_deg: of the pose.
        num_poses: how many were tried.
        quantiles: 1, 50 and 99 % of the support.
        refused: share below ``min_support``.
        refused_new: share below what a new pose needs.
    """

    shift: float
    turn_deg: float
    num_poses: int
    quantiles: tuple[float, float, float]
    refused: float
    refused_new: float


@dataclass(frozen=True)
class RefinedRow:
    """Poses with one error before and after refinement.

    Distances are from the model's points to its surface at the true pose, in the mean over the
    points (ADD-S: Hinterstoisser et al., ACCV 2012), metres.

    Attributes:
        shift: of the pose, metres.
        turn_deg: of the pose.
        num_poses: how many were tried.
        before: median and 90 % quantile.
        after: median and 90 % quantile.
        accepted: share of the poses that were changed.
        worse: share of the poses that are worse than before.
        median_cpu_ms: processor time of one refinement, all threads.
    """

    shift: float
    turn_deg: float
    num_poses: int
    before: tuple[float, float]
    after: tuple[float, float]
    accepted: float
    worse: float
    median_cpu_ms: float


@dataclass(frozen=True, eq=False)
class _Capture:
    objects: tuple[DemoObject, ...]
    models: dict[str, KnownModel]
    view: View


def support_rows(
    captures: Sequence[_Capture], config: SupportConfig, *, repeats: int, seed: int
) -> list[SupportRow]:
    """Support over the size of the error; the same seed gives the same rows."""
    rng = np.random.default_rng([seed, 1])
    rows = []
    for shift, turn_deg in ERRORS:
        supports = np.array(
            [
                support_at(
                    capture.models[item.object_id].support_points,
                    _wrong(item.world_from_object, shift, turn_deg, rng),
                    capture.view,
                    config.tolerance,
                )
                for capture in captures
                for item in capture.objects
                for _ in range(repeats)
            ]
        )
        supports = supports[~np.isnan(supports)]
        low, middle, high = np.quantile(supports, [0.01, 0.5, 0.99]).tolist()
        refused = float((supports < config.min_support).mean())
        refused_new = float((supports < config.good_support).mean())
        rows.append(
            SupportRow(shift, turn_deg, len(supports), (low, middle, high), refused, refused_new)
        )
    return rows


def refined_rows(captures: Sequence[_Capture], *, repeats: int, seed: int) -> list[RefinedRow]:
    """Errors before and after refinement; all but the times repeats for a seed."""
    rng = np.random.default_rng([seed, 2])
    refiner = PoseRefiner()
    rows = []
    for shift, turn_deg in REFINED_ERRORS:
        tried = np.array(
            [
                result
                for capture in captures
                for _ in range(repeats)
                for result in _refine_all(refiner, capture, shift, turn_deg, rng)
            ]
        )
        before, after, changed, seconds = tried.T
        rows.append(
            RefinedRow(
                shift,
                turn_deg,
                len(tried),
                (float(np.median(before)), float(np.quantile(before, 0.9))),
                (float(np.median(after)), float(np.quantile(after, 0.9))),
                float(changed.mean()),
                float((after > before).mean()),
                1e3 * float(np.median(seconds)),
            )
        )
    return rows


def make_captures(num_scenes: int, *, seed: int) -> list[_Capture]:
    """Simulated clouds of drawn tables."""
    captures: list[_Capture] = []
    scene_seed = seed
    while len(captures) < num_scenes:
        try:
            objects = make_scenario(scene_seed)
        except SpatialRelationsError:  # some seeds have no objects that fit each other
            continue
        finally:
            scene_seed += 1
        simulator = KinectSimulator(scenario_surfaces(objects), world_from_camera(), SD_CAMERA)
        cloud = PointCloud(simulator.xyz(simulator.measure(np.random.default_rng(scene_seed))))
        table = Plane(np.array([0.0, 0.0, 1.0]), TABLE_HEIGHT)
        view = View(cloud, estimate_camera(cloud), world_from_camera().as_matrix(), table)
        models = {
            item.object_id: KnownModel(
                item.model.mesh.sample_surface(MODEL_POINTS, np.random.default_rng(0)),
                item.model.mesh,
            )
            for item in objects
        }
        captures.append(_Capture(objects, models, view))
    return captures


def _wrong(pose: Pose, shift: float, turn_deg: float, rng: np.random.Generator) -> Pose:
    direction, axis = (vector / np.linalg.norm(vector) for vector in rng.normal(size=(2, 3)))
    turn = matrix_from_rotvec(np.deg2rad(turn_deg) * axis)
    return Pose.from_rotation(turn @ pose.rotation, pose.translation + shift * direction)


def _refine_all(
    refiner: PoseRefiner,
    capture: _Capture,
    shift: float,
    turn_deg: float,
    rng: np.random.Generator,
) -> Iterator[tuple[float, float, bool, float]]:
    """Of each object: distance before, after, whether it was changed, seconds; lowest first."""
    truths = {item.object_id: item.world_from_object for item in capture.objects}
    poses = {
        key: (capture.models[key], _wrong(truth, shift, turn_deg, rng))
        for key, truth in truths.items()
    }
    for key in sorted(poses, key=lambda name: float(poses[name][1].translation[2])):
        model, pose = poses[key]
        others = [poses[other] for other in poses if other != key]
        start = time.process_time()
        refined = refiner.refined(model, pose, capture.view, others)
        seconds = time.process_time() - start
        poses[key] = model, refined
        surface = cKDTree(truths[key].apply(model.points))
        before, after = (
            float(surface.query(at.apply(model.support_points))[0].mean())
            for at in (pose, refined)
        )
        yield before, after, refined is not pose, seconds


def main(arguments: Sequence[str] | None = None) -> int:
    """The command: see the module."""
    parser = argparse.ArgumentParser(description='Measures support and refinement of poses.')
    parser.add_argument('--scenes', type=int, default=3)
    parser.add_argument('--repeats', type=int, default=10)
    parser.add_argument('--seed', type=int, default=5)
    parser.add_argument('--json', type=Path)
    args = parser.parse_args(arguments)
    captures = make_captures(args.scenes, seed=args.seed)
    supports = support_rows(captures, SupportConfig(), repeats=args.repeats, seed=args.seed)
    print('shift cm  turn deg  support 1, 50, 99 %   refused %  refused when new %')
    for row in supports:
        quantiles = ', '.join(f'{value:.2f}' for value in row.quantiles)
        print(
            f'{100 * row.shift:8.1f}  {row.turn_deg:8.0f}  {quantiles:>20}  '
            f'{100 * row.refused:9.1f}  {100 * row.refused_new:9.1f}'
        )
    refined = refined_rows(captures, repeats=args.repeats, seed=args.seed)
    print('shift cm  turn deg  ADD-S mm before (p90)   after (p90)  changed %  worse %  CPU ms')
    for item in refined:
        before, after = (
            f'{1e3 * median:.2f} ({1e3 * p90:.2f})' for median, p90 in (item.before, item.after)
        )
        print(
            f'{100 * item.shift:8.1f}  {item.turn_deg:8.0f}  {before:>21}  {after:>12}  '
            f'{100 * item.accepted:9.0f}  {100 * item.worse:7.1f}  {item.median_cpu_ms:6.1f}'
        )
    if args.json is not None:
        content = {
            'support': [asdict(row) for row in supports],
            'refined': [asdict(item) for item in refined],
        }
        with atomic_write(args.json) as temporary:
            temporary.write_text(json.dumps(content, indent=1) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
