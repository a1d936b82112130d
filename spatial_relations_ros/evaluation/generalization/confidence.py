"""How far the confidence of answers can be believed, and its calibration.

    python -m spatial_relations_ros.evaluation.generalization.confidence REPORT.json

Takes reports of ``relations generalize``. What an answer's distance says is compared with what
the judge says: the share that imitates the demonstration, in bins of the confidence. With
``--fit CARD`` the calibration of answers is fitted to the reports and stored in the card of the
weights; measure it on other reports, of another seed.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from spatial_relations_ros.core import ConfigError, SpatialRelationsError, atomic_write
from spatial_relations_ros.evaluation.generalization.variants import OURS
from spatial_relations_ros.evaluation.intervals import wilson_interval
from spatial_relations_ros.learning import RelationMetric, load_metric
from spatial_relations_ros.learning.answer_calibration import (
    MOST_DIFFERENCE,
    AnswerCalibration,
    log_odds_of,
)
from spatial_relations_ros.learning.card import ModelCard

# Answers lie near 1: the bins of it are finer.
EDGES = (0.0, 0.5, 0.8, 0.9, 0.95, 0.97, 0.98, 0.99, 1.0)
_LEAST_ANSWERS = 20
_PENALTY_INVERSE = 1e3

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Answers:
    """Best answers of requests.

    Attributes:
        experiments: (N,) names.
        same_relation: (N,) the metric's probability of the same relation, by their distances.
        differences: (N,) of their arrangements from the demonstrations'.
        imitated: (N,) what the judge says.
    """

    experiments: NDArray[np.str_]
    same_relation: Array
    differences: Array
    imitated: NDArray[np.bool_]

    def of(self, experiment: str) -> Answers:
        """Those of one experiment."""
        rows = self.experiments == experiment
        return Answers(
            self.experiments[rows],
            self.same_relation[rows],
            self.differences[rows],
            self.imitated[rows],
        )


def read_answers(paths: Iterable[Path], metric: RelationMetric) -> Answers:
    """The answers of the default settings in reports of ``relations generalize``.

    Raises:
        ConfigError: for files that are no such reports, reports of other weights, weights without
            a calibration, or no answers.
    """
    calibration = metric.calibration
    if calibration is None:
        raise ConfigError('the weights have no calibration of distances; train with --held-out')
    found: list[tuple[str, float, float, bool]] = []
    for path in paths:
        try:
            report = json.loads(path.read_text())
            model_hash, cases = report['model_hash'], report['cases']
            rows = [
                (
                    c['experiment'],
                    float(c['distance']),
                    float(c['difference']),
                    bool(c['imitated']),
                )
                for c in cases
                if c['variant'] == OURS
                and c['confidence'] is not None
                and c['difference'] is not None
            ]
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise ConfigError(
                f'{path} is no report of relations generalize --json: {error!r}'
            ) from error
        if model_hash != metric.model_hash:
            raise ConfigError(
                f'{path} was made with weights {model_hash[:12]}..., these are '
                f'{metric.model_hash[:12]}...'
            )
        found += rows
    if not found:
        raise ConfigError('the reports hold no answers of the default settings')
    experiments, distances, differences, imitated = zip(*found, strict=True)
    return Answers(
        np.array(experiments),
        np.array([calibration.same_relation_probability(d) for d in distances]),
        np.array(differences),
        np.array(imitated),
    )


def fit(answers: Answers) -> AnswerCalibration:
    """Logistic regression of the judge's words on log odds and differences.

    Raises:
        ConfigError: for fewer than 20 answers, or all right or all wrong.
    """
    if len(answers.imitated) < _LEAST_ANSWERS or len(np.unique(answers.imitated)) < 2:
        raise ConfigError(
            f'{int(answers.imitated.sum())} of {len(answers.imitated)} answers imitate; a '
            f'calibration needs at least {_LEAST_ANSWERS}, right and wrong ones'
        )
    from sklearn.linear_model import LogisticRegression

    odds = [log_odds_of(p) for p in answers.same_relation]
    known = np.column_stack([odds, np.minimum(answers.differences, MOST_DIFFERENCE)])
    regression = LogisticRegression(C=_PENALTY_INVERSE).fit(known, answers.imitated)
    slope, against = regression.coef_[0]
    if against >= 0.0:  # differences say nothing
        regression.fit(known[:, :1], answers.imitated)
        slope, against = regression.coef_[0, 0], 0.0
    return AnswerCalibration(
        float(slope),
        float(regression.intercept_[0]),
        abs(float(against)),
        float(np.median(answers.differences)),
    )


def reliability(confidence: Array, imitated: NDArray[np.bool_]) -> dict[str, Any]:
    """Confidence (N,) against what is so (N,), ready for JSON.

    The expected calibration error is the mean difference of both over bins, weighted by how many
    answers fall in (Guo et al., ICML 2017); log loss and Brier score are of each answer.
    """
    bins = np.searchsorted(EDGES[1:-1], confidence, side='right')
    kept = np.clip(confidence, 1e-3, 1.0 - 1e-3)
    rows, error = [], 0.0
    for idx in np.unique(bins):
        members = bins == idx
        said, hits, count = confidence[members].mean(), imitated[members].sum(), members.sum()
        error += abs(said * count - hits) / len(confidence)
        rows.append(
            {
                'from': EDGES[idx],
                'to': EDGES[idx + 1],
                'answers': int(count),
                'confidence': round(float(said), 4),
                'imitated': int(hits),
                'interval': [round(edge, 4) for edge in wilson_interval(int(hits), int(count))],
            }
        )
    return {
        'answers': len(confidence),
        'confidence': round(float(confidence.mean()), 4),
        'imitated': int(imitated.sum()),
        'expected_calibration_error': round(float(error), 4),
        'log_loss': round(float(-np.log(np.where(imitated, kept, 1.0 - kept)).mean()), 4),
        'brier': round(float(np.square(confidence - imitated).mean()), 4),
        'bins': rows,
    }


def measure(answers: Answers, calibration: AnswerCalibration | None) -> dict[str, Any]:
    """Reliability of all answers and of each experiment.

    Of the metric's own probability, and of the calibrated one where there is a calibration.
    """
    groups = {'all': answers}
    groups |= {name: answers.of(name) for name in np.unique(answers.experiments).tolist()}
    report: dict[str, Any] = {}
    for name, group in groups.items():
        report[name] = {'metric': reliability(group.same_relation, group.imitated)}
        if calibration is not None:
            pairs = zip(group.same_relation, group.differences, strict=True)
            calibrated = np.array([calibration.probability(p, d) for p, d in pairs])
            report[name]['calibrated'] = reliability(calibrated, group.imitated)
    return report


def main(arguments: Sequence[str] | None = None) -> int:
    """Prints the table; exit code 2 for what cannot be used."""
    parser = argparse.ArgumentParser(
        prog='confidence', description='Compares the confidence of answers with the judge.'
    )
    parser.add_argument('reports', nargs='+', type=Path, metavar='REPORT.json')
    parser.add_argument('--weights', type=Path, help='instead of the shipped ones')
    parser.add_argument('--fit', type=Path, metavar='CARD', help='fit, and store in this card')
    parser.add_argument('--json', type=Path, help='file for the numbers')
    options = parser.parse_args(arguments)
    try:
        metric = load_metric(options.weights)
        answers = read_answers(options.reports, metric)
        calibration = metric.answer_calibration
        if options.fit is not None:
            calibration = fit(answers)
            _store(calibration, answers, options.fit)
    except SpatialRelationsError as error:
        sys.stderr.write(f'failed: {error}\n')
        return 2
    report = measure(answers, calibration)
    _show(report)
    if options.json is not None:
        with atomic_write(options.json) as temporary:
            temporary.write_text(json.dumps(report, indent=2) + '\n')
    return 0


def _store(calibration: AnswerCalibration, answers: Answers, path: Path) -> None:
    entry = {
        'slope': round(calibration.slope, 4),
        'offset': round(calibration.offset, 4),
        'doubt': round(calibration.doubt, 4),
        'typical': round(calibration.typical, 4),
        'num_answers': len(answers.imitated),
        'num_imitated': int(answers.imitated.sum()),
    }
    dataclasses.replace(ModelCard.read(path), answers=entry).write(path)


def _show(report: dict[str, Any]) -> None:
    for name, kinds in report.items():
        for kind, row in kinds.items():
            sys.stdout.write(
                f'{name}, {kind}: {row["confidence"]:.3f} said, {row["imitated"]} of '
                f'{row["answers"]} imitated; calibration error '
                f'{row["expected_calibration_error"]:.3f}, log loss {row["log_loss"]:.3f}, Brier '
                f'{row["brier"]:.3f}\n'
            )
            for item in row['bins']:
                low, high = item['interval']
                sys.stdout.write(
                    f'  {item["from"]:.2f} to {item["to"]:.2f}: {item["confidence"]:.3f} said, '
                    f'{item["imitated"]} of {item["answers"]} ({low:.2f} to {high:.2f})\n'
                )


if __name__ == '__main__':
    sys.exit(main())
