"""What the demonstration writes when a request gave no answer."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from spatial_relations_msgs.srv import Imitate

from spatial_relations_ros.core import Scene
from spatial_relations_ros.learning import load_metric
from spatial_relations_ros.nodes.demo_plan import PlannedImitation
from spatial_relations_ros.nodes.demo_report import DemoOutcome, write_pictures, write_result


@pytest.fixture
def unanswered(solids) -> DemoOutcome:
    def scene(base: str, relative: str) -> Scene:
        return Scene(
            solids.box(base, (0.2, 0.2, 0.02), (0.0, 0.0, 0.01)),
            solids.box(relative, (0.05, 0.05, 0.1), (0.0, 0.0, 0.07)),
        )

    plan = PlannedImitation('on_top', ('plate', 'cup'), ('tray', 'mug'))
    response = Imitate.Response(message='mug is too wide', initial_distance=math.nan)
    return DemoOutcome(plan, scene('plate', 'cup'), scene('tray', 'mug'), response, None)


def test_what_is_not_known_is_null(tmp_path: Path, unanswered: DemoOutcome) -> None:
    path = tmp_path / 'result.json'
    write_result(path, [unanswered], seen={'plate/cup': 3}, model_hash='0' * 64)
    result = json.loads(path.read_text(), parse_constant=pytest.fail)
    imitation = result['imitations'][0]
    assert imitation['final_distance'] is None
    assert imitation['initial_distance'] is None
    assert imitation['problem'] == 'mug is too wide'
    assert imitation['current_poses']['mug']['t'] == pytest.approx([0.0, 0.0, 0.07])
    assert not result['success']


def test_without_an_answer_there_are_pictures_of_before(
    tmp_path: Path, unanswered: DemoOutcome, weights: Path
) -> None:
    num_pictures = write_pictures(tmp_path, unanswered, load_metric(weights))
    names = {path.stem for path in tmp_path.glob('*.png')}
    assert {'reference', 'test_before', 'test_before_projections'} <= names
    assert not {'overview', 'test_after'} & names
    assert len(names) == num_pictures
