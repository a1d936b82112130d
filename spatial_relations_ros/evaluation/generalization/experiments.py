"""Which experiments run, and all their cases."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.datasets.freiburg import RelationDataset
from spatial_relations_ros.evaluation.generalization.cases import Experiment
from spatial_relations_ros.evaluation.generalization.known import (
    draw_references,
    known_experiment,
)
from spatial_relations_ros.evaluation.generalization.random_cases import random_experiment
from spatial_relations_ros.evaluation.generalization.unknown import (
    load_unknown_objects,
    pairs_of,
    unknown_experiment,
)


@dataclass(frozen=True)
class Plan:
    """What is to be run.

    Attributes:
        known: the experiment with known objects.
        unknown: folder of unknown objects; None leaves that experiment out.
        num_random: cases of random pairs; 0 leaves them out.
        num_objects: that random pairs are drawn from.
        max_cases: of each experiment, evenly over all; None for all.
        seed: of everything drawn.
        simulate: random pairs are such that stay in place in MuJoCo.
    """

    known: bool = True
    unknown: Path | None = None
    num_random: int = 0
    num_objects: int = 194
    max_cases: int | None = None
    seed: int = 0
    simulate: bool = False


def make_experiments(
    dataset: RelationDataset,
    plan: Plan,
    *,
    on_progress: Callable[[int, int], None] | None = None,
) -> list[Experiment]:
    """Draws references and cases.

    Args:
        dataset: that demonstrations are taken from.
        plan: what is to be run.
        on_progress: called with (random cases drawn, random cases in all).

    Raises:
        ConfigError: when nothing is to be run.
        DatasetFormatError: for data without usable scenes, or too few unknown objects.
    """
    experiments = []
    if plan.known or plan.unknown is not None:
        references = draw_references(dataset, seed=plan.seed)
        if plan.known:
            experiments.append(known_experiment(references))
        if plan.unknown is not None:
            pairs = pairs_of(load_unknown_objects(plan.unknown), seed=plan.seed)
            experiments.append(unknown_experiment(references, pairs))
    if plan.num_random:
        experiments.append(
            random_experiment(
                # The relations of the first cases are those of all.
                num_cases=min(plan.num_random, plan.max_cases or plan.num_random),
                num_objects=plan.num_objects,
                seed=plan.seed,
                simulate=plan.simulate,
                on_progress=on_progress,
            )
        )
    experiments = [experiment.thinned(plan.max_cases) for experiment in experiments]
    if not any(experiment.cases for experiment in experiments):
        raise ConfigError(
            'there is nothing to imitate: ask for known or unknown objects or random pairs'
        )
    return experiments
