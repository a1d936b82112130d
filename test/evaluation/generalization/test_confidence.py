"""What answers say of themselves against what the judge says."""

from __future__ import annotations

import dataclasses
import json
import shutil

import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError, share_path
from spatial_relations_ros.evaluation.generalization.confidence import (
    Answers,
    fit,
    main,
    read_answers,
    reliability,
)
from spatial_relations_ros.learning import load_metric
from spatial_relations_ros.learning.answer_calibration import AnswerCalibration
from spatial_relations_ros.learning.card import ModelCard


def answers_that_follow(calibration: AnswerCalibration, count: int, seed: int) -> Answers:
    rng = np.random.default_rng(seed)
    same_relation = rng.beta(4.0, 0.6, count)
    differences = rng.exponential(0.3, count)
    so = probabilities(calibration, same_relation, differences)
    return Answers(np.full(count, 'known'), same_relation, differences, rng.random(count) < so)


def probabilities(calibration, same_relation, differences):
    pairs = zip(same_relation, differences, strict=True)
    return np.array([calibration.probability(p, d) for p, d in pairs])


def test_a_calibration_is_found_again_and_helps_on_other_answers():
    true = AnswerCalibration(0.7, -1.0, 2.0)
    fitted = fit(answers_that_follow(true, 16000, 0))
    assert (fitted.slope, fitted.offset) == pytest.approx((0.7, -1.0), abs=0.15)
    assert fitted.doubt == pytest.approx(2.0, abs=0.4)
    others = answers_that_follow(true, 2000, 1)
    calibrated = probabilities(fitted, others.same_relation, others.differences)
    before = reliability(others.same_relation, others.imitated)
    after = reliability(calibrated, others.imitated)
    assert before['expected_calibration_error'] > 0.1
    assert after['expected_calibration_error'] < 0.04
    assert after['log_loss'] < before['log_loss']


def test_the_error_is_the_gap_in_each_bin_by_its_share():
    confidence = np.array([0.85, 0.85, 0.995, 0.995])
    row = reliability(confidence, np.array([True, False, True, True]))
    assert row['expected_calibration_error'] == pytest.approx(0.5 * 0.35 + 0.5 * 0.005)
    assert [item['imitated'] for item in row['bins']] == [1, 2]
    assert row['brier'] == pytest.approx((0.15**2 + 0.85**2 + 2 * 0.005**2) / 4, abs=1e-4)


def test_differences_that_speak_for_an_answer_are_left_out():
    answers = answers_that_follow(AnswerCalibration(0.7, -1.0), 400, 0)
    fitted = fit(dataclasses.replace(answers, differences=answers.imitated.astype(float)))
    assert fitted.doubt == 0.0
    assert fitted.slope == pytest.approx(0.7, abs=0.3)


@pytest.mark.parametrize('num_right', [0, 30])
def test_answers_of_one_kind_are_no_ground(num_right):
    right = np.arange(30) < num_right
    answers = Answers(np.full(30, 'known'), np.full(30, 0.9), np.zeros(30), right)
    with pytest.raises(ConfigError, match='right and wrong ones'):
        fit(answers)


def report(model_hash: str) -> str:
    cases = [
        {
            'experiment': 'known', 'variant': 'ours', 'confidence': 0.9,
            'distance': 0.1 + 0.02 * idx, 'difference': 0.0, 'imitated': idx % 4 > 0 or idx < 6,
        }
        for idx in range(24)
    ]  # fmt: skip
    without = {**cases[0], 'variant': 'features', 'confidence': None, 'distance': 3.0}
    return json.dumps({'model_hash': model_hash, 'cases': [*cases, without]})


def test_the_command_stores_a_calibration_in_a_card(tmp_path, capsys):
    card = tmp_path / 'weights.json'
    shutil.copy(share_path('models', 'default.json'), card)
    made = tmp_path / 'report.json'
    made.write_text(report(load_metric().model_hash))
    numbers = tmp_path / 'numbers.json'
    assert main([str(made), '--fit', str(card), '--json', str(numbers)]) == 0
    assert 'known, calibrated:' in capsys.readouterr().out
    stored = ModelCard.read(card)
    assert stored.answers['num_answers'] == 24
    assert AnswerCalibration.of_card(stored.answers) is not None
    assert stored.sha256 == load_metric().model_hash
    assert json.loads(numbers.read_text())['all']['metric']['answers'] == 24


def test_reports_of_other_weights_are_refused(tmp_path, capsys):
    made = tmp_path / 'report.json'
    made.write_text(report('0' * 64))
    assert main([str(made)]) == 2
    assert 'was made with weights 000000000000' in capsys.readouterr().err
    made.write_text('[]')
    with pytest.raises(ConfigError, match='no report of relations generalize'):
        read_answers([made], load_metric())
