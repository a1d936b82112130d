"""Trackers that lie, before a simulated Kinect2: what is believed of them, frame by frame."""

import math
from dataclasses import replace

import numpy as np
import pytest

from spatial_relations_ros.core import Pose
from spatial_relations_ros.perception.border import StampedTransform, TrackedPose
from spatial_relations_ros.perception.config import PerceptionConfig
from spatial_relations_ros.perception.evidence import SupportConfig, support_at
from spatial_relations_ros.perception.point_cloud2 import PointCloud
from spatial_relations_ros.perception.scene_perception import ScenePerception
from spatial_relations_ros.perception.track_state import TrackState
from spatial_relations_ros.perception.view import View

STAMP_NS = 1_700_000_000_000_000_000
SEC = 1_000_000_000
TRACKED, UNCERTAIN, LOST = TrackState


class Run:
    """Frames of one cloud, 5 a second, with what trackers say in each."""

    def __init__(self, tabletop, *, models=True, **config):
        self.tabletop = tabletop
        self.perception = ScenePerception(PerceptionConfig(**config), tabletop if models else None)
        self.stamp_ns = STAMP_NS

    def step(self, places=None, *, seconds=0.2, cloud=None, silent=()):
        """One frame later; ``places`` maps ids to the id of the object that is tracked."""
        self.stamp_ns += round(seconds * SEC)
        tracks = []
        for object_id in self.tabletop.poses:
            if object_id in silent:
                continue
            shown = (places or {}).get(object_id, object_id)
            if isinstance(shown, str):
                track = self.tabletop.track(shown, stamp_ns=self.stamp_ns)
            else:
                track = self.tabletop.track(object_id, stamp_ns=self.stamp_ns, offset=shown)
            tracks.append(replace(track, object_id=object_id))
        return self.perception.step(
            self.tabletop.frame(tracks, stamp_ns=self.stamp_ns, cloud=cloud)
        )

    def states(self, num_frames, *arguments, **options):
        """State of each object over some frames."""
        results = [self.step(*arguments, **options) for _ in range(num_frames)]
        return {
            object_id: [result.states[object_id].state for result in results]
            for object_id in self.tabletop.poses
        }


def test_all_is_tracked_while_the_tracker_is_right(tabletop):
    result = Run(tabletop).step()
    assert {status.state for status in result.states.values()} == {TRACKED}
    assert result.states['base'].support == result.objects['base'].support
    assert result.states['base'].last_good_ns == result.stamp_ns


def test_swapped_ids_are_never_used_not_even_for_one_frame(tabletop):
    run = Run(tabletop)
    run.step()
    for _ in range(20):
        result = run.step({'tall': 'base', 'base': 'tall'})
        assert set(result.objects) == {'top'}
        assert result.states['tall'].state is not TRACKED
        assert result.states['base'].state is not TRACKED
    assert result.states['base'].state is result.states['tall'].state is LOST
    assert 'last good 4.0 s ago' in result.rejected['base']


def test_two_that_are_alike_are_not_believed_for_a_while_after_a_swap(tabletop):
    """Nothing but the jump tells: the cloud fits both."""

    class Twins:
        def find(self, object_id):
            return tabletop.find('top' if object_id == 'twin' else object_id)

    perception = ScenePerception(PerceptionConfig(), Twins())
    here, there = tabletop.track('top'), tabletop.track('tall')
    places = {'top': here, 'twin': there}
    states = []
    for idx in range(24):
        if idx == 2:
            places = {'top': there, 'twin': here}
        stamp_ns = STAMP_NS + idx * SEC // 5
        tracks = [
            replace(track, object_id=key, stamp_ns=stamp_ns) for key, track in places.items()
        ]
        result = perception.step(tabletop.frame(tracks, stamp_ns=stamp_ns))
        states.append(result.states['twin' if idx >= 2 else 'top'].state)
        if 2 <= idx < 17:
            reason = result.rejected['twin']
            assert 'change places with top in 0.20 s: it may have swapped' in reason
    assert states[:2] == [TRACKED] * 2
    assert set(states[2:17]) == {UNCERTAIN}
    assert states[-1] is TRACKED


def test_a_rival_that_fits_better_proves_a_swap(tabletop):
    """A tolerance so wide that both are confirmed at each other's place."""
    run = Run(tabletop, support=SupportConfig(tolerance=0.08, min_support=0.05))
    run.step()
    for _ in range(20):
        result = run.step({'tall': 'base', 'base': 'tall'})
        assert set(result.objects) == {'top'}
    assert result.states['tall'].support > 0.25  # enough for a pose that nothing speaks against
    assert 'the cloud fits tall better there (' in result.rejected['base']
    assert 'base is not where its tracked pose says' in result.rejected['tall']
    for _ in range(20):
        result = run.step()
    assert result.rejected == {}


def test_a_jump_to_a_place_without_support_and_back(tabletop):
    run = Run(tabletop)
    run.step()
    away = {'tall': (-0.15, 0.12, 0.05)}
    assert run.states(4, away)['tall'] == [UNCERTAIN, UNCERTAIN, LOST, LOST]
    reason = run.step(away).rejected['tall']
    assert 'tracked pose has no support in the cloud (' in reason
    assert reason.endswith('last good 1.0 s ago')
    assert run.states(1, away)['base'] == [TRACKED]
    back = run.states(8)['tall']
    assert back[0] is UNCERTAIN
    assert back[-1] is TRACKED
    assert back == sorted(back, key=[UNCERTAIN, TRACKED].index)


