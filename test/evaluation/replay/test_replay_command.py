"""``relations replay`` on a small simulated bag."""

import json
import shutil

import pytest
from typer.testing import CliRunner

from spatial_relations_ros.cli.main import app

from .recorded import NUM_CLOUDS

FILES = ('json', 'csv', 'html')


def run(*arguments):
    return CliRunner().invoke(app, ['replay', *map(str, arguments)])


def output_options(folder, name):
    """Options that write all files of a run."""
    return [
        '--json', folder / f'{name}.json', '--csv', folder / f'{name}.csv',
        '--report', folder / f'{name}.html',
    ]  # fmt: skip


def asked(recorded):
    """An imitation of the one demonstration of the bag."""
    return [
        '--models', recorded / 'models', '--weights', recorded / 'w.safetensors',
        '--reference', 'tray', 'cup', '--test', 'carton', 'can', '--demonstrations',
    ]  # fmt: skip


@pytest.fixture(scope='module')
def two_bags(recorded, tmp_path_factory):
    """The bag, and a copy under another name."""
    folder = tmp_path_factory.mktemp('bags')
    for name in ('first', 'second'):
        shutil.copytree(recorded / 'bag', folder / name)
    return folder / 'first', folder / 'second'


@pytest.fixture(scope='module')
def one_by_one(recorded, two_bags, tmp_path_factory):
    """All files of a replay of both in one process."""
    folder = tmp_path_factory.mktemp('serial')
    result = run(*two_bags, *asked(recorded), *output_options(folder, 'out'))
    assert result.exit_code in (0, 1), result.output
    return folder


def test_the_command_writes_the_same_files_twice(recorded, tmp_path):
    for name in ('first', 'second'):
        result = CliRunner().invoke(
            app,
            [
                'replay', str(recorded / 'bag'), '--models', str(recorded / 'models'),
                '--json', str(tmp_path / f'{name}.json'), '--csv', str(tmp_path / f'{name}.csv'),
                '--timing', str(tmp_path / 'timing.json'),
            ],
        )  # fmt: skip
        assert result.exit_code == 0, result.output
        assert f'{NUM_CLOUDS} frames' in result.output
    for suffix in ('json', 'csv'):
        first, second = (tmp_path / f'{name}.{suffix}' for name in ('first', 'second'))
        assert first.read_bytes() == second.read_bytes()
    assert json.loads((tmp_path / 'timing.json').read_text())['perception']['num'] == NUM_CLOUDS


def test_the_command_fails_when_nothing_can_be_imitated(recorded):
    result = CliRunner().invoke(
        app,
        [
            'replay', str(recorded / 'bag'), '--models', str(recorded / 'models'),
            '--reference', 'tray', 'cup', '--test', 'carton', 'teapot',
            '--weights', str(recorded / 'w.safetensors'),
        ],
    )  # fmt: skip
    assert result.exit_code == 1
    assert 'teapot' in result.output


def test_topics_that_are_named_must_be_there(recorded):
    named = ['--points-topic', '/points', '--pose-topic', 'cup=/cup/pose']
    result = run(recorded / 'bag', *named)
    assert result.exit_code == 2
    assert 'no geometry_msgs/msg/PoseStamped on /cup/pose; the bag has /points' in ' '.join(
        result.output.split()
    )
    alone = run(recorded / 'bag', '--pose-topic', '/simtrack/cup')
    assert alone.exit_code == 2
    assert '--points-topic goes together with' in ' '.join(alone.output.split())


def same_files(first, second):
    return all(
        (first / f'out.{end}').read_bytes() == (second / f'out.{end}').read_bytes()
        for end in FILES
    )


def test_two_runs_with_an_imitation_give_the_same_bytes(recorded, two_bags, one_by_one, tmp_path):
    run(*two_bags, *asked(recorded), *output_options(tmp_path, 'out'))
    assert same_files(one_by_one, tmp_path)


def test_several_processes_give_the_same_bytes(recorded, two_bags, one_by_one, tmp_path):
    result = run(*two_bags, *asked(recorded), '--jobs', 2, *output_options(tmp_path, 'out'))
    assert result.exit_code in (0, 1), result.output
    assert same_files(one_by_one, tmp_path)


def test_a_ray_cluster_gives_the_same_bytes(recorded, two_bags, one_by_one, tmp_path):
    pytest.importorskip('ray')
    options = ['--cluster', 'local', *output_options(tmp_path, 'out')]
    result = run(*two_bags, *asked(recorded), *options)
    assert result.exit_code in (0, 1), result.output
    assert same_files(one_by_one, tmp_path)


def test_several_bags_are_told_apart(one_by_one):
    content = json.loads((one_by_one / 'out.json').read_text())
    assert [entry['bag'] for entry in content['replays']] == ['first', 'second']
    assert content['summary']['num_frames'] == 2 * NUM_CLOUDS
    assert content['summary']['num_imitations'] == 2
    rows = (one_by_one / 'out.csv').read_text().splitlines()[1:]
    assert [row.split(',')[0] for row in rows] == ['first'] * NUM_CLOUDS + ['second'] * NUM_CLOUDS


def test_the_page_has_curves_and_pictures_of_each_bag(one_by_one):
    page = (one_by_one / 'out.html').read_text()
    for name in ('first', 'second'):
        assert f'<h2>{name}</h2>' in page
        assert f'{name}, frame 5' in page
    # Of each bag one of curves, and one of the demonstration, before and after.
    assert page.count('data:image/png;base64,') == 4
    assert 'id="test"' in page


def test_the_page_of_perception_alone_has_curves_and_no_viewer(recorded, tmp_path):
    options = ['--models', recorded / 'models', '--report', tmp_path / 'out.html']
    assert run(recorded / 'bag', *options).exit_code == 0
    page = (tmp_path / 'out.html').read_text()
    assert page.count('data:image/png;base64,') == 1
    assert '<canvas' not in page
    assert '<script' not in page


def test_a_bag_that_is_none_costs_itself_only(recorded, tmp_path):
    (tmp_path / 'empty').mkdir()
    options = ['--models', recorded / 'models', '--json', tmp_path / 'out.json']
    result = run(recorded / 'bag', tmp_path / 'empty', *options)
    assert result.exit_code == 1
    assert 'empty is not a bag' in result.output.replace('\n', ' ')
    good, bad = json.loads((tmp_path / 'out.json').read_text())['replays']
    assert len(good['frames']) == NUM_CLOUDS
    assert bad['bag'] == 'empty'
    assert 'not a bag' in bad['error']


def test_jobs_and_a_cluster_are_not_mixed(recorded):
    result = run(recorded / 'bag', '--jobs', 2, '--cluster', 'local')
    assert result.exit_code == 2
