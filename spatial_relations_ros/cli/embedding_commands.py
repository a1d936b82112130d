"""``relations embed`` and ``relations distance``."""

from __future__ import annotations

from spatial_relations_ros.cli.options import (
    DataOption,
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


def embed(
    scene: SceneName = None,
    data: DataOption = None,
    base: SceneBase = None,
    relative: SceneRelative = None,
    poses: ScenePoses = None,
    weights: WeightsOption = None,
    json_path: JsonOption = None,
) -> None:
    """Embed a scene: where the metric places its relation."""
    output = Output(json_path)
    loaded = SceneSource('', scene, data, base, relative, poses).load()
    from spatial_relations_ros.learning import load_metric

    metric = load_metric(weights)
    embedding = metric.embed_scenes([loaded])[0]
    output.say(' '.join(f'{value:.4f}' for value in embedding))
    output.write_json(
        {
            'object_ids': loaded.object_ids,
            'embedding': embedding,
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
    weights: WeightsOption = None,
    json_path: JsonOption = None,
) -> None:
    """Distance of two scenes under the metric: small for like relations."""
    output = Output(json_path)
    first = SceneSource(
        'reference', reference, data, reference_base, reference_relative, reference_poses
    ).load()
    second = SceneSource('test', test, data, test_base, test_relative, test_poses).load()
    from spatial_relations_ros.learning import load_metric

    metric = load_metric(weights)
    value = metric.distance(first, second)
    output.say(f'{value:.6f}')
    output.write_json({'distance': value, 'model_hash': metric.model_hash})
