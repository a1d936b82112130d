"""Imitations as moving pictures."""

from __future__ import annotations

import dataclasses
from itertools import pairwise

import cv2
import numpy as np
import pytest
from PIL import Image as PillowImage

from spatial_relations_ros.core import ConfigError, Pose, Scene
from spatial_relations_ros.visualization import (
    ShownAnswer,
    ShownImitation,
    ShownStep,
    animate_imitation,
    straight_way,
    write_animation,
)

NUM_FRAMES = 4


@pytest.fixture
def shown(make_box) -> ShownImitation:
    base = make_box('tray', (0.2, 0.2, 0.02), (0.0, 0.0, 0.01))
    relative = make_box('cup', (0.06, 0.06, 0.08), (0.3, 0.0, 0.04))
    target = Pose(np.array([0.0, 0.0, 0.06]))
    start, end = ((base.world_from_object, pose) for pose in (relative.world_from_object, target))
    way = tuple(
        ShownStep(poses, distance)
        for poses, distance in zip(straight_way(start, end, 3), (1.0, 1.4, 0.2), strict=True)
    )
    return ShownImitation(
        'cup to tray',
        Scene(base, relative),
        Scene(base, relative),
        (ShownAnswer(end, 0.2, True, way=way),),
        history=(1.0, 0.6, 0.2),
    )


@pytest.fixture
def frames(shown):
    return animate_imitation(shown, num_frames=NUM_FRAMES, width=240, height=161)


def test_frames_show_the_object_on_its_way_and_the_curve(frames, shown):
    assert [frame.shape for frame in frames] == [(161, 480, 3)] * NUM_FRAMES
    for before, after in pairwise(frames):
        moved = (before != after).any(axis=2)
        assert moved[:, :240].any(), 'the object moves'
        assert moved[:, 240:].any(), 'the cursor moves'
    without = dataclasses.replace(shown, answers=(ShownAnswer(shown.answers[0].poses, 0.2, True),))
    still = animate_imitation(without, num_frames=2, width=240, height=161)
    assert (still[0][:, 240:] == still[1][:, 240:]).all(), 'nobody measured the way: no cursor'
    told = []
    animate_imitation(shown, num_frames=2, width=240, height=160, on_frame=told.append)
    assert told == [1, 2]


@pytest.mark.parametrize('suffix', ['.gif', '.webp'])
def test_pictures_in_a_file_are_those_that_were_drawn(frames, tmp_path, suffix):
    path = write_animation(tmp_path / f'way{suffix}', frames, frames_per_sec=10.0, hold_sec=1.0)
    with PillowImage.open(path) as written:
        assert written.n_frames == NUM_FRAMES
        assert written.info['loop'] == 0
        durations = []
        for idx, frame in enumerate(frames):
            written.seek(idx)
            shown = np.asarray(written.convert('RGB')).astype(int)
            durations.append(written.info['duration'])
            assert np.abs(shown - frame).mean() < 6.0
    assert durations == [100, 100, 100, 1100]


def test_a_video_holds_the_last_picture(frames, tmp_path):
    path = write_animation(tmp_path / 'way.mp4', frames, frames_per_sec=10.0, hold_sec=0.5)
    video = cv2.VideoCapture(str(path))
    assert video.get(cv2.CAP_PROP_FRAME_COUNT) == NUM_FRAMES + 5
    read, first = video.read()
    assert read
    assert first.shape == (162, 480, 3)
    assert np.abs(first[:161, :, ::-1].astype(int) - frames[0]).mean() < 8.0


def test_what_cannot_be_animated(shown, frames, tmp_path):
    with pytest.raises(ConfigError, match=r'\.gif, \.webp, \.mp4'):
        write_animation(tmp_path / 'way.avi', frames)
    with pytest.raises(ConfigError, match='one size'):
        write_animation(tmp_path / 'way.gif', [frames[0], frames[1][:50]])
    with pytest.raises(ConfigError, match='one size'):
        write_animation(tmp_path / 'way.gif', [])
    with pytest.raises(ConfigError, match='at least two'):
        animate_imitation(shown, num_frames=1)
    assert list(tmp_path.iterdir()) == []
