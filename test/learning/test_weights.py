import dataclasses
import json

import numpy as np
import pytest
import torch

from spatial_relations_ros.core import Scene, WeightsError
from spatial_relations_ros.learning import ModelCard, load_metric, make_encoder, save_metric


@pytest.fixture
def saved(tmp_path):
    torch.manual_seed(0)
    encoder = make_encoder('compact')
    path = tmp_path / 'weights.safetensors'
    save_metric(encoder, ModelCard(encoder='compact', num_points=256), path)
    return encoder, path


@pytest.fixture(scope='module')
def scene(solids):
    return Scene(
        solids.box('base', (0.2, 0.2, 0.1), (0, 0, 0.05)),
        solids.box('relative', (0.08, 0.08, 0.08), (0, 0, 0.14)),
    )


def test_weights_survive_the_round_trip(saved, scene):
    encoder, path = saved
    metric = load_metric(path)
    for name, tensor in encoder.state_dict().items():
        assert torch.equal(tensor, metric.encoder.state_dict()[name]), name
    assert metric.embed_scenes([scene]).shape == (1, metric.embedding_dim)
    assert metric.embed_scenes([]).shape == (0, 64)


def test_missing_weights_are_named(tmp_path):
    with pytest.raises(WeightsError, match=r'none\.safetensors does not exist'):
        load_metric(tmp_path / 'none.safetensors')


def test_damaged_weights_are_found_by_their_hash(saved):
    _, path = saved
    content = bytearray(path.read_bytes())
    content[-1] ^= 1
    path.write_bytes(content)
    with pytest.raises(WeightsError, match='damaged'):
        load_metric(path)


def test_weights_on_a_disk_that_fails_are_refused(saved):
    _, path = saved
    path.unlink()
    path.symlink_to('/proc/self/mem')  # a file whose first byte cannot be read
    with pytest.raises(WeightsError, match='cannot be read: Input/output error'):
        load_metric(path)


def test_truncated_weights_are_refused_even_with_their_own_hash(saved):
    import hashlib

    _, path = saved
    path.write_bytes(path.read_bytes()[:5000])
    card = json.loads(path.with_suffix('.json').read_text())
    card['sha256'] = hashlib.sha256(path.read_bytes()).hexdigest()
    path.with_suffix('.json').write_text(json.dumps(card))
    with pytest.raises(WeightsError, match='does not fit'):
        load_metric(path)


def test_weights_of_another_network_are_refused(saved):
    _, path = saved
    card = ModelCard.read(path.with_suffix('.json'))
    dataclasses.replace(card, encoder='jund2018').write(path.with_suffix('.json'))
    with pytest.raises(WeightsError, match='does not fit'):
        load_metric(path)


@pytest.mark.parametrize(
    ('content', 'reason'),
    [(None, 'missing'), ('{', 'not a readable card'), ('{}', 'version'), ('[1]', 'version'),
     ('{"card_version": 1}', 'lacks')],
)  # fmt: skip
def test_a_bad_card_is_told(saved, content, reason):
    card = saved[1].with_suffix('.json')
    card.unlink() if content is None else card.write_text(content)
    with pytest.raises(WeightsError, match=reason):
        load_metric(saved[1])


@pytest.mark.parametrize(
    ('name', 'value'),
    [('encoder', ['a']), ('sha256', None), ('headings', 0), ('headings', '4'), ('num_points', 0),
     ('num_points', True), ('config', [])],
)  # fmt: skip
def test_a_card_with_entries_of_the_wrong_kind_is_told(saved, name, value):
    card = saved[1].with_suffix('.json')
    card.write_text(json.dumps({**json.loads(card.read_text()), name: value}))
    with pytest.raises(WeightsError, match=f'{name} is '):
        load_metric(saved[1])


def test_embedding_does_not_depend_on_where_the_scene_is(saved, scene):
    metric = load_metric(saved[1])
    shift = np.array([3.0, -2.0, 0.7])
    moved = scene.with_poses(
        *(dataclasses.replace(item.world_from_object,
                              translation=item.world_from_object.translation + shift)
          for item in scene.objects)
    )  # fmt: skip
    assert metric.distance(scene, moved) < 1e-2 * np.linalg.norm(metric.embed_scenes([scene]))
    assert metric.distance(scene, scene) <= 1e-6