def test_uncertain_objects_are_used_where_that_is_asked_for(tabletop):
    run = Run(tabletop, use_uncertain=True)
    run.step()
    away = {'tall': (-0.15, 0.12, 0.05)}
    assert 'tall' in run.step(away).objects
    run.states(4, away)
    assert 'tall' not in run.step(away).objects


def test_a_pose_inside_of_the_table_is_contradicted(tabletop):
    """Everything of it is hidden, by what cannot hide it."""
    run = Run(tabletop)
    result = run.step({'top': (0.0, 0.25, -0.18)})
    assert result.states['top'].state is LOST
    assert 'no support' in result.rejected['top']


def behind_a_wall(tabletop):
    """The cloud with a wall half a metre before the camera."""
    depth = tabletop.cloud.xyz[..., 2]
    near = np.where(np.isfinite(depth), 0.55, np.nan).astype(np.float32)
    return PointCloud(tabletop.cloud.xyz * (near / depth)[..., None])


def test_an_object_that_is_hidden_is_believed_where_it_was_seen(tabletop):
    run = Run(tabletop)
    run.step()
    wall = behind_a_wall(tabletop)
    result = run.step(cloud=wall)
    assert {status.state for status in result.states.values()} == {TRACKED}
    assert all(math.isnan(status.support) for status in result.states.values())
    for idx in range(1, 11):
        result = run.step({'tall': (0.01 * idx, 0, 0)}, cloud=wall)
    assert result.states['base'].state is TRACKED
    assert result.states['tall'].state is UNCERTAIN
    assert 'it moved by 0.10 m since it was last seen' in result.rejected['tall']
    assert run.states(1)['tall'] == [TRACKED]


def test_an_object_that_was_hidden_from_the_start_must_be_seen_once(tabletop):
    run = Run(tabletop)
    result = run.step(cloud=behind_a_wall(tabletop))
    assert {status.state for status in result.states.values()} == {UNCERTAIN}
    assert result.rejected['base'] == 'its place is hidden or out of view, never confirmed'
    assert run.step().rejected == {}


@pytest.mark.parametrize('models', [True, False])
def test_a_tracker_that_stops_and_comes_back(tabletop, models):
    run = Run(tabletop, models=models)
    run.step()
    found = run.states(6, silent=('tall',))
    assert found['tall'] == [TRACKED, TRACKED, UNCERTAIN, UNCERTAIN, LOST, LOST]
    assert found['base'] == [TRACKED] * 6
    result = run.step(silent=('tall',))
    assert 'the last tracked pose is 1.40 s old' in result.rejected['tall']
    assert run.states(5)['tall'] == [UNCERTAIN, UNCERTAIN, TRACKED, TRACKED, TRACKED]


def test_frames_of_tf_that_jump_are_doubted_as_poses_are(tabletop):
    perception = ScenePerception(PerceptionConfig(object_frames=('tall',)), tabletop)
    reasons = []
    for idx, offset in enumerate(((0, 0, 0), (0, 0, 0), (0.3, 0, 0), (0, 0, 0))):
        stamp_ns = STAMP_NS + idx * SEC // 30
        pose = Pose(np.array(offset, dtype=float)) @ tabletop.poses['tall']
        moving = StampedTransform('world', 'tall', stamp_ns, pose)
        transforms = (tabletop.camera_transform(), moving)
        frame = tabletop.frame([], stamp_ns=stamp_ns, transforms=transforms)
        reasons.append(perception.step(frame).rejected.get('tall', ''))
    assert reasons[:2] == ['', '']
    assert 'jumped by 0.30 m' in reasons[3]


def test_an_observed_object_whose_pose_slips_to_another_is_doubted(tabletop):
    run = Run(tabletop, models=False)
    run.states(3)
    # Over a silence, which hides the jump.
    run.stamp_ns += SEC
    track = replace(tabletop.track('tall', stamp_ns=run.stamp_ns), object_id='base')
    result = run.perception.step(tabletop.frame([track], stamp_ns=run.stamp_ns))
    assert result.states['base'].state is UNCERTAIN
    assert 'not what was seen of it before' in result.rejected['base']


def test_support_needs_a_camera(tabletop):
    view = View(PointCloud(tabletop.cloud.points), None, np.eye(4), None)
    assert math.isnan(support_at(np.zeros((50, 3)), Pose(), view, 0.02))


def test_beliefs_start_anew_when_the_clock_jumps_back(tabletop):
    run = Run(tabletop)
    run.step()
    away = {'tall': (-0.15, 0.12, 0.05)}
    run.states(5, away)
    run.stamp_ns = STAMP_NS - 100 * SEC
    assert run.states(1)['tall'] == [TRACKED]


def test_a_pose_where_nothing_can_be_is_refused_in_its_first_frame(tabletop):
    ghost = TrackedPose('ghost', STAMP_NS, 'world', Pose(np.array([0.0, 0.0, 5.0])))
    result = ScenePerception().step(tabletop.frame([ghost]))
    assert result.states['ghost'].state is LOST
    assert 'nothing of its own is seen within 0.20 m' in result.rejected['ghost']
