"""The reference that is made from the code names everything that there is."""

import importlib.util
import re

import pytest
from pages import ROOT

spec = importlib.util.spec_from_file_location('reference_pages', ROOT / 'docs/reference_pages.py')
reference_pages = importlib.util.module_from_spec(spec)
spec.loader.exec_module(reference_pages)


def test_parameters_of_every_node():
    page = reference_pages.parameters_page()
    nodes = re.findall(r"f'(\w+_node) = ", (ROOT / 'setup.py').read_text())
    assert len(nodes) >= 3
    for node in nodes:
        section = page.partition(f'## {node}\n')[2].partition('\n## ')[0]
        config = (ROOT / 'config' / f'{node}.yaml').read_text()
        named = re.findall(r'^    (\w+):', config, flags=re.MULTILINE)
        assert named
        for parameter in named:
            assert f'| `{parameter}` |' in section


def test_options_of_every_command():
    page = reference_pages.options_page()
    assert '## relations objects add\n' in page
    assert '| `--reference-base FILE` | Model of the reference base, or its name. |' in page
    assert page.count('--json OUT') == page.count('\n## ')


@pytest.mark.parametrize('kind', ['msg', 'srv', 'action'])
def test_fields_of_every_interface(kind):
    page = reference_pages.interfaces_page()
    for path in (ROOT / 'msg_defs' / kind).glob(f'*.{kind}'):
        section = page.partition(f'### {path.stem}\n')[2].partition('\n### ')[0]
        for line in path.read_text().splitlines():
            definition = line.partition('#')[0].split()
            if len(definition) > 1:
                assert f'`{" ".join(definition[1:])}`' in section


def test_pages_are_written_and_an_unchanged_one_is_left_alone(tmp_path):
    reference_pages.write_reference(tmp_path)
    times = {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()}
    assert len(times) == 3
    reference_pages.write_reference(tmp_path)
    assert {path: path.stat().st_mtime_ns for path in tmp_path.iterdir()} == times
