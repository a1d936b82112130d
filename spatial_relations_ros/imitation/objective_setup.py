"""From the scenes of a request to what is minimised."""

from __future__ import annotations

import numpy as np
import torch

from spatial_relations_ros.core import ImitationError, Scene
from spatial_relations_ros.imitation.contact import Body, lowest_point
from spatial_relations_ros.imitation.layout import Layout
from spatial_relations_ros.imitation.objective import Objective
from spatial_relations_ros.imitation.options import ImitationOptions
from spatial_relations_ros.imitation.shape import shape_of
from spatial_relations_ros.learning import RelationMetric
from spatial_relations_ros.projection import resample_points


def make_objective(
    metric: RelationMetric, reference: Scene, test: Scene, options: ImitationOptions
) -> Objective:
    """Measures both scenes once.

    Raises:
        ImitationError: when the test objects are so large or far apart that the numbers are not
            usable.
    """
    sizes = [float(np.linalg.norm(np.ptp(item.points, axis=0))) for item in test.objects]
    extent = sum(sizes)
    if not 1e-4 < extent < 1e3:
        raise ImitationError(
            f'the test objects are {sizes[0]:.3g} m and {sizes[1]:.3g} m large; '
            'clouds and poses must be in metres'
        )
    shapes = tuple(shape_of(item) for item in test.objects)
    bodies = [
        Body(shape, item.world_from_object)
        for shape, item in zip(shapes, test.objects, strict=True)
    ]
    table = options.table_height
    clouds = np.stack([resample_points(item.points, metric.num_points) for item in test.objects])
    return Objective(
        metric=metric,
        clouds=torch.from_numpy(clouds),
        shapes=(shapes[0], shapes[1]),
        reference_embedding=torch.from_numpy(metric.embed_scenes([reference])[0]),
        extent=extent,
        origin=np.array(test.base.world_from_object.translation),
        table_height=lowest_point(bodies) if table is None else table,
        physics_weight=options.physics_weight,
        heading=_heading(reference) if options.keep_heading else None,
        layout=_layout(reference, metric.num_points),
        layout_weight=options.layout_weight,
    )


def _heading(reference: Scene) -> torch.Tensor | None:
    """Horizontal direction from the base's to the relative object's middle, if there is one."""
    base, relative = (item.world_points.mean(axis=0)[:2] for item in reference.objects)
    offset = relative - base
    length = float(np.linalg.norm(offset))
    return torch.from_numpy(offset / length) if length > 1e-3 else None


def _layout(reference: Scene, num_points: int) -> Layout:
    clouds = [resample_points(item.points, num_points) for item in reference.objects]
    poses = [item.world_from_object for item in reference.objects]
    world = [pose.apply(cloud) for pose, cloud in zip(poses, clouds, strict=True)]
    # From the base, for the sake of single precision.
    return Layout.of(torch.from_numpy(np.stack(world) - poses[0].translation)[None].float())
