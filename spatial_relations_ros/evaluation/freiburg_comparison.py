"""How generated scenes compare with what people do: the Freiburg Spatial Relations data.

    python -m spatial_relations_ros.evaluation.freiburg_comparison FREIBURG GENERATED --json OUT

FREIBURG holds the published poses and hand-made features of 546 human-made scenes, GENERATED is
a generated dataset. Compared are quantities of the poses, and the 39 features: the energy
distance, how well a classifier tells real from generated, and how many of the real scenes lie as
near to a generated one as generated scenes lie to each other (coverage), by kind of scene and by
object.

People did not make all relations equally often. How often is estimated from the generated scenes
nearest to each real one, and the generated scenes are drawn in these shares.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.progress import track
from scipy.spatial import cKDTree

from spatial_relations_ros import __version__
from spatial_relations_ros.core import DatasetFormatError, Relation, atomic_write
from spatial_relations_ros.datasets.freiburg import RelationDataset, load_dataset
from spatial_relations_ros.evaluation.freiburg_files import (
    FEATURES_FILE,
    read_features,
    read_poses,
)
from spatial_relations_ros.evaluation.hand_made_features import scene_features
from spatial_relations_ros.evaluation.pose_quantities import (
    Attitude,
    PosedPair,
    PoseQuantities,
    pose_quantities,
    upright_axes,
)
from spatial_relations_ros.evaluation.two_samples import (
    classifier_accuracy,
    covered,
    energy_distance,
)

FloatArray = NDArray[np.float64]

_QUANTILES = (0.1, 0.25, 0.5, 0.75, 0.9)
_NUM_NEIGHBOURS = 5
_LEAST_GROUP = 8


@dataclass(frozen=True, eq=False)
class Sample:
    """Scenes with their numbers.

    Attributes:
        pairs: object ids and poses.
        quantities: of the poses.
        features: (S, 39).
        labels: (S,) relation of each, -1 where it is not known.
    """

    pairs: Sequence[PosedPair]
    quantities: Sequence[PoseQuantities]
    features: FloatArray
    labels: NDArray[np.int64]

    def chosen(self, rows: NDArray[np.int64]) -> Sample:
        """Some of the scenes."""
        return Sample(
            [self.pairs[row] for row in rows],
            [self.quantities[row] for row in rows],
            self.features[rows],
            self.labels[rows],
        )


def real_sample(folder: Path) -> Sample:
    """The human-made scenes of a folder with the published files.

    Raises:
        DatasetFormatError: with file and line, when one is missing or malformed.
    """
    lines = read_poses(folder)
    pairs = []
    for line in lines:
        words = line.name.split('_')
        if len(words) != 3:
            raise DatasetFormatError(f'{line.name} is not of the form object1_object2_number')
        pairs.append(
            PosedPair(
                line.name, words[0], words[1], line.world_from_base, line.world_from_relative
            )
        )
    features = read_features(folder / FEATURES_FILE, [line.name for line in lines])
    quantities = pose_quantities(pairs, upright_axes(pairs))
    return Sample(pairs, quantities, features, np.full(len(pairs), -1))


def generated_sample(dataset: RelationDataset) -> Sample:
    """The labelled scenes of a generated dataset; all its objects are upright along z."""
    entries = [entry for entry in dataset.scenes if entry.label is not None]
    pairs = [
        PosedPair(e.name, e.base_id, e.relative_id, e.world_from_base, e.world_from_relative)
        for e in entries
    ]
    upright = {name: np.array([0.0, 0.0, 1.0]) for name in dataset.clouds}
    features = [scene_features(dataset.scene_of(e)) for e in track(entries, 'features')]
    return Sample(
        pairs,
        pose_quantities(pairs, upright),
        np.stack(features),
        np.array([int(e.label) for e in entries if e.label is not None]),
    )


def compare(real: Sample, generated: Sample, *, seed: int) -> dict[str, Any]:
    """The report as JSON can hold it; see the module."""
    rng = np.random.default_rng(seed)
    scale = np.concatenate([real.features, generated.features]).std(axis=0)
    scale[scale < 1e-9] = 1.0
    shares = relation_shares(real.features / scale, generated.features / scale, generated.labels)
    matched = generated.chosen(_drawn_in_shares(generated.labels, shares, rng))
    return {
        'num_real': len(real.pairs),
        'num_generated': len(generated.pairs),
        'num_matched': len(matched.pairs),
        'estimated_relation_shares': {
            relation.name: round(float(shares[relation]), 3) for relation in Relation
        },
        'attitudes': {'real': _attitudes(real), 'matched': _attitudes(matched)},
        'quantiles': {'real': _quantiles(real), 'matched': _quantiles(matched)},
        'features': _feature_gap(real.features / scale, matched.features / scale, rng, seed),
        'coverage': _coverage(real, generated, scale),
    }


def relation_shares(
    real: FloatArray, generated: FloatArray, labels: NDArray[np.int64]
) -> FloatArray:
    """Estimated share of each relation (7,) among real scenes.

    Each real scene takes the votes of the five nearest generated ones.
    """
    neighbours = cKDTree(generated).query(real, k=_NUM_NEIGHBOURS)[1]
    counts = np.bincount(labels[neighbours].ravel(), minlength=len(Relation)).astype(np.float64)
    shares: FloatArray = counts / counts.sum()
    return shares


def _drawn_in_shares(
    labels: NDArray[np.int64], shares: FloatArray, rng: np.random.Generator
) -> NDArray[np.int64]:
    """Rows of as many scenes as possible with given shares of the relations."""
    there = np.bincount(labels, minlength=len(shares))
    total = min(there[k] / shares[k] for k in range(len(shares)) if shares[k] > 0.0)
    rows = [
        rng.permutation(np.flatnonzero(labels == k))[: int(total * shares[k])]
        for k in range(len(shares))
    ]
    return np.concatenate(rows)


def _attitudes(sample: Sample) -> dict[str, float]:
    """Share of each pair of attitudes, base then relative."""
    counts: dict[str, int] = {}
    for row in sample.quantities:
        counts[_kind(row)] = counts.get(_kind(row), 0) + 1
    ordered = sorted(counts.items(), key=lambda entry: -entry[1])
    return {kind: round(count / len(sample.quantities), 4) for kind, count in ordered}


def _kind(row: PoseQuantities) -> str:
    base, relative = row.attitudes
    return f'base {base.value}, relative {relative.value}'


def _quantiles(sample: Sample) -> dict[str, list[float]]:
    rows = sample.quantities
    tilted = [row for row in rows if row.attitudes[1] is Attitude.TILTED]
    values = {
        'height of the relative, absolute (m)': [abs(row.height) for row in rows],
        'horizontal distance (m)': [row.distance for row in rows],
        'axis of tilted relatives (deg)': [row.relative_axis_deg for row in tilted],
        'tilt of tilted relatives (deg)': [row.tilt_deg for row in tilted],
    }
    return {
        name: [round(float(value), 3) for value in np.quantile(column, _QUANTILES)]
        for name, column in values.items()
        if column
    }


def _feature_gap(
    real: FloatArray, generated: FloatArray, rng: np.random.Generator, seed: int
) -> dict[str, float]:
    energy = energy_distance(real, generated, rng)
    mean, std = classifier_accuracy(real, generated, seed=seed)
    return {
        'energy_distance_share': round(energy.share, 4),
        'energy_distance_chance_95': round(energy.chance_95, 4),
        'classifier_balanced_accuracy': round(mean, 4),
        'classifier_std': round(std, 4),
    }


def _coverage(real: Sample, generated: Sample, scale: FloatArray) -> dict[str, Any]:
    """Share of real scenes that are covered, overall and by group, worst groups first."""
    points, sample = real.features / scale, generated.features / scale
    is_covered = covered(points, sample)
    groups: dict[str, list[bool]] = {}
    for pair, row, hit in zip(real.pairs, real.quantities, is_covered, strict=True):
        for group in (_kind(row), f'base {pair.base_id}', f'relative {pair.relative_id}'):
            groups.setdefault(group, []).append(bool(hit))
    by_group = {
        group: {'covered': round(float(np.mean(hits)), 3), 'scenes': len(hits)}
        for group, hits in sorted(groups.items(), key=lambda entry: float(np.mean(entry[1])))
        if len(hits) >= _LEAST_GROUP
    }
    backwards = covered(sample, points)
    return {
        'real_covered_at_90': round(float(is_covered.mean()), 4),
        'real_covered_at_50': round(float(covered(points, sample, quantile=0.5).mean()), 4),
        'generated_covered_at_90': round(float(backwards.mean()), 4),
        'by_group': by_group,
        'uncovered': [p.name for p, hit in zip(real.pairs, is_covered, strict=True) if not hit],
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Prints the comparison; returns the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').partition('\n')[0])
    parser.add_argument('freiburg', type=Path, help='folder with the published poses and features')
    parser.add_argument('generated', type=Path, help='a generated dataset')
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--json', type=Path)
    options = parser.parse_args(arguments)
    real = real_sample(options.freiburg)
    generated = generated_sample(load_dataset(options.generated))
    report = {
        'version': __version__,
        'seed': options.seed,
        **compare(real, generated, seed=options.seed),
    }
    _print_report(report)
    if options.json is not None:
        with atomic_write(options.json) as temporary:
            temporary.write_text(json.dumps(report, indent=2) + '\n')
    return 0


def _print_report(report: dict[str, Any]) -> None:
    print(f'{report["num_real"]} real, {report["num_generated"]} generated scenes', end=', ')
    print(f'{report["num_matched"]} of them in the estimated shares of the relations:')
    print(', '.join(f'{k} {v:.2f}' for k, v in report['estimated_relation_shares'].items()))
    for kind, share in report['attitudes']['real'].items():
        matched = report['attitudes']['matched'].get(kind, 0.0)
        print(f'{kind}: real {100 * share:.1f} %, generated {100 * matched:.1f} %')
    for name, values in report['quantiles']['real'].items():
        matched = report['quantiles']['matched'].get(name)
        print(f'{name}, 10/25/50/75/90 %: real {values}, generated {matched}')
    print(', '.join(f'{key} {value}' for key, value in report['features'].items()))
    coverage = report['coverage']
    print(
        f'covered: {100 * coverage["real_covered_at_90"]:.1f} % of the real scenes (90 expected), '
        f'{100 * coverage["real_covered_at_50"]:.1f} % at half the spacing (50 expected); '
        f'{100 * coverage["generated_covered_at_90"]:.1f} % of the generated by the real ones'
    )
    for group, numbers in list(coverage['by_group'].items())[:14]:
        print(f'  {group}: {100 * numbers["covered"]:.0f} % of {numbers["scenes"]}')


if __name__ == '__main__':
    sys.exit(main())
