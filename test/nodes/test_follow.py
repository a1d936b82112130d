"""Target poses that follow a demonstration while it changes, with real nodes and a moving bag."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from geometry_msgs.msg import PoseArray
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from ros_graph import START_SEC, Graph
from simulated_table import camera_of
from spatial_relations_msgs.msg import Imitation

from spatial_relations_ros.evaluation.demo_scenario import IMITATIONS
from spatial_relations_ros.evaluation.record_demo_bag import (
    POINTS_TOPIC,
    TRACKS_TOPIC,
    RecordingOptions,
    record_demo_bag,
)
from spatial_relations_ros.nodes.bag_player import BagPlayer
from spatial_relations_ros.ros.qos import ANSWERS

pytestmark = pytest.mark.ros

FOLLOWED = ['/'.join(IMITATIONS[0].reference_ids), '/'.join(IMITATIONS[0].test_ids)]
FOLLOW_STATE = 'imitate_node: follow'


def mug_offset(targets: PoseArray) -> float:
    """Horizontal distance of the middles of mug and tray, metres."""
    tray, mug = (pose.position for pose in targets.poses)
    return math.dist((mug.x, mug.y), (tray.x, tray.y))


class Following:
    """perception_node and imitate_node before the cup that leaves the plate."""

    def __init__(self, graph: Graph, folder: Path) -> None:
        options = RecordingOptions(
            duration_sec=3.0, cloud_rate=4.0, pose_rate=20.0, is_moving=True, camera=camera_of(256)
        )
        self.graph = graph
        self.targets: list[PoseArray] = []
        self.answers: list[Imitation] = []
        bag = record_demo_bag(folder, options)
        models = str(folder / 'objects')
        graph.processes.start(
            'perception_node',
            # The scene of the last cloud stays while answers are found.
            parameters={'models_path': models, 'reliable_points': True, 'max_age': 0.0},
            remappings={'~/points': POINTS_TOPIC, '~/tracked_objects': TRACKS_TOPIC},
        )
        graph.processes.start(
            'imitate_node',
            # What is held in the air has no answer; this is about what stands.
            parameters={'models_path': models, 'standalone': False, 'follow_time_budget': 1.0},
        )
        graph.subscribe(PoseArray, '/target_poses', self.targets.append, ANSWERS)
        graph.subscribe(Imitation, '/imitate_node/imitation', self.answers.append, ANSWERS)
        self.player = BagPlayer(graph.node, bag)
        self.player.wait_for_subscribers([POINTS_TOPIC, TRACKS_TOPIC], START_SEC)

    def set_follow(self, entries: list[str]) -> str:
        """Empty when it was accepted, else the reason."""
        value = ParameterValue(
            type=ParameterType.PARAMETER_STRING_ARRAY, string_array_value=entries
        )
        result = self.graph.call(
            SetParameters,
            '/imitate_node/set_parameters',
            parameters=[Parameter(name='follow', value=value)],
        ).results[0]
        return '' if result.successful else str(result.reason)

    def state(self) -> str:
        return self.graph.diagnostic(FOLLOW_STATE)['message']


@pytest.fixture(scope='module')
def following(graph: Graph, tmp_path_factory: pytest.TempPathFactory) -> Following:
    return Following(graph, tmp_path_factory.mktemp('moving'))


def test_what_cannot_be_followed_is_refused_with_the_reason(following: Following) -> None:
    assert 'expected two' in following.set_follow(['plate/cup'])
    assert 'expected "base/relative"' in following.set_follow(['plate/plate', 'tray/mug'])
    following.graph.wait(lambda: following.state() == 'off', 'diagnostics')


def test_targets_follow_from_on_the_plate_to_beside_it(following: Following) -> None:
    assert following.set_follow(FOLLOWED) == ''
    graph = following.graph
    # At first the cup stands on the plate: the mug is to stand on the tray ...
    following.player.play(lambda _: graph.wait(lambda: bool(following.targets), 'targets'))
    assert mug_offset(following.targets[0]) < 0.08
    # ... and at the end beside it.
    graph.wait(lambda: mug_offset(following.targets[-1]) > 0.15, 'targets at the new place')
    graph.wait(lambda: int(graph.diagnostic(FOLLOW_STATE).get('updates', 0)) >= 2, 'the state')
    assert following.state().startswith('following plate/cup with tray/mug')


def test_what_stands_still_is_not_imitated_again_and_what_is_stopped_is_not(
    following: Following,
) -> None:
    graph = following.graph
    # Were it imitated again and again, the last time would never be so long ago.
    graph.wait(
        lambda: float(graph.diagnostic(FOLLOW_STATE).get('last_update_age_sec', 0.0)) > 1.5,
        'rest',
    )
    num_answers = len(following.answers)
    assert following.set_follow(['']) == ''
    graph.wait(lambda: following.state() == 'off', 'the end of it')
    following.player.play()
    assert len(following.answers) == num_answers
