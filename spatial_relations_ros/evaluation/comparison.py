"""Several metrics on the same splits: learned ones beside the baselines."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import DatasetFormatError
from spatial_relations_ros.datasets.freiburg import RelationDataset
from spatial_relations_ros.evaluation.calibrating import measure_calibration
from spatial_relations_ros.evaluation.labelled_scenes import LabelledScenes, OnProgress
from spatial_relations_ros.evaluation.nonsense import nonsense_scenes
from spatial_relations_ros.evaluation.splits_report import (
    PROTOCOLS,
    Space,
    SplitsReport,
    confusion_by_name,
    evaluate_splits,
    splits_of,
)
from spatial_relations_ros.learning import RelationMetric

MEASURES = ('three_of_five', 'five_of_five', 'mean_average_precision')
NUM_NONSENSE = 100


@dataclass(frozen=True, eq=False)
class ComparedMetric:
    """One metric and how it retrieves.

    Attributes:
        name: unique in a comparison.
        about: what it is, ready for JSON.
        reports: by protocol.
        embeddings: (S, D) of all scenes; None where they differ from split to split.
        metric: the learned one; None for a baseline.
    """

    name: str
    about: Mapping[str, Any]
    reports: Mapping[str, SplitsReport]
    embeddings: NDArray[np.floating] | None = None
    metric: RelationMetric | None = None

    def entry(self) -> dict[str, Any]:
        """Ready for JSON; see ``docs/cli.md``."""
        return {'name': self.name, **self.about, 'protocols': self.protocols()}

    def protocols(self) -> dict[str, Any]:
        """Numbers and confusion by protocol, as they stand in a card."""
        return {name: report_entry(report) for name, report in self.reports.items()}


def report_entry(report: SplitsReport) -> dict[str, Any]:
    """A report as it stands in a card."""
    return {**report.summary(), 'confusion': confusion_by_name(report.confusion)}


def protocols_of(dataset: RelationDataset, wanted: str) -> tuple[str, ...]:
    """The protocols to run: the wanted one, or for ``both`` those that the dataset has splits for.

    Raises:
        DatasetFormatError: when the dataset has none of them.
    """
    if wanted != 'both':
        splits_of(dataset, wanted)
        return (wanted,)
    available = {'scene': dataset.splits, 'object': dataset.object_splits}
    names = tuple(name for name in PROTOCOLS if available[name])
    if not names:
        raise DatasetFormatError(
            'the dataset has no splits; cross_validation_splits/ or object_splits/ is needed'
        )
    return names


def compare_metric(
    name: str,
    metric: RelationMetric,
    scenes: LabelledScenes,
    protocols: Sequence[str],
    *,
    weights: Path | None = None,
    on_progress: OnProgress | None = None,
) -> ComparedMetric:
    """A learned metric over the splits; it is used as it is."""
    embeddings = scenes.embed(metric, on_progress=on_progress)
    config = metric.card.config
    about = {
        'kind': 'weights',
        'weights': None if weights is None else str(weights),
        'model_hash': metric.model_hash,
        'encoder': metric.card.encoder,
        'config': config.get('name'),
        'seed': config.get('seed'),
        'steps': metric.card.steps,
    }
    reports = reports_of(lambda _: embeddings, scenes, protocols)
    return ComparedMetric(name, about, reports, embeddings, metric)


def trained_on(metric: RelationMetric, scenes_sha256: str) -> bool:
    """Whether a metric was trained with scenes of this dataset."""
    return bool(metric.card.data.get('scenes_sha256') == scenes_sha256)


def reports_of(
    space: Space, scenes: LabelledScenes, protocols: Sequence[str]
) -> dict[str, SplitsReport]:
    """Retrieval by protocol."""
    return {
        protocol: evaluate_splits(
            space, scenes, splits_of(scenes.dataset, protocol), protocol=protocol
        )
        for protocol in protocols
    }


def seed_groups(compared: Sequence[ComparedMetric]) -> list[dict[str, Any]]:
    """Mean and spread over weights that differ in nothing but the seed of their training."""
    groups: dict[str, dict[Any, ComparedMetric]] = {}
    for item in compared:
        if item.metric is not None and item.metric.card.config:
            card = item.metric.card
            settings = {key: value for key, value in card.config.items() if key != 'seed'}
            key = json.dumps([card.encoder, settings, card.data], sort_keys=True)
            # One of each seed: a copy of the same weights shows no spread.
            groups.setdefault(key, {}).setdefault(card.config.get('seed'), item)
    return [_seed_group(list(seeds.values())) for seeds in groups.values() if len(seeds) > 1]


def _seed_group(members: Sequence[ComparedMetric]) -> dict[str, Any]:
    protocols: dict[str, dict[str, float]] = {}
    for protocol in members[0].reports:
        summaries = [member.reports[protocol].summary() for member in members]
        protocols[protocol] = {}
        for measure in MEASURES:
            values = np.array([summary[measure] for summary in summaries])
            protocols[protocol][measure] = round(float(values.mean()), 4)
            protocols[protocol][f'{measure}_std_over_seeds'] = round(float(values.std(ddof=1)), 4)
    return {
        'config': members[0].about['config'],
        'names': [member.name for member in members],
        'seeds': [member.about['seed'] for member in members],
        'protocols': protocols,
    }


def calibration_entries(
    compared: Sequence[ComparedMetric],
    scenes: LabelledScenes,
    *,
    scenes_sha256: str,
    seed: int,
    num_nonsense: int = NUM_NONSENSE,
) -> dict[str, dict[str, Any]]:
    """What the calibration of each metric is worth on these scenes, by name.

    Args:
        compared: those without a calibration are left out.
        scenes: real ones.
        scenes_sha256: identifies the dataset, to tell whether the calibration was fitted on it.
        seed: of the nonsense.
        num_nonsense: scenes of each kind.
    """
    calibrated = [item for item in compared if item.metric is not None and item.metric.calibration]
    if not calibrated:
        return {}
    nonsense = nonsense_scenes(scenes.dataset, num_each=num_nonsense, seed=seed)
    entries = {}
    for item in calibrated:
        metric = item.metric
        assert metric is not None
        assert metric.calibration is not None
        assert item.embeddings is not None
        card = metric.card
        fitted_on = card.data if 'split' in card.calibration else card.calibration.get('data', {})
        embedded = {kind: metric.embed_scenes(found) for kind, found in nonsense.items()}
        entries[item.name] = {
            'fitted_on_this_data': fitted_on.get('scenes_sha256') == scenes_sha256,
            **measure_calibration(metric.calibration, item.embeddings, scenes.labels, embedded),
        }
    return entries
