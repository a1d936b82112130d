"""Three nodes as processes, the recorded bag over DDS, and all that can be asked of them."""

from __future__ import annotations

import array
import itertools
import math
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseArray, PoseStamped
from rcl_interfaces.msg import Parameter, ParameterType, ParameterValue
from rcl_interfaces.srv import SetParameters
from ros_graph import ANSWER_SEC, START_SEC, Graph
from sensor_msgs.msg import PointCloud2
from spatial_relations_msgs.action import ImitateRelation
from spatial_relations_msgs.msg import Imitation, MovePlan
from spatial_relations_msgs.msg import Scene as SceneMsg
from spatial_relations_msgs.srv import (
    Distance,
    Embed,
    Forget,
    GetScene,
    Imitate,
    ListRelations,
    Nearest,
    Recall,
    Remember,
)
from visualization_msgs.msg import MarkerArray

from spatial_relations_ros.core import Pose
from spatial_relations_ros.evaluation.bag_reader import BagReader, BagTopics
from spatial_relations_ros.learning import load_metric
from spatial_relations_ros.nodes.bag_player import BagPlayer
from spatial_relations_ros.nodes.demo_plan import DemoPlan, read_demo_plan
from spatial_relations_ros.perception.messages import read_pose, stamp_ns
from spatial_relations_ros.perception.point_cloud2 import read_xyz
from spatial_relations_ros.pipeline import LibraryModels, Pipeline
from spatial_relations_ros.ros.conversions import header_to_msg, scene_from_msg
from spatial_relations_ros.ros.qos import ANSWERS, SCENES, latest_cloud
from spatial_relations_ros.ros.waiting import wait_for

pytestmark = pytest.mark.ros


class Session:
    """The graph after the bag has been played once."""

    def __init__(self, graph: Graph, plan: DemoPlan) -> None:
        self.graph, self.plan = graph, plan
        self.scenes: Counter[tuple[str, str]] = Counter()
        self.markers: list[MarkerArray] = []
        self.targets: list[PoseArray] = []
        self.single_targets: list[PoseStamped] = []
        self.grippers: list[PoseStamped] = []
        self.imitations: list[Imitation] = []
        self.plans: list[MovePlan] = []
        self.is_playing = True
        self.last_cloud: PointCloud2 | None = None
        test_id = plan.imitations[0].test_ids[1]
        graph.subscribe(SceneMsg, '/perception_node/scenes', self._on_scene, SCENES)
        graph.subscribe(MarkerArray, '/perception_node/markers', self.markers.append, SCENES)
        graph.subscribe(PoseArray, '/target_poses', self.targets.append, ANSWERS)
        graph.subscribe(
            PoseStamped, f'/target_pose/{test_id}', self.single_targets.append, ANSWERS
        )
        graph.subscribe(PoseStamped, f'/gripper_target/{test_id}', self.grippers.append, ANSWERS)
        graph.subscribe(Imitation, '/imitate_node/imitation', self.imitations.append, ANSWERS)
        graph.subscribe(MovePlan, '/imitate_node/moves', self.plans.append, ANSWERS)
        qos = latest_cloud(is_reliable=True)
        graph.subscribe(PointCloud2, plan.points_topic, self._on_cloud, qos)
        self.cloud_publisher = graph.node.create_publisher(PointCloud2, plan.points_topic, qos)

    def _on_scene(self, message: SceneMsg) -> None:
        self.scenes[message.base.object_id, message.relative.object_id] += 1

    def _on_cloud(self, message: PointCloud2) -> None:
        if self.is_playing:
            self.last_cloud = message

    @property
    def reference_ids(self) -> list[str]:
        return list(self.plan.imitations[0].reference_ids)

    @property
    def test_ids(self) -> list[str]:
        return list(self.plan.imitations[0].test_ids)

    def call(self, kind: Any, service: str, /, **fields: Any) -> Any:
        return self.graph.call(kind, service, **fields)

    def imitate(self, **fields: Any) -> Any:
        asked = {'reference_ids': self.reference_ids, 'test_ids': self.test_ids, **fields}
        return self.call(Imitate, '/imitate', **asked)


