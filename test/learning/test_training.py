import dataclasses
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import torch

from spatial_relations_ros.core import (
    ConfigError,
    DatasetFormatError,
    Pose,
    Relation,
    Scene,
    TrainingError,
    WeightsError,
)
from spatial_relations_ros.learning.batch_loss import BatchLoss
from spatial_relations_ros.learning.distributed import is_main_process
from spatial_relations_ros.learning.encoders import make_encoder
from spatial_relations_ros.learning.trainer import _optimizer, train_encoder
from spatial_relations_ros.learning.training_config import (
    LOSSES,
    TrainingConfig,
    parse_settings,
    training_config,
)
from spatial_relations_ros.learning.training_set import TrainingSet
from spatial_relations_ros.learning.views import augment, lift_and_tilt

TINY = TrainingConfig(steps=12, scenes_per_class=4, num_points=128, lifted_clones=3)
LONGER = dataclasses.replace(TINY, steps=30)


@pytest.fixture(scope='module')
def training_set(solids):
    """Small boxes on top of and next to larger ones."""
    base = solids.box('base', (0.2, 0.2, 0.1), (0, 0, 0.05))
    relative = solids.box('relative', (0.08, 0.08, 0.08), (0, 0, 0))
    rng = np.random.default_rng(0)
    scenes, labels = [], []
    for _ in range(8):
        x, y = rng.uniform(-0.05, 0.05, 2)
        scenes.append(Scene(base, relative.moved_to(Pose(np.array([x, y, 0.14])))))
        scenes.append(Scene(base, relative.moved_to(Pose(np.array([0.18 + x, y, 0.04])))))
        labels += [Relation.ON_TOP, Relation.NEXT_TO]
    return TrainingSet.from_scenes(scenes, labels)


def test_a_batch_has_equally_many_scenes_of_each_relation(training_set):
    rows = training_set.draw_scenes(5, torch.Generator().manual_seed(0))
    labels = training_set.labels[rows]
    assert (labels == Relation.ON_TOP).sum() == 5
    assert (labels == Relation.NEXT_TO).sum() == 5


def test_points_are_at_the_poses_of_their_scene(training_set):
    rows = torch.arange(4)
    points = training_set.points(rows, 500, torch.Generator().manual_seed(0))
    middle = 0.5 * (points.amax(dim=2) + points.amin(dim=2))
    np.testing.assert_allclose(middle.numpy(), training_set.translations[rows].numpy(), atol=0.01)


def test_augmentation_turns_about_z_and_keeps_heights(training_set):
    rows = torch.arange(6)
    points = training_set.points(rows, 200, torch.Generator().manual_seed(0))
    config = dataclasses.replace(TINY, translation_noise=0.0, rotation_noise_rad=0.0)
    turned = augment(points, config, torch.Generator().manual_seed(1))
    assert torch.allclose(turned[..., 2], points[..., 2], atol=1e-5)
    assert torch.allclose(turned[..., :2].norm(dim=-1), points[..., :2].norm(dim=-1), atol=1e-5)
    assert not torch.allclose(turned, points, atol=1e-2)


def test_channels_are_swapped_only_when_asked_for(training_set):
    rows = torch.arange(16)
    points = training_set.points(rows, 300, torch.Generator().manual_seed(0))
    heights = points[..., 2].amax(dim=2) - points[..., 2].amin(dim=2)
    for swap in (False, True):
        config = dataclasses.replace(
            TINY, translation_noise=0.0, rotation_noise_rad=0.0, swap_channels=swap
        )
        view = augment(points, config, torch.Generator().manual_seed(1))
        new_heights = view[..., 2].amax(dim=2) - view[..., 2].amin(dim=2)
        swapped = (new_heights[:, 0] - heights[:, 1]).abs() < 1e-4
        assert bool(swapped.any()) is swap
        assert not bool(swapped.all())


def test_lifted_scenes_move_the_relative_object_by_the_told_amount(training_set):
    points = training_set.points(torch.arange(16), 400, torch.Generator().manual_seed(0))
    changed, amount = lift_and_tilt(points, torch.Generator().manual_seed(2))
    assert torch.equal(changed[:, 0], points[:, 0])
    motion = (changed[:, 1] - points[:, 1]).norm(dim=-1).mean(dim=-1)
    assert 0.0 <= float(amount.min()) <= float(amount.max()) <= 1.0
    assert float(np.corrcoef(motion.numpy(), amount.numpy())[0, 1]) > 0.7


def test_training_lowers_the_loss_and_repeats_itself(training_set):
    losses = []
    first = train_encoder(
        training_set, LONGER, seed=3, on_progress=lambda progress: losses.append(progress.loss)
    )
    second = train_encoder(training_set, LONGER, seed=3)
    assert len(losses) == LONGER.steps
    assert np.mean(losses[-5:]) < 0.8 * np.mean(losses[:5])
    for name, tensor in first.state_dict().items():
        assert torch.equal(tensor, second.state_dict()[name]), name


