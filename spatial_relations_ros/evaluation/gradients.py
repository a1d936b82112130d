"""Compares the gradients of the projection: agreement with finite differences, and outcome.

    python -m spatial_relations_ros.evaluation.gradients DATA --cases 60

Each case is a demonstration and a copy of it whose relative object is shifted by 10 to 30 % of the
scene's extent and turned by 10 to 40 degrees. With each gradient the distance of the two is
differentiated by the six degrees of freedom of that object and compared with central differences
of the distance over about two pixels; then the same gradient brings the object back, or does not,
in 60 steps of Adam under the metric alone.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch

from spatial_relations_ros import __version__
from spatial_relations_ros.core import ConfigError, atomic_write
from spatial_relations_ros.datasets.freiburg import RelationDataset, load_dataset
from spatial_relations_ros.evaluation.gradient_agreement import (
    MotionDistance,
    agreement,
    analytic_slopes,
    finite_differences,
)
from spatial_relations_ros.evaluation.gradient_cases import (
    VARIANTS,
    DisplacedScene,
    Variant,
    displace,
)
from spatial_relations_ros.evaluation.gradient_descents import (
    BACK_WITHIN,
    STEPS,
    Descent,
    descend,
)
from spatial_relations_ros.evaluation.intervals import wilson_interval
from spatial_relations_ros.learning import RelationMetric, load_metric

_QUANTILES = (0.25, 0.5, 0.75)


def compare_gradients(
    metric: RelationMetric,
    dataset: RelationDataset,
    *,
    num_cases: int,
    seed: int,
    variants: Sequence[Variant] = VARIANTS,
    steps: int = STEPS,
) -> dict[str, Any]:
    """Agreement and outcome of each variant on the same cases.

    Returns:
        For each variant by name: ``agreement`` with finite differences, ``outcome`` of the
        optimisations, and ``settings``.

    Raises:
        ConfigError: when the data has fewer scenes than cases are asked for.
    """
    if not 2 <= num_cases <= len(dataset.scenes):
        raise ConfigError(
            f'{num_cases} cases asked for; expected 2 to {len(dataset.scenes)}, the scenes there'
        )
    rng = np.random.default_rng(seed)
    rows = rng.choice(len(dataset.scenes), num_cases, replace=False)
    cases = [displace(dataset.scene_of(dataset.scenes[row]), rng) for row in rows]
    numeric = [finite_differences(MotionDistance(metric, case)) for case in cases]
    report: dict[str, Any] = {}
    descents: dict[str, list[Descent]] = {}
    for variant in variants:
        analytic = [analytic_slopes(metric, case, variant) for case in cases]
        descents[variant.name] = _descents(metric, cases, variant, steps)
        report[variant.name] = {
            'settings': {**variant.settings, 'coarse_to_fine': variant.narrows},
            'agreement': agreement(numeric, analytic),
            'outcome': _outcome(descents[variant.name], descents[variants[0].name]),
        }
    return report


def _descents(
    metric: RelationMetric, cases: Sequence[DisplacedScene], variant: Variant, steps: int
) -> list[Descent]:
    descents = []
    for idx, case in enumerate(cases, start=1):
        descents.append(descend(metric, case, variant, steps=steps))
        print(f'\r{variant.name}: {idx} of {len(cases)}', end='', file=sys.stderr, flush=True)
    print(file=sys.stderr)
    return descents


def _outcome(descents: Sequence[Descent], first: Sequence[Descent]) -> dict[str, Any]:
    """Counts with 95 % intervals, quartiles, and cases against the first variant's."""
    back = [item for item in descents if item.is_back]
    pairs = list(zip(descents, first, strict=True))
    return {
        'cases': len(descents),
        'back': len(back),
        'wilson_95': [round(bound, 4) for bound in wilson_interval(len(back), len(descents))],
        'only_this': sum(item.is_back and not other.is_back for item, other in pairs),
        'only_first': sum(other.is_back and not item.is_back for item, other in pairs),
        'nearer_pose_than_first': sum(item.errors[1] < other.errors[1] for item, other in pairs),
        'steps': _quartiles([item.back_after for item in back]),
        'distance_start': _quartiles([item.distances[0] for item in descents]),
        'distance_end': _quartiles([item.distances[1] for item in descents]),
        'error_start': _quartiles([item.errors[0] for item in descents]),
        'error_end': _quartiles([item.errors[1] for item in descents]),
        'milliseconds': _quartiles([item.milliseconds for item in descents]),
        'descents': [dataclasses.asdict(item) for item in descents],
    }


def _quartiles(values: Sequence[float]) -> list[float] | None:
    if not values:
        return None
    return [round(float(value), 4) for value in np.quantile(values, _QUANTILES)]


def markdown(report: dict[str, Any]) -> str:
    """The comparison as a table; quartiles as median (quarter to three quarters)."""
    lines = [
        '| Gradient | shift: correlation | equal sign | turn: correlation | equal sign '
        '| back | steps | pose error, % | distance | CPU ms a step |',
        '|' + '---|' * 10,
    ]
    for name, row in report.items():
        outcome, cells = row['outcome'], [name]
        for motion in ('shift', 'turn'):
            item = row['agreement'][motion]
            bounds = f'{item["correlation_low"]:.2f} to {item["correlation_high"]:.2f}'
            cells += [f'{item["correlation"]:.3f} ({bounds})', f'{100 * item["equal_sign"]:.0f} %']
        low, high = (100 * bound for bound in outcome['wilson_95'])
        cells += [
            f'{outcome["back"]} of {outcome["cases"]} ({low:.0f} to {high:.0f} %)',
            _spread(outcome['steps'], '.0f'),
            _spread(outcome['error_end'], '.1f', scale=100.0),
            _spread(outcome['distance_end'], '.3f'),
            _spread(outcome['milliseconds'], '.1f'),
        ]
        lines.append('| ' + ' | '.join(cells) + ' |')
    return '\n'.join(lines)


def _spread(quartiles: Sequence[float] | None, style: str, *, scale: float = 1.0) -> str:
    if quartiles is None:
        return ''
    low, middle, high = (format(scale * value, style) for value in quartiles)
    return f'{middle} ({low} to {high})'


def main(arguments: Sequence[str] | None = None) -> int:
    """Prints the comparison; returns the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or '').partition('\n')[0])
    parser.add_argument('data', type=Path, help='a generated dataset')
    parser.add_argument('--weights', type=Path, help='instead of those shipped')
    parser.add_argument('--cases', type=int, default=60)
    parser.add_argument('--seed', type=int, default=0)
    parser.add_argument('--json', type=Path)
    options = parser.parse_args(arguments)
    torch.set_num_threads(1)  # CPU time is wall time then, on a machine with nothing else to do
    metric = load_metric(options.weights)
    report = compare_gradients(
        metric, load_dataset(options.data), num_cases=options.cases, seed=options.seed
    )
    print(markdown(report))
    if options.json is not None:
        content = {
            'version': __version__,
            'data': options.data.name,
            'seed': options.seed,
            'weights_sha256': metric.model_hash,
            'back_within': BACK_WITHIN,
            'gradients': report,
        }
        with atomic_write(options.json) as temporary:
            temporary.write_text(json.dumps(content, indent=2) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
