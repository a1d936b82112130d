"""Ways of imitating that are compared on the same cases."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from spatial_relations_ros.core import ConfigError, ImitationError
from spatial_relations_ros.evaluation.generalization.attempt import Attempt, Stopwatch
from spatial_relations_ros.evaluation.generalization.cases import Case
from spatial_relations_ros.evaluation.generalization.feature_search import search_by_features
from spatial_relations_ros.imitation import ImitationOptions, imitate
from spatial_relations_ros.learning import load_metric

OURS, PAPER, FEATURES = 'ours', 'paper', 'features'

# What differs from the defaults.
_WITHOUT: Mapping[str, Mapping[str, Any]] = {
    OURS: {},
    'no-gradient': {'max_steps': 0},
    'no-proposals': {'propose': False},
    'no-physics': {'physics_weight': 0.0},
    'one-start': {'num_starts': 1},
    'one-rate': {'learning_rate_spread': 1.0},
    'soft': {'soft_refinement': True},
}
DESCRIPTIONS: Mapping[str, str] = {
    OURS: 'the default settings',
    PAPER: 'the optimisation of Jund et al. 2018: 600 steps, one start, the metric alone',
    FEATURES: 'sampled poses compared by the hand-made features of Mees et al. 2017',
    'no-gradient': 'ours, proposals only',
    'no-proposals': 'ours from the current poses and random ones, none proposed from the shapes',
    'no-physics': 'ours, nothing but the metric in the descent',
    'one-start': 'ours, one start refined',
    'one-rate': 'ours, all starts refined with the same learning rate',
    'soft': 'ours, refined through soft images, coarse to fine',
}
VARIANTS = tuple(DESCRIPTIONS)


@dataclass(frozen=True)
class Weights:
    """Files of weights; None takes those that ship with the package.

    Attributes:
        ours: of all variants that use a metric.
        paper: of the variant ``paper``; None takes ours.
    """

    ours: Path | None = None
    paper: Path | None = None


class Imitator:
    """Runs variants on cases.

    Args:
        weights: of the metrics.
        seed: of every imitation.

    Raises:
        WeightsError: for files that are missing or damaged.
    """

    def __init__(self, weights: Weights, *, seed: int) -> None:
        self.metric = load_metric(weights.ours)
        self.paper_metric = self.metric if weights.paper is None else load_metric(weights.paper)
        self.seed = seed

    def attempt(self, case: Case, variant: str) -> Attempt:
        """One imitation of a case; what is refused by a named error is an attempt without poses.

        Raises:
            ConfigError: for an unknown variant.
        """
        if variant == FEATURES:
            return search_by_features(case, seed=self.seed)
        watch = Stopwatch()
        metric = self.paper_metric if variant == PAPER else self.metric
        options = replace(
            options_of(variant), movable=case.movable, table_height=0.0, seed=self.seed
        )
        try:
            result = imitate(metric, case.reference, case.test, options)
        except ImitationError as error:
            return Attempt(
                None, False, None, math.nan, math.nan, 0, message=str(error), **watch.times()
            )
        best = result.answers[0]
        base, relative = best.placements
        return Attempt(
            poses=(base.target, relative.target),
            claimed=bool(result.success),
            confidence=float(best.confidence),
            distance=float(best.distance),
            initial_distance=float(result.initial_distance),
            num_steps=int(result.num_steps),
            message=result.message,
            difference=best.difference,
            **watch.times(),
        )


def options_of(variant: str) -> ImitationOptions:
    """The settings of a variant that calls :func:`imitate`.

    Raises:
        ConfigError: for an unknown variant.
    """
    if variant == PAPER:
        return ImitationOptions.paper()
    if variant not in _WITHOUT:
        raise ConfigError(f'there is no variant {variant!r}; there are {", ".join(VARIANTS)}')
    return ImitationOptions(**_WITHOUT[variant])


def check_variants(names: Sequence[str]) -> tuple[str, ...]:
    """The names without repetitions.

    Raises:
        ConfigError: for an unknown name, or none.
    """
    unknown = [name for name in names if name not in VARIANTS]
    if unknown or not names:
        raise ConfigError(
            f'there is no variant {", ".join(map(repr, unknown)) or "at all"}; there are '
            f'{", ".join(VARIANTS)}'
        )
    return tuple(dict.fromkeys(names))
