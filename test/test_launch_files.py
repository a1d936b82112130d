"""Launch files: each argument is described and used. They are only read: launch has no wheel."""

import ast
from pathlib import Path

import pytest

from spatial_relations_ros.nodes.play_bag import make_parser

ROOT = Path(__file__).resolve().parents[1]
FILES = sorted((ROOT / 'launch').glob('*.launch.py'))
EXECUTABLES = (ROOT / 'setup.py').read_text(encoding='utf-8')


def calls(path, name):
    """Calls of a function or class by its name, with their keywords."""
    for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
        if isinstance(node, ast.Call) and getattr(node.func, 'id', '') == name:
            yield node, {keyword.arg: keyword.value for keyword in node.keywords}


def declared(path):
    return {
        node.args[0].value: keywords for node, keywords in calls(path, 'DeclareLaunchArgument')
    }


@pytest.fixture(params=FILES, ids=[path.name for path in FILES])
def path(request):
    return request.param


def test_each_argument_says_what_it_is(path):
    arguments = declared(path)
    assert arguments
    for name, keywords in arguments.items():
        assert 'description' in keywords, name
        assert len(ast.literal_eval(keywords['description'])) > 5, name


def test_each_argument_is_used_and_nothing_else_is(path):
    used = {
        node.args[0].value
        for node, _ in calls(path, 'LaunchConfiguration')
        if isinstance(node.args[0], ast.Constant)
    }
    constants = {
        target.id: ast.literal_eval(node.value)
        for node in ast.parse(path.read_text(encoding='utf-8')).body
        if isinstance(node, ast.Assign)
        for target in node.targets
    }
    assert used | set(constants.get('PASSED_ON', ())) == set(declared(path))


def test_what_replay_passes_on_is_an_argument_of_live():
    """With the same default, since it overrides that of live."""
    live, replay = (declared(ROOT / 'launch' / f'{name}.launch.py') for name in ('live', 'replay'))
    for name in set(live) & set(replay):
        default = live[name]['default_value']
        assert ast.dump(replay[name]['default_value']) == ast.dump(default), name


def test_each_executable_that_is_started_is_installed(path):
    for _, keywords in calls(path, 'Node'):
        if ast.literal_eval(keywords['package']) == 'spatial_relations_ros':
            assert f"f'{ast.literal_eval(keywords['executable'])} = " in EXECUTABLES


def test_the_player_knows_the_options_that_it_is_started_with():
    text = (ROOT / 'launch' / 'replay.launch.py').read_text(encoding='utf-8')
    options = {
        node.value
        for node in ast.walk(ast.parse(text))
        if isinstance(node, ast.Constant) and str(node.value).startswith('--')
    }
    assert options == {'--rate', '--wait', '--wait-for', '--loop'}
    command = ['bag', '--rate', '1.0', '--wait', '120', '--wait-for', '/points', '--loop']
    assert make_parser().parse_args(command).wait_for == ['/points']
