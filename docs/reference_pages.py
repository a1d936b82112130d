"""Writes the reference from the code: options of ``relations``, parameters, interfaces."""

from __future__ import annotations

import importlib
import math
import pkgutil
import re
from pathlib import Path

import typer

import spatial_relations_ros.nodes
from spatial_relations_ros.cli.main import app
from spatial_relations_ros.core import atomic_write
from spatial_relations_ros.ros.parameters import ParameterSpec

INTERFACES = Path(__file__).resolve().parents[1] / 'msg_defs'
KINDS = (('msg', 'Messages'), ('srv', 'Services'), ('action', 'Actions'))
PARTS = {'srv': ('Request', 'Response'), 'action': ('Goal', 'Result', 'Feedback')}


def write_reference(folder: Path) -> None:
    """Writes the pages; one whose text is unchanged keeps its time, and is not built again."""
    pages = {
        'options.md': options_page(),
        'parameters.md': parameters_page(),
        'interfaces.md': interfaces_page(),
    }
    for name, text in pages.items():
        path = folder / name
        if not path.is_file() or path.read_text(encoding='utf-8') != text:
            with atomic_write(path) as temporary:
                temporary.write_text(text, encoding='utf-8')


def options_page() -> str:
    """Every option of every subcommand, as the command itself tells them."""
    parts = ['# Options of relations', 'Made from the command itself; `-h` shows the same.']
    for name, command in typer.main.get_command(app).load_all().items():
        parts.append(f'## relations {name}')
        parts += [' '.join(part.split()) for part in command.help.split('\n\n')]
        context = command.make_context(f'relations {name}', [], resilient_parsing=True)
        usage = ' '.join(command.collect_usage_pieces(context))
        parts.append(f'```text\nrelations {name} {usage}\n```')
        records = [item.get_help_record(context) for item in command.get_params(context)]
        rows = [(f'`{record[0]}`', record[1]) for record in records if record is not None]
        parts.append(_table(('Option', 'What'), rows))
    return _page(parts)


def parameters_page() -> str:
    """Every parameter of every node, from the specifications that the nodes declare."""
    parts = ['# Parameters of the nodes', 'Made from the specifications that the nodes declare.']
    for name, specs in node_parameters().items():
        parts.append(f'## {name}')
        rows = [(f'`{spec.name}`', _what(spec), _default(spec), _accepted(spec)) for spec in specs]
        parts.append(_table(('Parameter', 'What', 'Default', 'Accepts'), rows))
    return _page(parts)


def node_parameters() -> dict[str, tuple[ParameterSpec, ...]]:
    """The specifications by node: ``X_PARAMETERS`` of each module ``nodes/x_node``."""
    found = {}
    for module in pkgutil.iter_modules(spatial_relations_ros.nodes.__path__):
        if module.name.endswith('_node'):
            loaded = importlib.import_module(f'spatial_relations_ros.nodes.{module.name}')
            specs = f'{module.name.removesuffix("_node").upper()}_PARAMETERS'
            found[module.name] = tuple(getattr(loaded, specs))
    return found


def _default(spec: ParameterSpec) -> str:
    if isinstance(spec.default, bool):
        return f'`{str(spec.default).lower()}`'
    if isinstance(spec.default, float) and math.isnan(spec.default):
        return '`.nan`'
    return f'`{spec.default}`' if spec.default not in ('', []) else 'empty'


def _accepted(spec: ParameterSpec) -> str:
    if spec.choices:
        return ' '.join(f'`{choice}`' for choice in spec.choices)
    if isinstance(spec.default, list):
        return 'numbers' if spec.is_numbers else 'texts'
    if isinstance(spec.default, bool):
        return 'true, false'
    if isinstance(spec.default, str):
        return 'text'
    low, high = spec.minimum, spec.maximum
    if low is None and high is None:
        return 'a number'
    return f'{"" if low is None else f"{low:g}"} to {"" if high is None else f"{high:g}"}'


def _what(spec: ParameterSpec) -> str:
    return spec.description + (' Set at start only.' if spec.is_fixed else '')


def interfaces_page() -> str:
    """Messages, services and actions, with the comments of their definitions."""
    parts = ['# Messages, services, actions', 'Of the package `spatial_relations_msgs`.']
    for kind, title in KINDS:
        parts.append(f'## {title}')
        for path in sorted((INTERFACES / kind).glob(f'*.{kind}')):
            parts += _interface(path, kind)
    return _page(parts)


def _interface(path: Path, kind: str) -> list[str]:
    sections = re.split(r'^---$', path.read_text(encoding='utf-8'), flags=re.MULTILINE)
    # Comments above the first empty line are about the whole.
    about, _, first = sections[0].partition('\n\n')
    if not _is_comment(about):
        about, first = '', sections[0]
    parts = [f'### {path.stem}', *([_comment(about)] if about else [])]
    for title, section in zip(PARTS.get(kind, ('',)), [first, *sections[1:]], strict=True):
        if title:
            parts.append(f'**{title}**')
        fields = _fields(section)
        parts.append(_table(('Field', 'Type', 'What'), fields) if fields else 'Nothing.')
    return parts


def _is_comment(text: str) -> bool:
    return bool(text.strip()) and all(line.startswith('#') for line in text.strip().splitlines())


def _comment(text: str) -> str:
    return ' '.join(line.strip().lstrip('#').strip() for line in text.strip().splitlines())


def _fields(section: str) -> list[tuple[str, str, str]]:
    """Name, type and comment of each field; the comment above one or behind it."""
    rows, above = [], ''
    for line in section.splitlines():
        if not line.strip():
            above = ''
        elif line.startswith('#'):
            above = f'{above} {_comment(line)}'.strip()
        else:
            definition, _, behind = line.partition('#')
            kind, _, name = definition.strip().partition(' ')
            rows.append((f'`{name.strip()}`', f'`{kind}`', f'{above} {behind.strip()}'.strip()))
            above = ''
    return rows


def _table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = [head, tuple('---' for _ in head), *rows]
    return '\n'.join('| ' + ' | '.join(map(_cell, line)) + ' |' for line in lines)


def _cell(text: str) -> str:
    """On one line; outside of code, brackets are no HTML."""
    line = ' '.join(text.split()).replace('|', '\\|')
    return line if line.startswith('`') else line.replace('<', '\\<')


def _page(parts: list[str]) -> str:
    return '\n\n'.join(parts) + '\n'
