"""Descent on poses: every start at a learning rate of its own."""

from __future__ import annotations

import numpy as np
import torch

from spatial_relations_ros.imitation import ImitationOptions
from spatial_relations_ros.imitation.objective_setup import make_objective
from spatial_relations_ros.imitation.pose_optimizer import drawn_rates, evaluate, refine
from spatial_relations_ros.imitation.poses import pose_tensors


def test_rates_are_drawn_about_the_given_one_and_repeat():
    rates = drawn_rates(400, 0.01, spread=2.0, seed=3)
    assert rates[0] == np.float32(0.01)
    assert 0.005 <= float(rates.min()) < 0.006
    assert 0.018 < float(rates.max()) <= 0.02
    assert 0.4 < float((rates < 0.01).float().mean()) < 0.6
    assert torch.equal(rates[:3], drawn_rates(3, 0.01, spread=2.0, seed=3))
    assert not torch.equal(rates[:3], drawn_rates(3, 0.01, spread=2.0, seed=4)[:3])
    assert torch.equal(drawn_rates(3, 0.01, spread=1.0, seed=3), torch.full((3,), 0.01))


def test_each_start_moves_by_its_own_rate(metric, on_top, apart):
    objective = make_objective(metric, on_top, apart, ImitationOptions())
    poses = [tuple(item.world_from_object for item in apart.objects)] * 3
    start = evaluate(objective, *pose_tensors(poses, objective.origin))
    rates = torch.tensor([0.02, 0.03, 0.04])
    # Scenes are measured before a step is made: the first step shows in the second.
    best, distances = refine(objective, start, (False, True), steps=2, learning_rates=rates)
    assert distances.shape == (3, 3)
    assert (best.costs < start.costs).all()
    assert torch.equal(best.translations[:, 0], start.translations[:, 0]), 'the base stands'
    middle = objective.clouds[1].mean(dim=0)
    shift = best.rotations @ middle + best.translations
    shift = (shift - (start.rotations @ middle + start.translations))[:, 1]
    assert torch.allclose(shift.abs(), objective.extent * rates[:, None].expand(3, 3), atol=1e-5)