@pytest.fixture(scope='module')
def session(
    graph: Graph, bags: Path, weights: Path, tmp_path_factory: pytest.TempPathFactory
) -> Session:
    plan = read_demo_plan(bags / 'demo.yaml')
    memory = tmp_path_factory.mktemp('memory') / 'relations.sqlite3'
    models = str(plan.models_path)
    graph.processes.start(
        'perception_node',
        parameters={
            'models_path': models,
            'reliable_points': True,
            'publish_rate': 2.0,
            'find_clutter': True,
            'max_age': 0.0,
            # A second source of poses; the model is that of `mug`.
            'pose_topics': ['mug_2=/simtrack/mug'],
        },
        remappings={
            '~/points': plan.points_topic,
            '~/tracked_objects': plan.tracked_objects_topic,
        },
    )
    graph.processes.start(
        'metric_node', parameters={'weights': str(weights), 'memory_path': str(memory)}
    )
    graph.processes.start(
        'imitate_node',
        parameters={
            'weights': str(weights),
            'models_path': models,
            'standalone': False,
            # The steps end a request, not the clock: the same on a busy machine.
            'time_budget': 0.0,
            'num_starts': 2,
            'max_steps': 4,
            'publish_infeasible': True,
            # How the gripper holds what is moved.
            'grasps': [f'{plan.imitations[0].test_ids[1]}=0 0 0.1 1 0 0 0'],
        },
    )
    session = Session(graph, plan)
    graph.call(ListRelations, '/metric_node/list')
    player = BagPlayer(graph.node, plan.bag)
    graph.wait(lambda: graph.node.count_subscribers(plan.points_topic) >= 2, 'perception')
    player.wait_for_subscribers([plan.points_topic, plan.tracked_objects_topic], START_SEC)
    assert player.play() == sum(count for _, count in player.contents.values())
    pair = (session.reference_ids[0], session.reference_ids[1])
    graph.wait(lambda: session.scenes[pair] > 0, 'a scene of the demonstration')
    session.is_playing = False
    return session


def test_scenes_and_markers_of_all_pairs_are_published(session: Session) -> None:
    object_ids = {'plate', 'cup', 'pot', 'can', 'tray', 'basket', 'mug', 'mug_2'}
    pairs = set(itertools.permutations(object_ids, 2))
    session.graph.wait(lambda: set(session.scenes) == pairs, 'a scene of each pair')
    session.graph.wait(lambda: bool(session.markers), 'markers')
    assert {marker.text for marker in session.markers[-1].markers if marker.text} == object_ids


def test_the_live_scene_is_that_of_the_replay(session: Session) -> None:
    """The node and the bag reader feed the same pipeline the same messages."""
    plan = session.plan
    pipeline = Pipeline(models=LibraryModels(plan.models_path))
    topics = BagTopics(plan.points_topic, (plan.tracked_objects_topic,))
    live = session.call(GetScene, '/perception_node/get_scene', object_ids=session.reference_ids)
    assert live.success, live.message
    scene = scene_from_msg(live.scene)
    with BagReader(plan.bag, topics) as reader:
        for frame in reader.frames():
            result = pipeline.step(frame)
            if result.stamp_ns == scene.stamp_ns:
                break
    replayed = pipeline.scene(*session.reference_ids)
    assert scene.stamp_ns == replayed.stamp_ns
    for seen, again in zip(scene.objects, replayed.objects, strict=True):
        np.testing.assert_array_equal(seen.points, again.points)
        # Which of two poses at nearly the same time came first may differ over DDS.
        assert seen.world_from_object.is_close(
            again.world_from_object, metres=0.01, angle_rad=0.05
        )
    assert live.table_height == pytest.approx(result.table_height, abs=0.01)


