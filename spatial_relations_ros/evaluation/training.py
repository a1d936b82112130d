"""From a dataset folder to weights with a card: what ``relations train`` does."""

from __future__ import annotations

import dataclasses
import platform
from collections.abc import Collection, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from spatial_relations_ros import __version__
from spatial_relations_ros.datasets.freiburg import RelationDataset, load_dataset
from spatial_relations_ros.datasets.ground_truth import read_measures
from spatial_relations_ros.evaluation.calibrating import calibrate, calibration_entry
from spatial_relations_ros.evaluation.comparison import protocols_of, report_entry
from spatial_relations_ros.evaluation.held_out import HeldOut, describe_data
from spatial_relations_ros.evaluation.labelled_scenes import LabelledScenes
from spatial_relations_ros.evaluation.splits_report import SplitsReport, retrieve
from spatial_relations_ros.learning import ModelCard, RelationMetric, load_metric, save_metric
from spatial_relations_ros.learning.distributed import is_main_process
from spatial_relations_ros.learning.trainer import ProgressCallback, train_encoder
from spatial_relations_ros.learning.training_config import training_config
from spatial_relations_ros.learning.training_set import TrainingSet
from spatial_relations_ros.visualization import write_image
from spatial_relations_ros.visualization.curves import draw_loss_curve


def train_metric(
    data_dir: Path,
    out: Path,
    *,
    config_name: str = 'default',
    seed: int = 0,
    steps: int | None = None,
    changes: Mapping[str, Any] | None = None,
    held_out_dir: Path | None = None,
    run_dir: Path | None = None,
    device: str = 'auto',
    on_progress: ProgressCallback | None = None,
) -> ModelCard | None:
    """Trains a metric, measures and calibrates it on held-out objects, writes weights and card.

    Args:
        data_dir: labelled scenes in the paper's folder format.
        out: the safetensors file to write; the card goes beside it.
        config_name: of a training configuration.
        seed: of everything random in training.
        steps: instead of the configuration's.
        changes: other attributes of the configuration to replace, by name; the card tells them.
        held_out_dir: another dataset, of other objects, for the retrieval numbers and the
            calibration; training then uses all of ``data_dir``. None trains on the first object
            split (else the first scene split) and measures on its test part.
        run_dir: folder of the checkpoint and the loss curve (``losses.csv``, ``losses.png``); a
            run found there is resumed.
        device: ``auto``, ``cpu`` or ``cuda``.
        on_progress: called after each step.

    Returns:
        The card; None in all but the first of several processes that train together.

    Raises:
        DatasetFormatError: for unusable data.
        ConfigError: for an unknown configuration or unusable changes, or a device that is not
            there.
        WeightsError: when the checkpoint belongs to another run, or the weights give no numbers.
        TrainingError: when the loss is no longer finite.
    """
    config = dataclasses.replace(training_config(config_name), **(changes or {}))
    if steps is not None:
        config = dataclasses.replace(config, steps=steps)
    dataset = load_dataset(data_dir)
    held_out = HeldOut.of(dataset, data_dir, held_out_dir)
    training_set = make_training_set(dataset, held_out.trained, data_dir)
    data = describe_data(data_dir, dataset, names=held_out.trained)
    encoder = train_encoder(
        training_set, config, seed=seed, run_dir=run_dir, device=device, on_progress=on_progress
    )
    if not is_main_process():
        return None
    if run_dir is not None:
        _draw_losses(run_dir)
    card = ModelCard(
        encoder=config.encoder,
        num_points=config.num_points,
        headings=config.headings,
        config={'name': config_name, 'seed': seed, **dataclasses.asdict(config)},
        data=data,
        steps=config.steps,
        versions=_versions(),
    )
    metric = RelationMetric(encoder, card)
    calibration = calibrate(metric, LabelledScenes.of(dataset, held_out.trained), held_out.tested)
    card = dataclasses.replace(
        card,
        retrieval={**retrieval_entry(metric, held_out.dataset), **held_out.described},
        calibration={**calibration_entry(calibration), **held_out.described},
    )
    return save_metric(encoder, card, out, calibration=calibration)


def _draw_losses(run_dir: Path) -> None:
    losses = np.loadtxt(run_dir / 'losses.csv', delimiter=',', skiprows=1, usecols=1, ndmin=1)
    write_image(run_dir / 'losses.png', draw_loss_curve(losses))


def make_training_set(
    dataset: RelationDataset, names: Collection[str], data_dir: Path | None = None
) -> TrainingSet:
    """The labelled scenes of these names as tensors, with the folder's ground truth if any."""
    entries = [
        entry for entry in dataset.scenes if entry.label is not None and entry.name in names
    ]
    labels = [int(entry.label) for entry in entries if entry.label is not None]
    measures = None
    if data_dir is not None:
        measures = read_measures(data_dir, [entry.name for entry in entries])
    return TrainingSet.from_scenes(
        [dataset.scene_of(entry) for entry in entries], labels, measures
    )


def measure_retrieval(weights: Path | None, data_dir: Path, protocol: str) -> SplitsReport:
    """Retrieval of a weights file on a dataset."""
    return retrieve(load_metric(weights), load_dataset(data_dir), protocol=protocol)


def retrieval_entry(metric: RelationMetric, dataset: RelationDataset) -> dict[str, Any]:
    """Retrieval over scene splits and object splits, as far as the dataset has them."""
    first, *others = protocols_of(dataset, 'both')
    entry = report_entry(retrieve(metric, dataset, protocol=first))
    for protocol in others:
        entry[f'{protocol}_splits'] = report_entry(retrieve(metric, dataset, protocol=protocol))
    return entry


def _versions() -> dict[str, str]:
    packages = ('numpy', 'torch', 'roma', 'safetensors')
    return {
        'spatial_relations_ros': __version__,
        'python': platform.python_version(),
        **{name: version(name) for name in packages},
    }
