"""Gradient descent through the metric, on the poses of the objects that may move."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import roma
import torch
from torch import Tensor

from spatial_relations_ros.imitation.objective import Objective

# Larger batches leave the cache.
_CHUNK = 8

StepCallback = Callable[[int, 'PoseBatch'], bool]


@dataclass(frozen=True, eq=False)
class PoseBatch:
    """K candidate scenes.

    Attributes:
        rotations: (K, 2, 3, 3) world from object, of base and relative.
        translations: (K, 2, 3) metres, from the objective's origin.
        distances: (K,) metric distance to the demonstration.
        costs: (K,) distance plus penalties.
    """

    rotations: Tensor
    translations: Tensor
    distances: Tensor
    costs: Tensor

    def select(self, rows: Tensor) -> PoseBatch:
        """Some of the scenes, in the order asked for."""
        return PoseBatch(
            self.rotations[rows], self.translations[rows], self.distances[rows], self.costs[rows]
        )


def concatenate(batches: Sequence[PoseBatch]) -> PoseBatch:
    """All scenes of several batches."""
    return PoseBatch(
        torch.cat([batch.rotations for batch in batches]),
        torch.cat([batch.translations for batch in batches]),
        torch.cat([batch.distances for batch in batches]),
        torch.cat([batch.costs for batch in batches]),
    )


def evaluate(
    objective: Objective,
    rotations: Tensor,
    translations: Tensor,
    *,
    headings: int = 1,
    at_rest: bool = False,
) -> PoseBatch:
    """Distances, averaged over a number of headings, and costs of poses; without gradients.

    ``at_rest`` as for :meth:`Objective.penalties`.
    """
    with torch.no_grad():
        distances = torch.cat(
            [
                objective.distances(r, t, headings=headings)
                for r, t in zip(
                    torch.split(rotations, _CHUNK), torch.split(translations, _CHUNK), strict=True
                )
            ]
        )
        return PoseBatch(
            rotations,
            translations,
            distances,
            distances + objective.penalties(rotations, translations, at_rest=at_rest),
        )


def drawn_rates(num_starts: int, learning_rate: float, *, spread: float, seed: int) -> Tensor:
    """Peak learning rates (num_starts,): the first start's as given, the others' at random.

    Which step suits a start is not known before; with several rates one is likely to. They are
    log-uniform from ``learning_rate / spread`` to ``learning_rate * spread``. The rate of a start
    does not depend on how many there are.
    """
    draws = np.random.default_rng(seed).uniform(-1.0, 1.0, num_starts)
    draws[:1] = 0.0
    return torch.from_numpy(learning_rate * spread**draws).to(torch.float32)


def refine(
    objective: Objective,
    start: PoseBatch,
    movable: tuple[bool, bool],
    *,
    steps: int,
    learning_rates: Tensor,
    on_step: StepCallback | None = None,
) -> tuple[PoseBatch, Tensor]:
    """Adam over the poses, all starts at once.

    Poses are updated in the tangent space at the start: a translation in units of the scene's
    extent and a rotation vector about the middle of the object's cloud, so a step does not
    depend on units or on where the object's frame lies.

    Args:
        objective: what to minimise.
        start: K starting scenes.
        movable: whether base and relative may move.
        steps: Adam steps.
        learning_rates: (K,) peak step of each start; decays to a tenth along a cosine.
        on_step: called after each step with the best scenes so far; False stops.

    Returns:
        The best scenes seen from each start, and their distance (steps + 1, K) at each step.
    """
    # Adam's step does not depend on the gradient's scale, so a factor is a learning rate.
    scale = torch.tensor(movable)[None, :, None] * learning_rates[:, None, None]
    pivots = objective.clouds.mean(dim=1)
    update = torch.zeros(len(start.costs), 2, 6, requires_grad=True)
    adam = torch.optim.Adam([update])
    best, history = start, [start.distances]
    for step in range(1, steps + 1):
        for group in adam.param_groups:
            progress = (step - 1) / max(steps, 1)
            group['lr'] = 0.55 + 0.45 * math.cos(math.pi * progress)
        rotations, translations = _updated(start, update * scale, pivots, objective.extent)
        distances = objective.distances(rotations, translations)
        costs = distances + objective.penalties(rotations, translations)
        adam.zero_grad(set_to_none=True)
        torch.autograd.backward(costs.sum())
        if update.grad is not None:
            torch.nan_to_num_(update.grad, nan=0.0, posinf=0.0, neginf=0.0)
        adam.step()
        now = PoseBatch(
            rotations.detach(), translations.detach(), distances.detach(), costs.detach()
        )
        best = _better(best, now)
        history.append(now.distances)
        if on_step is not None and not on_step(step, best):
            break
    return best, torch.stack(history)


def _updated(
    start: PoseBatch, update: Tensor, pivots: Tensor, extent: float
) -> tuple[Tensor, Tensor]:
    """Poses (K, 2, 3, 3), (K, 2, 3) after a tangent update (K, 2, 6)."""
    turn = roma.rotvec_to_rotmat(update[..., 3:])
    world_pivots = (start.rotations @ pivots[None, :, :, None])[..., 0] + start.translations
    rotations = turn @ start.rotations
    arm = start.translations - world_pivots
    translations = (turn @ arm[..., None])[..., 0] + world_pivots + update[..., :3] * extent
    return rotations, translations


def _better(first: PoseBatch, second: PoseBatch) -> PoseBatch:
    wins = second.costs < first.costs
    return PoseBatch(
        torch.where(wins[:, None, None, None], second.rotations, first.rotations),
        torch.where(wins[:, None, None], second.translations, first.translations),
        torch.where(wins, second.distances, first.distances),
        torch.where(wins, second.costs, first.costs),
    )