def test_imitate_answers_and_publishes_the_targets(session: Session) -> None:
    session.targets.clear(), session.single_targets.clear(), session.imitations.clear()
    response = session.imitate()
    assert response.answers, response.message
    best = response.answers[0]
    base, relative = best.targets
    assert [base.object_id, relative.object_id] == session.test_ids
    assert best.distance < response.initial_distance
    assert response.distance_history[0] == pytest.approx(response.initial_distance)
    session.graph.wait(
        lambda: bool(session.targets and session.single_targets and session.imitations), 'targets'
    )
    assert session.targets[-1].header.frame_id == session.plan.world_frame
    published = [read_pose(pose) for pose in session.targets[-1].poses]
    for pose, target in zip(published, (base, relative), strict=True):
        assert pose.is_close(read_pose(target.target.pose))
    assert read_pose(session.single_targets[-1].pose).is_close(published[1])
    assert session.imitations[-1].distance == pytest.approx(best.distance)
    # Only the relative object may move unless the request says otherwise.
    assert published[0].is_close(read_pose(base.current.pose))
    assert not published[1].is_close(read_pose(relative.current.pose))


def test_the_gripper_and_the_order_of_moves_are_published(session: Session) -> None:
    session.grippers.clear(), session.plans.clear()
    response = session.imitate()
    assert response.answers, response.message
    session.graph.wait(lambda: bool(session.grippers and session.plans), 'gripper and plan')
    target = response.answers[0].targets[1]
    grasp = Pose(np.array([0.0, 0.0, 0.1]), np.array([0.0, 1.0, 0.0, 0.0]))
    gripper = read_pose(session.grippers[-1].pose)
    assert gripper.is_close(read_pose(target.target.pose) @ grasp)
    (move,) = session.plans[-1].moves
    assert (move.object_id, move.to_target, move.has_grasp) == (session.test_ids[1], True, True)
    assert read_pose(move.gripper_target).is_close(gripper)
    assert read_pose(move.approach).is_close(read_pose(target.approach.pose))


def test_what_else_is_seen_comes_with_a_scene_when_asked(session: Session) -> None:
    plain = session.call(GetScene, '/perception_node/get_scene', object_ids=session.test_ids)
    asked = session.call(
        GetScene, '/perception_node/get_scene', object_ids=session.test_ids, with_others=True
    )
    assert not plain.others
    others = {item.object_id for item in asked.others}
    assert others == {'plate', 'cup', 'pot', 'can', 'tray', 'basket', 'mug', 'mug_2'} - set(
        session.test_ids
    )
    assert not plain.clutter.width
    clutter = read_xyz(asked.clutter).points
    assert asked.clutter.header.frame_id == session.plan.world_frame
    # What belongs to an object or to the table is left out.
    assert (clutter[:, 2] > asked.table_height).all()
    mug = scene_from_msg(asked.scene).relative.world_from_object.translation
    assert (np.linalg.norm(clutter - mug, axis=1) > 0.03).all()


def test_the_other_object_moves_when_asked(session: Session) -> None:
    response = session.imitate(movable_ids=[session.test_ids[0]])
    assert response.answers, response.message
    base, relative = response.answers[0].targets
    assert read_pose(relative.target.pose).is_close(read_pose(relative.current.pose))
    assert not read_pose(base.target.pose).is_close(read_pose(base.current.pose))


def _set(session: Session, node: str, name: str, value: float) -> None:
    kind = ParameterType.PARAMETER_INTEGER if isinstance(value, int) else None
    setting = (
        ParameterValue(type=kind, integer_value=value)
        if kind
        else ParameterValue(type=ParameterType.PARAMETER_DOUBLE, double_value=value)
    )
    response = session.call(
        SetParameters,
        f'/{node}/set_parameters',
        parameters=[Parameter(name=name, value=setting)],
    )
    assert response.results[0].successful, response.results[0].reason


