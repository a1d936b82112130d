"""The commands of models/README.md, but for the training."""

import json

import pytest

from spatial_relations_ros.learning import load_metric

# Rounding differs between processors: a few scenes are drawn otherwise, a few neighbours change
# places. The same training with another seed is off by 0.01.
ROUNDING = 0.005


def test_shipped_weights_have_the_numbers_of_their_card(relations, tmp_path):
    data, path = tmp_path / 'calibration', tmp_path / 'numbers.json'
    card = load_metric().card
    made_of = card.retrieval['data']['generated']
    chosen = ['--scenes', made_of['num_scenes'], '--objects', made_of['num_objects']]
    result = relations('generate', data, *chosen, '--seed', made_of['seed'], '--jobs', 2)
    assert result.exit_code == 0, result.output
    result = relations('retrieve', data, '--baselines', 'none', '--json', path)
    assert result.exit_code == 0, result.output
    (metric,) = json.loads(path.read_text())['metrics']
    on_objects = card.retrieval['object_splits']
    for measured, on_card in (
        (metric['protocols']['scene'], card.retrieval),
        (metric['protocols']['object'], on_objects),
    ):
        assert measured['num_queries'] == on_card['num_queries']
        for name in ('three_of_five', 'five_of_five', 'mean_average_precision'):
            assert measured[name] == pytest.approx(on_card[name], abs=ROUNDING), name
