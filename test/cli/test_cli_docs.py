"""The page about the command against the command."""

import re
from pathlib import Path

import pytest
import typer

from spatial_relations_ros.cli.main import app

PAGE = Path(__file__).resolve().parents[2] / 'docs' / 'cli.md'
RELATIONS = typer.main.get_command(app)
COMMANDS = RELATIONS.load_all()


def test_every_command_is_described():
    headings = ' '.join(re.findall(r'^## (.*)$', PAGE.read_text(), flags=re.MULTILINE))
    assert set(RELATIONS.commands) <= set(re.split(r'[ ,]+', headings))


def test_every_option_in_the_page_exists():
    known = {
        option
        for command in COMMANDS.values()
        for parameter in command.params
        for option in [*parameter.opts, *parameter.secondary_opts]
    } | {'--debug', '--help', '--install-completion'}
    text = re.sub(r'^torchrun .* relations', 'relations', PAGE.read_text(), flags=re.MULTILINE)
    named = set(re.findall(r'(?<![\w-])--[a-z][a-z-]*', text))
    assert named <= known


@pytest.mark.parametrize('name', sorted(COMMANDS))
def test_every_command_has_json(name):
    options = {option for parameter in COMMANDS[name].params for option in parameter.opts}
    assert '--json' in options
    assert COMMANDS[name].help


@pytest.mark.parametrize('entry', RELATIONS.entries, ids=lambda entry: entry.name)
def test_the_list_of_commands_tells_what_their_help_tells(entry):
    first_paragraph = entry.load().help.split('\n\n')[0]
    assert entry.summary == ' '.join(first_paragraph.split())