def test_a_killed_run_ends_in_the_same_place(training_set, tmp_path):
    class KilledError(Exception):
        pass

    def kill_at_six(progress):
        if progress.step == 6:
            raise KilledError

    whole = train_encoder(training_set, TINY, seed=5, run_dir=tmp_path / 'whole')
    run_dir = tmp_path / 'killed'
    import spatial_relations_ros.learning.trainer as trainer

    seconds, trainer.CHECKPOINT_SECONDS = trainer.CHECKPOINT_SECONDS, 0.0
    try:
        with pytest.raises(KilledError):
            train_encoder(training_set, TINY, seed=5, run_dir=run_dir, on_progress=kill_at_six)
    finally:
        trainer.CHECKPOINT_SECONDS = seconds
    steps = []
    resumed = train_encoder(
        training_set, TINY, seed=5, run_dir=run_dir, on_progress=lambda p: steps.append(p.step)
    )
    assert steps[0] == 7
    for name, tensor in whole.state_dict().items():
        assert torch.equal(tensor, resumed.state_dict()[name]), name
    rows = (run_dir / 'losses.csv').read_text().splitlines()
    assert len(rows) == TINY.steps + 1


def test_a_checkpoint_of_another_run_is_refused(training_set, tmp_path):
    train_encoder(training_set, TINY, seed=5, run_dir=tmp_path)
    with pytest.raises(WeightsError, match='differs in seed;'):
        train_encoder(training_set, TINY, seed=6, run_dir=tmp_path)
    for name in ('clouds', 'translations', 'labels', 'measures'):
        other = dataclasses.replace(training_set, **{name: getattr(training_set, name).clone()})
        getattr(other, name)[0] += 1
        if name == 'measures':
            other.measures[0] = 0.5
        with pytest.raises(WeightsError, match='differs in data_sha256;'):
            train_encoder(other, TINY, seed=5, run_dir=tmp_path)
    (tmp_path / 'checkpoint.pt').write_bytes(b'garbage')
    with pytest.raises(WeightsError, match='cannot be read'):
        train_encoder(training_set, TINY, seed=5, run_dir=tmp_path)


def test_a_run_that_was_killed_while_it_saved_is_finished(training_set, tmp_path):
    """The checkpoint was written and the curve was not; or half of a checkpoint lies about."""
    train_encoder(training_set, TINY, seed=5, run_dir=tmp_path)
    curve = (tmp_path / 'losses.csv').read_text()
    (tmp_path / 'losses.csv').unlink()
    (tmp_path / '.checkpoint.abc123.pt').write_bytes(b'half')
    train_encoder(training_set, TINY, seed=5, run_dir=tmp_path)
    assert (tmp_path / 'losses.csv').read_text() == curve
    assert sorted(path.name for path in tmp_path.iterdir()) == ['checkpoint.pt', 'losses.csv']


@pytest.mark.parametrize('steps', [1, 2, 9, 10, 11, 20])
def test_any_number_of_steps_has_a_schedule(training_set, steps):
    rates = []
    optimizer, schedule = _optimizer(
        make_encoder('compact'), dataclasses.replace(TINY, steps=steps)
    )
    for _ in range(steps):
        rates.append(optimizer.param_groups[0]['lr'])
        optimizer.step()
        schedule.step()
    assert 0.0 < min(rates) <= max(rates) <= TINY.learning_rate * 1.0001


def test_mixed_precision_trains_and_goes_on(training_set, tmp_path):
    mixed = dataclasses.replace(TINY, steps=4, precision='bfloat16')
    losses = {}
    for config in (mixed, dataclasses.replace(mixed, precision='float32')):
        values = losses.setdefault(config.precision, [])
        train_encoder(
            training_set, config, seed=2, run_dir=tmp_path / config.precision,
            on_progress=lambda progress, values=values: values.append(progress.loss),
        )  # fmt: skip
    assert losses['bfloat16'] != losses['float32']
    np.testing.assert_allclose(losses['bfloat16'], losses['float32'], rtol=0.1)
    again = train_encoder(training_set, mixed, seed=2, run_dir=tmp_path / 'bfloat16')
    assert all(p.dtype == torch.float32 and torch.isfinite(p).all() for p in again.parameters())


def test_scenes_of_one_relation_are_refused(training_set):
    one = dataclasses.replace(training_set, labels=torch.zeros_like(training_set.labels))
    with pytest.raises(DatasetFormatError, match='two relations are needed'):
        train_encoder(one, TINY, seed=0)