def test_old_scenes_are_refused(session: Session) -> None:
    _set(session, 'perception_node', 'max_age', 0.001)
    try:
        response = session.imitate()
    finally:
        _set(session, 'perception_node', 'max_age', 0.0)
    assert not response.success
    assert 'max_age is 0.001 s' in response.message
    assert session.plan.points_topic in response.message


def test_the_action_gives_feedback_and_honours_cancel(session: Session) -> None:
    client = session.graph.action(ImitateRelation, '/imitate_relation')
    feedback: list[Any] = []
    goal = ImitateRelation.Goal(
        reference_ids=session.reference_ids, test_ids=session.test_ids, time_budget=600.0
    )
    _set(session, 'imitate_node', 'max_steps', 10_000)
    try:
        sent = client.send_goal_async(
            goal, feedback_callback=lambda item: feedback.append(item.feedback)
        )
        handle = wait_for(sent, ANSWER_SEC)
        assert handle.accepted
        session.graph.wait(
            lambda: len(feedback) >= 5 and feedback[-1].step > 1, 'feedback of several steps'
        )
        assert wait_for(handle.cancel_goal_async(), ANSWER_SEC).goals_canceling
        outcome = wait_for(handle.get_result_async(), ANSWER_SEC)
    finally:
        _set(session, 'imitate_node', 'max_steps', 4)
    assert outcome.status == GoalStatus.STATUS_CANCELED
    assert 'cancelled' in outcome.result.message
    # The best so far, not nothing.
    assert [target.object_id for target in outcome.result.answers[0].targets] == session.test_ids
    steps = [item.step for item in feedback]
    assert steps == sorted(steps)
    # It ended long before it would have by itself.
    assert steps[-1] < 5_000
    assert all(item.best.targets for item in feedback)
    client.destroy()


def test_the_action_ends_like_the_service(session: Session) -> None:
    client = session.graph.action(ImitateRelation, '/imitate_relation')
    goal = ImitateRelation.Goal(
        reference_ids=session.reference_ids, test_ids=session.test_ids, time_budget=600.0
    )
    outcome = wait_for(wait_for(client.send_goal_async(goal), ANSWER_SEC).get_result_async(), 90)
    expected = session.imitate(time_budget=600.0)
    assert outcome.result.message == expected.message
    wanted = GoalStatus.STATUS_SUCCEEDED if expected.success else GoalStatus.STATUS_ABORTED
    assert outcome.status == wanted
    assert outcome.result.answers[0].distance == pytest.approx(
        expected.answers[0].distance, rel=1e-3
    )
    client.destroy()


@pytest.mark.parametrize(
    ('fields', 'words'),
    [
        ({'test_ids': ['tray', 'teapot']}, ['teapot', 'known objects', 'mug']),
        ({'test_ids': ['mug', 'mug']}, ['two different objects']),
        ({'test_ids': ['mug']}, ['two object ids', '[base, relative]']),
        ({'test_ids': []}, ['test: nothing is given']),
        ({'reference_ids': []}, ['reference: nothing is given']),
        ({'reference_name': 'on_the_moon', 'reference_ids': []}, ['on_the_moon']),
        ({'reference_name': 'both'}, ['only one']),
        ({'movable_ids': ['spoon']}, ['spoon', 'test objects are']),
        ({'time_budget': -1.0}, ['time_budget']),
        ({'test_scene': [SceneMsg(), SceneMsg()], 'test_ids': []}, ['2 scenes']),
        ({'test_scene': [SceneMsg()], 'test_ids': []}, ['no field x']),
    ],
)
def test_a_request_that_cannot_be_served_says_why(
    session: Session, fields: dict[str, Any], words: list[str]
) -> None:
    response = session.imitate(**fields)
    assert not response.success
    assert not response.answers
    for word in words:
        assert word in response.message


