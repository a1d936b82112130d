"""The commands of the documentation, run page by page as a newcomer does.

In an empty folder that looks like a checkout, in the page's order, in this process (starting one
takes seconds; test/cli/test_entry_point.py starts them). Sizes are made small, nothing else is.
"""

import os
import runpy
import sys
from pathlib import Path

import pytest
from pages import blocks, pages
from typer.testing import CliRunner

from spatial_relations_ros.cli.main import app

SMALLEST = {
    'generate': {'--scenes': '28', '--objects': '20', '--jobs': '1'},
    'train': {'--steps': '2'},
    'retrieve': {'--baselines': 'none'},
    'bench': {'--runs': '3'},
}
RUN = {
    page: [block for block in blocks(page) if block.language == 'sh' and not block.reason]
    for page in pages()
}


def with_smallest_sizes(words):
    """The arguments of ``relations`` with the options of ``SMALLEST`` set."""
    words = list(words)
    for option, value in SMALLEST.get(words[0], {}).items():
        if option in words:
            words[words.index(option) + 1] = value
        else:
            words += [option, value]
    return words


def run_relations(words):
    result = CliRunner().invoke(app, with_smallest_sizes(words))
    return result.exit_code, result.output


def run_python(words):
    """A script, in this process; what it leaves in out/ is not empty."""
    left = {path for path in Path().glob('out/**/*') if path.is_file()}
    before = sys.argv
    sys.argv = words
    try:
        runpy.run_path(words[0], run_name='__main__')
    finally:
        sys.argv = before
    new = {path for path in Path().glob('out/**/*') if path.is_file()} - left
    assert all(path.stat().st_size for path in new)
    if Path(words[0]).name != 'make_meshes.py':
        assert {path.suffix for path in new} & {'.png', '.json'}
    return 0, ''


def run(words):
    program = Path(words[0]).name
    if program == 'export':
        name, _, value = words[1].partition('=')
        os.environ[name] = os.path.expandvars(value)
        return 0, ''
    if program == 'relations':
        return run_relations(words[1:])
    if program == 'python':
        return run_python(words[1:])
    raise AssertionError(f'{words[0]} is not run here: mark the block as not run, with the reason')


@pytest.mark.parametrize('page', [page for page, found in RUN.items() if found])
def test_every_command_of_the_page_does_what_it_should(page, checkout):
    for block in RUN[page]:
        for words in block.commands:
            code, output = run(words)
            assert code in block.exit_codes, f'{" ".join(words)}\n{output}'