@pytest.mark.parametrize('loss', LOSSES)
@pytest.mark.parametrize('optimizer', ['adamw', 'sgdr'])
def test_every_loss_and_optimizer_takes_steps(training_set, loss, optimizer):
    config = dataclasses.replace(
        TINY, steps=2, loss=loss, optimizer=optimizer, random_negatives=0.3
    )
    encoder = train_encoder(training_set, config, seed=0)
    assert all(torch.isfinite(p).all() for p in encoder.parameters())


def test_numbers_that_are_no_longer_finite_end_the_training(training_set, tmp_path):
    config = dataclasses.replace(TINY, learning_rate=1e30, steps=10)
    with pytest.raises(TrainingError, match=r'step \d+: the .* smaller learning_rate than 1e\+30'):
        train_encoder(training_set, config, seed=0, run_dir=tmp_path)
    assert not (tmp_path / 'checkpoint.pt').exists()


def test_a_rank_without_other_processes_is_alone(monkeypatch):
    monkeypatch.setenv('RANK', '1')
    monkeypatch.delenv('WORLD_SIZE', raising=False)
    assert is_main_process()


def test_a_relation_with_one_scene_is_refused(solids):
    base = solids.box('base', (0.2, 0.2, 0.1), (0, 0, 0))
    scene = Scene(base, solids.box('box', (0.1, 0.1, 0.1), (0, 0, 0.1)))
    with pytest.raises(DatasetFormatError, match='INSIDE'):
        TrainingSet.from_scenes([scene] * 3, [0, 0, 1])
    with pytest.raises(DatasetFormatError, match='no labelled scene'):
        TrainingSet.from_scenes([], [])


def test_an_unknown_configuration_names_the_known_ones():
    with pytest.raises(ConfigError, match='default, jund2018, multi_similarity, paper'):
        training_config('best')


@pytest.mark.parametrize(
    'change',
    [
        {'loss': 'best'},
        {'precision': 'int8'},
        {'partial_share': 1.5},
        {'steps': 0},
        {'headings': 0},
        {'learning_rate': math.nan},
        {'graded_weight': -0.1},
    ],
)
def test_unusable_settings_are_refused(change):
    with pytest.raises(ConfigError, match=next(iter(change))):
        TrainingConfig(**change)


def test_settings_are_read_as_what_they_are():
    parsed = parse_settings(['steps=50', 'learning_rate=1e-3', 'swap_channels=false'])
    assert parsed == {'steps': 50, 'learning_rate': 1e-3, 'swap_channels': False}


@pytest.mark.parametrize(
    ('setting', 'message'),
    [
        ('steps', 'expected NAME=VALUE'),
        ('stepz=3', "no 'stepz' to set"),
        ('steps=3.5', 'expected a whole number'),
        ('learning_rate=fast', 'expected a number'),
        ('swap_channels=1', 'expected true or false'),
    ],
)
def test_settings_that_cannot_be_read_are_refused(setting, message):
    with pytest.raises(ConfigError, match=message):
        parse_settings([setting])


def test_training_needs_a_device_that_is_there(training_set):
    with pytest.raises(ConfigError, match='auto, cpu or cuda'):
        train_encoder(training_set, TINY, seed=0, device='tpu')


def test_two_processes_train_the_same_weights(tmp_path):
    """Started as ``torchrun`` starts them; each draws batches of its own."""
    program = Path(__file__).with_name('train_in_processes.py')
    subprocess.run(
        [sys.executable, '-m', 'torch.distributed.run', '--standalone', '--local-addr',
         '127.0.0.1', '--nproc-per-node', '2', str(program), str(tmp_path)],
        check=True, timeout=300, capture_output=True, text=True,
        env={**os.environ, 'GLOO_SOCKET_IFNAME': 'lo'},  # the host's name may not resolve
    )  # fmt: skip
    first, second = (torch.load(tmp_path / f'{rank}.pt') for rank in (0, 1))
    for name, tensor in first['weights'].items():
        assert 'running' in name or torch.equal(tensor, second['weights'][name]), name
    assert first['losses'] != second['losses']
    # What the ratio loss keeps is saved by the first process alone, so all must have the same.
    assert first['mean_distance'] == second['mean_distance'] != 1.0
    assert (tmp_path / 'run' / 'checkpoint.pt').is_file()


@pytest.mark.parametrize(
    ('loss', 'without', 'with_strays'),
    [('neighbourhood', math.log(7), math.log(11)), ('all_pairs', 0.5, 0.5)],
)
def test_scenes_at_random_poses_are_like_nothing_else(training_set, loss, without, with_strays):
    """With embeddings of zero each scene's neighbourhood is uniform over all others."""
    for share, expected in ((0.0, without), (0.5, with_strays)):
        config = dataclasses.replace(TINY, loss=loss, lifted_clones=0, random_negatives=share)
        value = BatchLoss(config)(
            training_set,
            lambda images: images.new_zeros(len(images), 3),
            torch.Generator().manual_seed(0),
        )
        assert float(value) == pytest.approx(expected, abs=1e-4)