def test_embeddings_and_distances_are_those_of_the_metric(session: Session, weights: Path) -> None:
    metric = load_metric(weights)
    found = session.call(GetScene, '/perception_node/get_scene', object_ids=session.test_ids)
    by_ids = session.call(Embed, '/metric_node/embed', object_ids=session.test_ids)
    by_scene = session.call(Embed, '/metric_node/embed', scene=[found.scene])
    assert by_ids.model_hash == metric.model_hash
    expected = metric.embed_scenes([scene_from_msg(found.scene)])[0]
    np.testing.assert_allclose(by_ids.embedding, expected, atol=1e-4)
    np.testing.assert_allclose(by_scene.embedding, expected, atol=1e-4)
    same = session.call(
        Distance,
        '/metric_node/distance',
        reference_ids=session.test_ids,
        test_scene=[found.scene],
    )
    other = session.call(
        Distance,
        '/metric_node/distance',
        reference_ids=session.reference_ids,
        test_ids=session.test_ids,
    )
    assert same.distance == pytest.approx(0.0, abs=1e-3)
    assert other.distance > same.distance
    # Scenes given and not seen: what else is answered is that of the metric exactly.
    given = session.call(
        Distance,
        '/metric_node/distance',
        reference_scene=[found.scene],
        test_scene=[found.scene],
    )
    scene = scene_from_msg(found.scene)
    compared = metric.compare(scene, scene)
    answered = (given.same_relation_probability, given.reference_novelty, given.test_novelty)
    np.testing.assert_allclose(
        answered, (compared.same_relation_probability, *compared.novelty), rtol=1e-3
    )
    assert (given.reference_is_novel, given.test_is_novel) == compared.is_novel
    np.testing.assert_allclose(by_scene.novelty, metric.novelty(expected), rtol=1e-3)
    assert by_scene.is_novel == compared.is_novel[0]
    wrong = session.call(Distance, '/metric_node/distance', reference_ids=session.test_ids)
    assert not wrong.success
    assert 'test: nothing is given' in wrong.message


def test_relations_are_remembered_found_imitated_and_forgotten(session: Session) -> None:
    assert not session.call(Nearest, '/metric_node/nearest', object_ids=session.test_ids).success
    for name, object_ids in (('shown', session.reference_ids), ('apart', session.test_ids)):
        stored = session.call(Remember, '/metric_node/remember', name=name, object_ids=object_ids)
        assert stored.success, stored.message
    again = session.call(
        Remember, '/metric_node/remember', name='shown', object_ids=session.test_ids
    )
    assert not again.success
    assert 'shown' in again.message
    listed = session.call(ListRelations, '/metric_node/list')
    assert list(listed.names) == ['apart', 'shown']
    assert list(listed.base_ids) == [session.test_ids[0], session.reference_ids[0]]
    nearest = session.call(Nearest, '/metric_node/nearest', object_ids=session.reference_ids, k=2)
    assert list(nearest.names) == ['shown', 'apart']
    assert nearest.distances[0] == pytest.approx(0.0, abs=1e-3)
    recalled = session.call(Recall, '/metric_node/recall', name='shown')
    assert scene_from_msg(recalled.scene).object_ids == tuple(session.reference_ids)
    imitated = session.imitate(reference_ids=[], reference_name='shown')
    assert imitated.answers, imitated.message
    assert session.call(Forget, '/metric_node/forget', name='shown').success
    gone = session.call(Forget, '/metric_node/forget', name='shown')
    assert not gone.success
    assert "'apart'" in gone.message


Breakage = Callable[[PointCloud2], None]


def _copy(cloud: PointCloud2) -> PointCloud2:
    return PointCloud2(
        header=cloud.header,
        height=cloud.height,
        width=cloud.width,
        fields=cloud.fields,
        is_bigendian=cloud.is_bigendian,
        point_step=cloud.point_step,
        row_step=cloud.row_step,
        data=cloud.data,
        is_dense=cloud.is_dense,
    )


