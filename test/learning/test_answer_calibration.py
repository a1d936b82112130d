"""Confidence of answers, which were chosen for their distance."""

from __future__ import annotations

import dataclasses
import math

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


def test_another_arrangement_counts_against_an_answer():
    # Odds of 4 to 1 become even ones by what counts as much against it.
    strict = AnswerCalibration(1.0, 0.0, 2.0 * math.log(4.0), typical=0.25)
    assert strict.probability(0.8, 0.5) == pytest.approx(0.5)
    assert strict.probability(0.8) == strict.probability(0.8, 0.25) == pytest.approx(2.0 / 3.0)
    # Beyond another way to show the relation there is none that is more another one.
    assert strict.probability(0.8, 5.0) == strict.probability(0.8, 0.5)


@pytest.mark.parametrize(
    'entry',
    [
        {'slope': 1.0},
        {'slope': 'steep', 'offset': 0.0},
        {'slope': -1.0, 'offset': 0.0},
        {'slope': 1.0, 'offset': 0.0, 'doubt': -1.0},
    ],
)
def test_a_card_that_makes_no_sense_is_refused(entry):
    with pytest.raises(WeightsError, match='slope'):
        AnswerCalibration.of_card(entry)


def test_a_metric_has_the_calibration_of_its_card():
    shipped = load_metric()
    cards = [
        dataclasses.replace(shipped.card, answers=entry)
        for entry in ({}, {'slope': 0.7, 'offset': -0.9, 'num_answers': 115})
    ]
    without, doubting = (
        RelationMetric(shipped.encoder, card, shipped.calibration) for card in cards
    )
    assert without.answer_calibration is None
    assert doubting.answer_calibration == AnswerCalibration(0.7, -0.9)
    assert doubting.answer_calibration.probability(0.99) < 0.99
