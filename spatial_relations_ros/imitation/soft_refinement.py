"""Gradient descent through soft images, coarse to fine."""

from __future__ import annotations

import dataclasses

import torch
from torch import Tensor

from spatial_relations_ros.core import Scene
from spatial_relations_ros.imitation.objective import Objective
from spatial_relations_ros.imitation.pose_optimizer import (
    PoseBatch,
    StepCallback,
    evaluate,
    refine,
)
from spatial_relations_ros.projection import coarse_to_fine

_STAGES = 4


def refine_softly(
    objective: Objective,
    reference: Scene,
    start: PoseBatch,
    movable: tuple[bool, bool],
    *,
    steps: int,
    learning_rates: Tensor,
    on_step: StepCallback | None = None,
) -> PoseBatch:
    """As :func:`refine`, but by the soft projection, whose width shrinks in up to four stages.

    Distances at different widths cannot be compared, so each stage begins where the one before
    came to, and the demonstration is embedded anew for each. The scenes that come out are
    measured by hard images again.
    """
    metric, batch = objective.metric, start
    stages = min(_STAGES, steps)
    ends = [steps * (stage + 1) // stages for stage in range(stages)]
    done = 0
    for end in ends:
        width = coarse_to_fine(done / steps)
        with metric.projecting(gradient='soft', soft_width_px=width):
            embedding = torch.from_numpy(metric.embed_scenes([reference])[0])
            soft = dataclasses.replace(objective, reference_embedding=embedding)
            is_on = True

            def report(step: int, best: PoseBatch, before: int = done) -> bool:
                nonlocal is_on
                is_on = on_step is None or on_step(before + step, best)
                return is_on

            batch, _ = refine(
                soft,
                evaluate(soft, batch.rotations, batch.translations),
                movable,
                steps=end - done,
                learning_rates=learning_rates,
                on_step=report,
            )
        done = end
        if not is_on:
            break
    return evaluate(objective, batch.rotations, batch.translations)
