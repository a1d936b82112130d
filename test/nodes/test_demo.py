"""The demonstration's plan and what it says when something is missing."""

from __future__ import annotations

from pathlib import Path

import pytest
from rosbags.rosbag2 import Writer

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.nodes import demo
from spatial_relations_ros.nodes.answer_publisher import topic_token
from spatial_relations_ros.nodes.demo_plan import read_demo_plan

PLAN = """
bag: demo
models_path: objects
world_frame: world
points_topic: /points
tracked_objects_topic: /tracked_objects
imitations:
  - relation: on_top
    reference_ids: [plate, cup]
    test_ids: [tray, mug]
"""


def test_the_recorded_plan_is_complete(bags: Path) -> None:
    plan = read_demo_plan(bags / 'demo.yaml')
    assert plan.bag.is_dir()
    assert len(plan.imitations) >= 2
    for planned in plan.imitations:
        for object_id in (*planned.reference_ids, *planned.test_ids):
            assert (plan.models_path / f'{object_id}.ply').is_file()


@pytest.mark.parametrize(
    ('content', 'word'),
    [
        (PLAN.replace('bag: demo', ''), "lacks 'bag'"),
        (PLAN.replace('[plate, cup]', '[plate]'), 'no demonstration plan'),
        (PLAN.replace('imitations:', 'imitations: 3 #'), 'no demonstration plan'),
        ('[', 'no demonstration plan'),
    ],
)
def test_a_bad_plan_is_a_clear_error(tmp_path: Path, content: str, word: str) -> None:
    path = tmp_path / 'demo.yaml'
    path.write_text(content)
    with pytest.raises(ConfigError, match=word):
        read_demo_plan(path)


def test_no_plan(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert demo.main(['--bags', str(tmp_path), '--out', str(tmp_path / 'out')]) == 1
    assert 'demo.yaml cannot be read' in capsys.readouterr().out.replace('\n', ' ')


def test_missing_weights(tmp_path: Path, capsys: pytest.CaptureFixture[str], bags: Path) -> None:
    arguments = ['--bags', str(bags), '--out', str(tmp_path), '--weights', str(tmp_path / 'w')]
    assert demo.main(arguments) == 1
    assert 'does not exist' in capsys.readouterr().out.replace('\n', ' ')


def test_an_empty_bag(tmp_path: Path, capsys: pytest.CaptureFixture[str], weights: Path) -> None:
    (tmp_path / 'objects').mkdir()
    with Writer(tmp_path / 'demo', version=9):
        pass
    (tmp_path / 'demo.yaml').write_text(PLAN)
    arguments = ['--bags', str(tmp_path), '--out', str(tmp_path / 'out'), '--weights']
    assert demo.main([*arguments, str(weights)]) == 1
    assert 'holds no messages' in capsys.readouterr().out.replace('\n', ' ')


def test_an_earlier_result_is_removed_and_nothing_else(tmp_path: Path) -> None:
    (tmp_path / 'demo.yaml').write_text(PLAN)
    out = tmp_path / 'out'
    for name in ('result.json', 'reference.png', 'inside/distance.png', 'log/a.log', 'mine.txt'):
        path = out / name
        path.parent.mkdir(exist_ok=True, parents=True)
        path.write_text('old')
    missing = str(tmp_path / 'no.safetensors')
    assert demo.main(['--bags', str(tmp_path), '--out', str(out), '--weights', missing]) == 1
    assert {path.name for path in out.rglob('*') if path.is_file()} == {'mine.txt'}


def test_object_ids_become_topic_names() -> None:
    assert topic_token('cup_2') == 'cup_2'
    assert topic_token('milk-carton.1') == 'milk_carton_1'
    assert topic_token('2cups') == '_2cups'
