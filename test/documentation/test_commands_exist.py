"""Commands that cannot run here are checked against what there is: nothing in them is made up."""

import json
import re
from importlib.util import find_spec

import pytest
import typer
import yaml
from pages import MEASUREMENTS, REASONS, ROOT, blocks, pages

from spatial_relations_ros.cli.main import app

COMMANDS = typer.main.get_command(app).load_all()
SHELL = [block for page in pages() for block in blocks(page) if block.holds_commands]
NOT_RUN = [(block, words) for block in SHELL if block.reason for words in block.commands]
OURS = ('spatial_relations_ros', 'spatial_relations_msgs')


def test_every_block_of_commands_is_run_or_says_why_not():
    for block in SHELL:
        if block.page not in MEASUREMENTS:
            assert block.language == 'sh', f'{block.page}: a fence without sh: {block.body}'
        assert not block.reason or block.reason.startswith(REASONS), block.reason


@pytest.mark.parametrize(
    ('block', 'words'),
    NOT_RUN,
    ids=[f'{block.page}:{" ".join(words)[:60]}' for block, words in NOT_RUN],
)
def test_what_is_not_run_exists(block, words):
    while '=' in words[0]:  # VARIABLE=value command
        words = words[1:]
    if words[0] == 'torchrun':
        words = words[words.index('relations') :]
    check = {'relations': check_relations, 'make': check_make, 'python': check_python}
    if words[0] in check:
        check[words[0]](words[1:])
    elif words[0] == 'ros2':
        check_ros2(words[1:])


def check_relations(words):
    """Subcommand and options, by the command's own parser."""
    size = 2 if ' '.join(words[:2]) in COMMANDS else 1
    command = COMMANDS[' '.join(words[:size])]
    command.make_context(words[0], [word for word in words[size:] if word != '--debug'])


def check_make(words):
    targets = re.findall(r'^([a-z]+):', (ROOT / 'Makefile').read_text(), flags=re.MULTILINE)
    assert {word for word in words if '=' not in word} <= set(targets)


def check_python(words):
    if words[0] == '-m':
        assert find_spec(words[1]) is not None
    else:
        assert (ROOT / words[0]).is_file()


def check_ros2(words):
    kind, verb = words[:2]
    if kind == 'run' and words[1] in OURS:
        executables = (ROOT / 'setup.py').read_text()
        assert f"f'{words[2]} = " in executables
        return
    if kind == 'launch' and words[1] in OURS:
        text = (ROOT / 'launch' / words[2]).read_text()
        for argument in (word.partition(':=')[0] for word in words[3:]):
            assert f"'{argument}'" in text
        return
    if (kind, verb) in (('service', 'call'), ('action', 'send_goal')):
        interface = next(word for word in words if word.startswith('spatial_relations_msgs/'))
        check_request(interface, words[-1])


def check_request(interface, text):
    """The interface, and each field of the request."""
    path = ROOT / 'msg_defs' / f'{interface.partition("/")[2]}.{interface.split("/")[1]}'
    request = path.read_text().partition('\n---')[0]
    for field in yaml.safe_load(text):
        assert re.search(rf'^\S+ {field}$', request, flags=re.MULTILINE), field


@pytest.mark.parametrize('words', ['no_such_command', 'objects no_such_command x'])
def test_the_check_sees_a_command_that_does_not_exist(words):
    with pytest.raises(KeyError):
        check_relations(words.split())


def test_the_check_sees_an_option_that_does_not_exist():
    with pytest.raises(Exception, match='--no-such-option'):
        check_relations(['imitate', '--no-such-option'])


def test_the_pose_file_that_is_shown_is_the_one_that_is_used():
    page = 'docs/quick-start-pip.md'
    (shown,) = (block.body for block in blocks(page) if block.language == 'json')
    assert json.loads(shown) == json.loads((ROOT / 'examples' / 'cup_on_plate.json').read_text())
