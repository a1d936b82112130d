"""``relations embed`` and ``relations distance``."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from spatial_relations_ros.cli.options import (
    DataOption,
    ObjectsOption,
    ReferenceBase,
    ReferenceName,
    ReferencePoses,
    ReferenceRelative,
    SceneBase,
    SceneName,
    ScenePoses,
    SceneRelative,
    TestBase,
    TestName,
    TestPoses,
    TestRelative,
    WeightsOption,
)
from spatial_relations_ros.cli.output import JsonOption, Output
from spatial_relations_ros.cli.scene_sources import SceneSource

if TYPE_CHECKING:
    from spatial_relations_ros.learning import Comparison


def embed(
    scene: SceneName = None,
    data: DataOption = None,
    base: SceneBase = None,
    relative: SceneRelative = None,
    poses: ScenePoses = None,
    objects: ObjectsOption = None,
    weights: WeightsOption = None,
    json_path: JsonOption = None,
) -> None:
    """Embed a scene: where the metric places its relation."""
    output = Output(json_path)
    loaded = SceneSource('', scene, data, base, relative, poses, objects=objects).load()
    from spatial_relations_ros.learning import load_metric

    metric = load_metric(weights)
    embedding = metric.embed_scenes([loaded])[0]
    output.say(' '.join(f'{value:.4f}' for value in embedding))
    novelty = float(metric.novelty(embedding))
    if novelty > 1.0:
        output.say(f'novel: {novelty:.1f} times as far from everything known as the limit')
    output.write_json(
        {
            'object_ids': loaded.object_ids,
            'embedding': embedding,
            'novelty': novelty,
            'is_novel': None if math.isnan(novelty) else novelty > 1.0,
            'model_hash': metric.model_hash,
        }
    )


def distance(
    reference: ReferenceName = None,
    test: TestName = None,
    data: DataOption = None,
    reference_base: ReferenceBase = None,
    reference_relative: ReferenceRelative = None,
    reference_poses: ReferencePoses = None,
    test_base: TestBase = None,
    test_relative: TestRelative = None,
    test_poses: TestPoses = None,
    objects: ObjectsOption = None,
    weights: WeightsOption = None,
    json_path: JsonOption = None,
) -> None:
    """Distance of two scenes under the metric, small for like relations, and what it means."""
    output = Output(json_path)
    first = SceneSource(
        'reference',
        reference,
        data,
        reference_base,
        reference_relative,
        reference_poses,
        objects=objects,
    ).load()
    second = SceneSource(
        'test', test, data, test_base, test_relative, test_poses, objects=objects
    ).load()
    from spatial_relations_ros.learning import load_metric

    metric = load_metric(weights)
    compared = metric.compare(first, second)
    output.say(f'{compared.distance:.6f}')
    if metric.calibration is None:
        output.say('these weights carry no calibration: what the distance means is not known')
    else:
        output.say(
            f'the same relation with a probability of {compared.same_relation_probability:.3f} '
            f'(even odds at {metric.calibration.same_relation_distance:.3f})'
        )
    for title, novelty, is_novel in zip(
        ('reference', 'test'), compared.novelty, compared.is_novel, strict=True
    ):
        if is_novel:
            output.say(
                f'{title}: novel, {novelty:.1f} times as far from everything known as the limit; '
                'do not rely on the distance'
            )
    output.write_json(
        {
            'distance': compared.distance,
            'same_relation_probability': compared.same_relation_probability,
            'same_relation_distance': None
            if metric.calibration is None
            else metric.calibration.same_relation_distance,
            'reference': _novelty_entry(compared, 0),
            'test': _novelty_entry(compared, 1),
            'model_hash': metric.model_hash,
        }
    )


def _novelty_entry(compared: Comparison, idx: int) -> dict[str, float | bool | None]:
    novelty = compared.novelty[idx]
    is_known = not math.isnan(novelty)
    return {'novelty': novelty, 'is_novel': compared.is_novel[idx] if is_known else None}
