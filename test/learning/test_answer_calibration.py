"""Confidence of answers, which were chosen for their distance."""

from __future__ import annotations

import dataclasses

import pytest

from spatial_relations_ros.core import WeightsError
from spatial_relations_ros.learning import load_metric
from spatial_relations_ros.learning.answer_calibration import AnswerCalibration
from spatial_relations_ros.learning.metric import RelationMetric


def test_log_odds_are_scaled_and_shifted():
    assert AnswerCalibration(1.0, 0.0).probability(0.73) == pytest.approx(0.73)
    # Odds of 4 to 1: half of their logarithm is that of 2 to 1.
    assert AnswerCalibration(0.5, 0.0).probability(0.8) == pytest.approx(2.0 / 3.0)
    doubting = AnswerCalibration(0.7, -1.0)
    probabilities = [doubting.probability(p) for p in (0.0, 0.1, 0.5, 0.9, 0.999, 1.0)]
    assert probabilities == sorted(probabilities)
    assert all(0.0 < p < 1.0 for p in probabilities)


@pytest.mark.parametrize(
    'entry', [{'slope': 1.0}, {'slope': 'steep', 'offset': 0.0}, {'slope': -1.0, 'offset': 0.0}]
)
def test_a_card_that_makes_no_sense_is_refused(entry):
    with pytest.raises(WeightsError, match='slope'):
        AnswerCalibration.of_card(entry)


def test_shipped_weights_doubt_answers_more_than_their_distances():
    metric = load_metric()
    answers, calibration = metric.answer_calibration, metric.calibration
    assert answers is not None
    assert calibration is not None
    near = calibration.same_relation_probability(0.2)
    assert 0.5 < answers.probability(near) < near


def test_weights_without_such_a_calibration_still_work():
    shipped = load_metric()
    card = dataclasses.replace(shipped.card, answers={})
    metric = RelationMetric(shipped.encoder, card, shipped.calibration)
    assert metric.answer_calibration is None
