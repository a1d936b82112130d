"""``relations generalize`` from its arguments to its files."""

import json
import re

import pytest

SMALL = ('--cases', 2, '--variants', 'no-gradient,features', '--variant-cases', 1)
TIMES = ('seconds', 'cpu_seconds')


def without_times(value):
    if isinstance(value, dict):
        return {key: without_times(item) for key, item in value.items() if key not in TIMES}
    return [without_times(item) for item in value] if isinstance(value, list) else value


def test_the_same_seed_gives_the_same_json(relations, data, weights, tmp_path):
    found = []
    for name in ('first', 'second'):
        result = relations(
            'generalize', data, *SMALL, '--no-physics', '--weights', weights,
            '--json', tmp_path / f'{name}.json', '--markdown', tmp_path / f'{name}.md',
            '--pictures', tmp_path / name, '--report', tmp_path / f'{name}.html',
        )  # fmt: skip
        assert result.exit_code in (0, 1), result.output
        content = json.loads((tmp_path / f'{name}.json').read_text())
        right = sum(
            entry['imitated'] and entry['feasible']
            for entry in content['cases']
            if entry['variant'] == 'no-gradient'
        )
        assert result.exit_code == (0 if right else 1)
        assert content.pop('pictures') == [
            str(tmp_path / name / f'known_{variant}_01.png')
            for variant in ('no-gradient', 'features')
        ]
        found.append(without_times(content))
    assert found[0] == found[1]
    content = found[0]
    assert [(entry['case'], entry['variant']) for entry in content['cases']] == [
        (0, 'no-gradient'), (content['cases'][1]['case'], 'no-gradient'), (0, 'features'),
    ]  # fmt: skip
    assert content['simulated'] is False
    (experiment,) = content['experiments']
    assert set(experiment['references'].values()) == {'on_top', 'next_to'}
    shown = re.search(
        r'type="application/json">(.*?)</script>', (tmp_path / 'first.html').read_text()
    )
    assert shown is not None
    entries = {f'known {entry["case"]}, {entry["variant"]}, ': entry for entry in content['cases']}
    for case in json.loads(shown[1])['cases']:
        (entry,) = (entry for start, entry in entries.items() if case['title'].startswith(start))
        assert case['success'] == (entry['imitated'] and entry['feasible'])
        ends = case['answers'][0]['way'][-1]['poses']
        assert ends[1][:3] == pytest.approx(entry['poses']['relative']['t'], abs=1e-5)
    text = (tmp_path / 'first.md').read_text()
    assert re.search(r'^\| known \| no-gradient \| \d of 2 \|', text, flags=re.MULTILINE)


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (('--variants', 'ours,theirs'), "no variant 'theirs'; there are ours"),
        (('--variants', ' , '), 'no variant at all'),
        (('--no-known',), 'nothing to imitate'),
        (('--no-known', '--unknown', 'NONE'), 'holds 0 models'),
        (('--weights', 'NONE'), 'does not exist'),
    ],
)
def test_bad_input(relations, data, tmp_path, arguments, message):
    places = {'NONE': tmp_path / 'none'}
    result = relations(
        'generalize', data, '--no-physics', *(places.get(item, item) for item in arguments)
    )
    assert result.exit_code == 2, result.output
    assert message in result.stderr
    assert 'Traceback' not in result.stderr