def _wrong_row_step(cloud: PointCloud2) -> None:
    cloud.row_step = cloud.width * cloud.point_step - 1


def _no_point_step(cloud: PointCloud2) -> None:
    cloud.point_step = 0


def _all_nan(cloud: PointCloud2) -> None:
    values = np.frombuffer(cloud.data, dtype=np.float32)
    cloud.data = array.array('B', np.full_like(values, math.nan).tobytes())


def _too_short(cloud: PointCloud2) -> None:
    cloud.data = cloud.data[:1000]


def _no_frame(cloud: PointCloud2) -> None:
    cloud.header = type(cloud.header)(stamp=cloud.header.stamp)


def _unknown_frame(cloud: PointCloud2) -> None:
    cloud.header = type(cloud.header)(stamp=cloud.header.stamp, frame_id='nowhere')


def _big_endian(cloud: PointCloud2) -> None:
    """All fields of the Kinect2's clouds have four bytes."""
    words = np.frombuffer(cloud.data, dtype='<u4')
    cloud.data = array.array('B', words.astype('>u4').tobytes())
    cloud.is_bigendian = True


@pytest.mark.parametrize(
    ('breakage', 'word'),
    [
        (_wrong_row_step, 'row_step'),
        (_no_point_step, 'point_step is 0'),
        (_too_short, 'data has 1000 bytes'),
        (_no_frame, 'without a frame_id'),
        (_unknown_frame, 'nowhere'),
        (_all_nan, 'no finite points'),
    ],
)
def test_a_malformed_cloud_is_reported_and_survived(
    session: Session, breakage: Breakage, word: str
) -> None:
    assert session.last_cloud is not None
    cloud = _copy(session.last_cloud)
    breakage(cloud)
    session.cloud_publisher.publish(cloud)

    def is_reported() -> bool:
        values = session.graph.diagnostic('perception_node: ~/points')
        return word in values.get('last_bad_reason', '') and word in values['message']

    session.graph.wait(is_reported, f'a diagnosis with {word!r}')
    assert session.graph.diagnostic('perception_node: ~/points')['level'] == '1'
    response = session.call(
        GetScene, '/perception_node/get_scene', object_ids=session.reference_ids
    )
    # Unreadable clouds change nothing; one without points or place has no objects.
    is_unusable = breakage in (_all_nan, _unknown_frame)
    assert response.success != is_unusable
    assert (word in response.message) == is_unusable


def test_a_big_endian_cloud_is_read(session: Session) -> None:
    """It has a stamp of its own: no other cloud can give its scene."""
    assert session.last_cloud is not None
    cloud = _copy(session.last_cloud)
    _big_endian(cloud)
    stamp = header_to_msg(stamp_ns(cloud.header.stamp) + 1, '').stamp
    cloud.header = type(cloud.header)(stamp=stamp, frame_id=cloud.header.frame_id)

    def is_seen() -> bool:
        session.cloud_publisher.publish(cloud)
        ids = session.reference_ids
        found = session.call(GetScene, '/perception_node/get_scene', object_ids=ids)
        return found.success and found.scene.header.stamp == stamp

    session.graph.wait(is_seen, 'a scene of the big-endian cloud')


def test_diagnostics_tell_rates_states_and_memory(session: Session) -> None:
    graph = session.graph
    graph.wait(lambda: 'imitate_node: model' in graph.diagnostics, 'diagnostics')
    points = graph.diagnostic('perception_node: ~/points')
    assert int(points['received']) > 5
    assert {'rate_hz', 'age_sec', 'bad'} <= points.keys()
    assert float(graph.diagnostic('metric_node: process')['memory_mb']) > 50.0
    assert len(graph.diagnostic('imitate_node: model')['sha256']) == 64
    assert graph.diagnostic('imitate_node: standalone')['message'] == 'off'
