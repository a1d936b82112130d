"""Dependencies run one way, and ROS stays at the border."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = 'spatial_relations_ros'
ROOT = Path(__file__).resolve().parents[1]

# Each room with those that it may import, besides itself.
ALLOWED = {
    'core': set(),
    'projection': {'core'},
    'learning': {'core', 'projection', 'datasets'},
    'placement': {'core'},
    'datasets': {'core', 'perception', 'placement'},
    'perception': {'core'},
    'memory': {'core'},
    'imitation': {'core', 'projection', 'learning', 'placement', 'datasets'},
    'pipeline': {'core', 'perception', 'datasets'},
    'visualization': {'core'},
}
ALLOWED['evaluation'] = {*ALLOWED}
ALLOWED['ros'] = {*ALLOWED}
ALLOWED['cli'] = {*ALLOWED} - {'ros', 'cli'}
ALLOWED['nodes'] = {*ALLOWED} - {'cli', 'nodes'}

ROS_ROOMS = {'ros', 'nodes'}
ROS_MODULES = {
    'rclpy',
    'ament_index_python',
    'launch',
    'launch_ros',
    'tf2_ros',
    'builtin_interfaces',
}


def modules() -> list[Path]:
    return sorted((ROOT / PACKAGE).rglob('*.py'))


def imported_names(path: Path) -> set[str]:
    """All modules that a file imports, wherever in it."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f'{path}: relative import'
            names.add(node.module or '')
            names |= {f'{node.module}.{alias.name}' for alias in node.names}
    return names


def room_of(path: Path) -> str:
    return path.relative_to(ROOT / PACKAGE).parts[0].removesuffix('.py')


def is_ros(name: str) -> bool:
    top = name.partition('.')[0]
    return top in ROS_MODULES or top.endswith(('_msgs', '_interfaces'))


def test_every_room_is_listed() -> None:
    rooms = {room_of(path) for path in modules()} - {'__init__'}
    assert rooms == set(ALLOWED)


def test_the_list_has_no_cycle() -> None:
    done: set[str] = set()
    while len(done) < len(ALLOWED):
        ready = {room for room, allowed in ALLOWED.items() if allowed <= done} - done
        assert ready, f'cycle among {set(ALLOWED) - done}'
        done |= ready


@pytest.mark.parametrize('room', sorted(ALLOWED))
def test_rooms_import_only_what_lies_below(room: str) -> None:
    for path in modules():
        if room_of(path) != room:
            continue
        for name in imported_names(path):
            parts = name.split('.')
            if parts[0] == PACKAGE and len(parts) > 1 and parts[1] in ALLOWED:
                where = path.relative_to(ROOT)
                assert parts[1] in ALLOWED[room] | {room}, f'{where} imports {name}'


def test_only_the_border_imports_ros() -> None:
    for path in modules():
        found = sorted(name for name in imported_names(path) if is_ros(name))
        if room_of(path) not in ROS_ROOMS:
            assert not found, f'{path.relative_to(ROOT)} imports {found}'


def test_the_check_sees_an_import_inside_a_function(tmp_path: Path) -> None:
    hidden = tmp_path / 'hidden.py'
    hidden.write_text('def f():\n    from sensor_msgs.msg import PointCloud2\n    import rclpy\n')
    assert {name for name in imported_names(hidden) if is_ros(name)} >= {
        'rclpy',
        'sensor_msgs.msg',
    }


def test_no_room_for_odds_and_ends() -> None:
    vague = {'utils', 'util', 'helpers', 'common', 'misc'}
    names = {path.stem for path in modules()} | {path.parent.name for path in modules()}
    assert not names & vague


@pytest.mark.ros
@pytest.mark.parametrize('node', ['perception_node', 'panel_node'])
def test_nodes_that_do_not_learn_or_draw_start_without_the_libraries_for_it(node: str) -> None:
    script = f'import sys, {PACKAGE}.nodes.{node}; print(*sys.modules)'
    loaded = subprocess.run(
        [sys.executable, '-c', script], check=True, capture_output=True, text=True, timeout=120
    ).stdout.split()
    assert f'{PACKAGE}.perception' in loaded
    assert {'torch', 'roma', 'sklearn', 'matplotlib.figure'}.isdisjoint(loaded)
