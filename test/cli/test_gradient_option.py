"""``relations imitate --gradient``."""

import json

import pytest


@pytest.fixture
def imitate(relations, data, weights, tmp_path):
    def run(*arguments):
        out = tmp_path / 'out.json'
        result = relations(
            'imitate', '--data', data, '--reference', 'tray_cup_0', '--test', 'carton_can_0',
            '--weights', weights, '--steps', 3, '--json', out, *arguments,
        )  # fmt: skip
        return result, json.loads(out.read_text()) if out.exists() else None

    return run


def test_the_gradient_is_chosen_by_name(imitate):
    result, content = imitate('--gradient', 'sobel')
    assert result.exit_code in (0, 1), result.output
    assert content['answers']


def test_an_unknown_gradient_is_bad_input(imitate):
    result, content = imitate('--gradient', 'hard')
    assert result.exit_code == 2
    assert 'silhouette' in result.output
    assert content is None
