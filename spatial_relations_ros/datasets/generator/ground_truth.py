"""What is true of a scene, in numbers, beside its class."""

from __future__ import annotations

import numpy as np

from spatial_relations_ros.core import Pose
from spatial_relations_ros.core.rotations import tilt_angle_rad
from spatial_relations_ros.datasets.generator.scenes import GeneratedScene
from spatial_relations_ros.placement.body import FloatArray, Placed
from spatial_relations_ros.placement.footing import Footing, scene_extent
from spatial_relations_ros.placement.leaning import lean_angle_rad


def ground_truth(name: str, scene: GeneratedScene) -> dict[str, object]:
    """A scene's line in ``ground_truth.jsonl``; lengths in metres, angles in radians.

    Fields:
        scene, relation: name and label.
        table_height: world z of the table (the base's origin is at z = 0).
        extent: longest side of the bounding box of both; divide lengths by it to compare scenes.
        base_from_relative: ``t`` [x, y, z] and ``q_wxyz`` of the relative in the base's frame.
        base_tilt_rad, tilt_rad: angle of the z axis of base and relative to up.
        lean_rad: angle of the relative to the nearest orientation in which it rests level.
        offset: relative's minus base's centre of mass, world frame [x, y, z].
        footing_offset: horizontal distance between the middles of the relative's lowest level and
            of the base's part at or above it; null where the relative's foot is below all of it.
        overhang, overhang_share: largest reach of that foot beyond that part, negative when
            within; and as a share of the foot's width. Null as before.
        contact_height: lowest and highest contact between the objects above the table; null
            where they do not touch.
        contact_points: their number, not a measure of area.
        on_table: whether the relative touches the table.
        clearance: smallest signed distance between the objects.
        containment: share of the relative's surface within the base's convex hull.
        depth_share: share of the relative's extent along the base's z axis that is below the rim
            of the base's opening; null where it has none.
        overlap_z: share of the relative's height at which the base also is.
        size_ratio: cube root of the ratio of the bounding boxes' volumes, relative by base.
        rejected: candidates refused before this scene, by reason.
    """
    measured = scene.measured
    base, relative = measured.base, measured.relative
    in_base = Pose.from_rotation(
        base.rotation.T @ relative.rotation,
        base.rotation.T @ (relative.translation - base.translation),
    )
    offset = relative.centre_of_mass() - base.centre_of_mass()
    return {
        'scene': name,
        'relation': int(scene.relation),
        'table_height': _rounded(-float(base.translation[2])),
        'extent': _rounded(scene_extent(base, relative)),
        'base_from_relative': {
            't': [_rounded(value) for value in in_base.translation],
            'q_wxyz': [_rounded(value) for value in in_base.quat_wxyz],
        },
        'base_tilt_rad': _rounded(tilt_angle_rad(base.rotation)),
        'tilt_rad': _rounded(tilt_angle_rad(relative.rotation)),
        'lean_rad': _rounded(lean_angle_rad(relative)),
        'offset': [_rounded(value) for value in offset],
        **_footing(base, relative),
        'contact_height': _contact_height(scene),
        'contact_points': len(measured.contacts.base_relative),
        'on_table': len(measured.contacts.relative_table) > 0,
        'clearance': _rounded(measured.clearance),
        'containment': _rounded(containment(base, relative)),
        'depth_share': _depth_share(base, relative),
        'overlap_z': _overlap_z(base, relative),
        'size_ratio': _rounded(_size_ratio(base, relative)),
        'rejected': dict(sorted(scene.rejected.items())),
    }


def containment(base: Placed, relative: Placed) -> float:
    """Share of the relative's surface that is within the base's convex hull."""
    points = relative.body.face_points @ relative.rotation.T + relative.translation
    local = base.to_object(points).astype(np.float64)
    planes = base.body.hull_planes
    beyond = local @ planes[:, :3].T + planes[:, 3]
    return float((beyond.max(axis=1) < 1e-4).mean())


def _footing(base: Placed, relative: Placed) -> dict[str, float | None]:
    footing = Footing.of(base, relative)
    if not footing.is_carried:
        return {'footing_offset': None, 'overhang': None, 'overhang_share': None}
    return {
        'footing_offset': _rounded(float(footing.offset.max())),
        'overhang': _rounded(float(footing.overhang.max())),
        'overhang_share': _rounded(footing.overhang_share),
    }


def _contact_height(scene: GeneratedScene) -> list[float] | None:
    points = scene.measured.contacts.base_relative.points
    if not len(points):
        return None
    return [_rounded(points[:, 2].min()), _rounded(points[:, 2].max())]


def _depth_share(base: Placed, relative: Placed) -> float | None:
    opening = base.body.model.opening
    if opening is None:
        return None
    along = base.to_object(relative.world_vertices)[:, 2]
    share = (opening.rim_z - along.min()) / np.ptp(along)
    return _rounded(float(np.clip(share, 0.0, 1.0)))


def _overlap_z(base: Placed, relative: Placed) -> float:
    lower, upper = base.world_vertices[:, 2], relative.world_vertices[:, 2]
    shared = min(lower.max(), upper.max()) - max(lower.min(), upper.min())
    return _rounded(float(np.clip(shared / np.ptp(upper), 0.0, 1.0)))


def _size_ratio(base: Placed, relative: Placed) -> float:
    volumes = [float(np.prod(placed.body.model.half_extents)) for placed in (relative, base)]
    return float(np.cbrt(volumes[0] / volumes[1]))


def _rounded(value: float | FloatArray) -> float:
    return round(float(value), 5)
