import json

import pytest


def test_train_writes_weights_that_retrieve_can_use(relations, data, tmp_path):
    out, card_path = tmp_path / 'w.safetensors', tmp_path / 'card.json'
    result = relations('train', data, '--out', out, '--steps', 1, '--json', card_path)
    assert result.exit_code == 0, result.output
    card = json.loads(card_path.read_text())['card']
    assert card['steps'] == 1
    assert len(card['sha256']) == 64
    numbers, table = tmp_path / 'numbers.json', tmp_path / 'table.md'
    result = relations('retrieve', data, '--weights', out, '--json', numbers, '--markdown', table)
    assert result.exit_code == 0, result.output
    content = json.loads(numbers.read_text())
    assert list(content['protocols']) == ['scene']
    entry = content['protocols']['scene']
    assert entry['num_queries'] == 2
    assert 0.0 <= entry['five_of_five'] <= entry['three_of_five'] <= 1.0
    # The card was measured on the same split: its numbers come out again, exactly.
    assert {key: card['retrieval'][key] for key in entry} == entry
    assert content['model_hash'] == card['sha256']
    assert content['provenance']['libraries']['torch']
    names = [metric['name'] for metric in content['metrics']]
    assert names == ['w', 'mees2017_euclidean', 'mees2017_lmnn']
    assert content['metrics'][0]['protocols'] == content['protocols']
    # Of two test scenes both are of another relation: there is nothing to calibrate with.
    assert content['metrics'][0]['calibration'] is None
    assert len(table.read_text().splitlines()) == 2 + 3


def test_mixed_precision_is_an_option_and_stands_in_the_card(relations, data, tmp_path):
    out = tmp_path / 'w.safetensors'
    result = relations('train', data, '--out', out, '--steps', 1, '--precision', 'bfloat16')
    assert result.exit_code == 0, result.output
    card = json.loads(out.with_suffix('.json').read_text())
    assert card['config']['precision'] == 'bfloat16'
    assert relations('train', data, '--out', out, '--precision', 'int8').exit_code == 2


def test_any_setting_of_a_configuration_can_be_set(relations, data, tmp_path):
    out = tmp_path / 'w.safetensors'
    chosen = ['--set', 'partial_share=0', '--set', 'swap_channels=true', '--set', 'loss=all_pairs']
    result = relations('train', data, '--out', out, '--steps', 1, *chosen)
    assert result.exit_code == 0, result.output
    config = json.loads(out.with_suffix('.json').read_text())['config']
    assert (config['name'], config['loss']) == ('default', 'all_pairs')
    assert config['partial_share'] == 0.0
    assert config['swap_channels'] is True


def test_a_setting_that_training_does_not_have_is_refused(relations, data, tmp_path):
    out = tmp_path / 'w.safetensors'
    result = relations('train', data, '--out', out, '--set', 'dropout=0.3')
    assert result.exit_code == 2
    assert "no 'dropout' to set; there are encoder, steps" in ' '.join(result.stderr.split())
    assert not out.exists()


def test_an_option_and_the_same_setting_are_not_weighed_against_each_other(
    relations, data, tmp_path
):
    result = relations(
        'train', data, '--out', tmp_path / 'w.safetensors', '--steps', 3, '--set', 'steps=2'
    )
    assert result.exit_code == 2
    assert '--steps and --set steps= say the same' in ' '.join(result.stderr.split())


def test_retrieval_says_where_weights_were_trained_with_the_scenes(relations, data, tmp_path):
    out = tmp_path / 'w.safetensors'
    trained = relations('train', data, '--out', out, '--steps', 1)
    assert 'held-out scenes of the same objects (scene split1)' in ' '.join(trained.stdout.split())
    chosen = ['--weights', out, '--baselines', 'features', '--json', '-']
    result = relations('retrieve', data, *chosen)
    flags = [item['trained_on_this_data'] for item in json.loads(result.stdout)['metrics']]
    assert flags == [True, False]
    assert 'was trained with scenes of this data' in ' '.join(result.stderr.split())


def test_several_weights_are_compared_in_one_run(relations, data, weights, calibrated_weights):
    chosen = ['--weights', weights, '--weights', calibrated_weights, '--baselines', 'none']
    result = relations('retrieve', data, *chosen, '--json', '-')
    assert result.exit_code == 0, result.output
    first, second = json.loads(result.stdout)['metrics']
    assert (first['name'], second['name']) == ('untrained', 'calibrated')
    assert first['protocols'] == second['protocols']
    assert first['calibration'] is None
    novelty = second['calibration']['novelty']
    assert novelty['false_alarms'] == 1.0
    assert set(novelty['detected'].values()) == {1.0}
    assert 'calibration error' in result.stderr
    twice = relations('retrieve', data, '--weights', weights, '--weights', weights)
    assert twice.exit_code == 2
    assert 'same file twice' in twice.stderr


def test_retrieval_with_the_pose_errors_of_a_tracker(relations, data, calibrated_weights):
    chosen = ['--weights', calibrated_weights, '--baselines', 'none', '--json', '-']
    exact, wrong, again = (
        json.loads(relations('retrieve', data, *chosen, *options).stdout)
        for options in ([], ['--pose-error', 3], ['--pose-error', 3])
    )
    assert (exact['pose_error_deg'], wrong['pose_error_deg']) == (0.0, 3.0)
    assert exact['data'] == wrong['data']
    assert wrong['metrics'] == again['metrics']
    too_much = relations('retrieve', data, '--pose-error', 90)
    assert too_much.exit_code == 2


def test_retrieve_says_which_splits_there_are(relations, data, weights):
    result = relations('retrieve', data, '--weights', weights, '--protocol', 'object')
    assert result.exit_code == 2
    assert '1 scene splits and 0 object splits' in result.stderr


def test_generate_makes_what_it_says(relations, tmp_path):
    out = tmp_path / 'generated.json'
    result = relations(
        'generate', tmp_path / 'data', '--scenes', 28, '--objects', 20, '--points', 64,
        '--seed', 3, '--json', out,
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    content = json.loads(out.read_text())
    assert (content['num_scenes'], content['seed']) == (28, 3)
    assert set(content['scenes_of_relation'].values()) == {4}
    assert content['num_splits'] == 15
    assert len((tmp_path / 'data' / 'scenes.txt').read_text().splitlines()) == 29


def test_version_tells_what_computes(relations):
    content = json.loads(relations('version', '--json', '-').stdout)
    assert content['version'] == '0.1.0'
    assert {'numpy', 'torch'} <= set(content['libraries'])


@pytest.mark.parametrize('runs', [3])
def test_bench_times_what_is_asked(relations, weights, tmp_path, runs):
    out = tmp_path / 'bench.json'
    result = relations(
        'bench', '--step', 'embed', '--step', 'gradient', '--step', 'paper-gradient',
        '--runs', runs, '--weights', weights, '--json', out,
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    content = json.loads(out.read_text())
    names = ['embed', 'pose gradient', 'pose gradient of the paper']
    assert [timing['step'] for timing in content['timings']] == names
    for timing in content['timings']:
        assert timing['runs'] == runs
        assert 0.0 < timing['min'] <= timing['median'] <= timing['p90'] <= timing['max']
    _, ours, paper = content['timings']
    (ratio,) = content['ratios']
    assert ratio['step'] == 'pose gradient'
    assert ratio['ratio'] == pytest.approx(paper['median'] / ours['median'])
