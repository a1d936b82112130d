import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError, Pose, Scene
from spatial_relations_ros.visualization import (
    before_after,
    contact_sheet,
    read_image,
    write_imitation_pictures,
)
from spatial_relations_ros.visualization.sheets import CAPTION_ROWS, GAP, moved_objects


def plain(value, height=40, width=60):
    return np.full((height, width, 3), value, dtype=np.uint8)


def test_pictures_fill_the_grid_row_by_row():
    sheet = contact_sheet([plain(10), plain(20), plain(30)], columns=2)
    assert sheet.shape == (2 * (40 + GAP) + GAP, 2 * (60 + GAP) + GAP, 3)
    for idx, value in enumerate((10, 20, 30)):
        row, column = GAP + idx // 2 * (40 + GAP), GAP + idx % 2 * (60 + GAP)
        assert (sheet[row : row + 40, column : column + 60] == value).all()
    assert (sheet[GAP + 40 + GAP :, GAP + 60 + GAP :] == 255).all()


def test_captions_stand_above_their_pictures():
    sheet = contact_sheet([plain(10), plain(20)], ['first', 'a caption that is far too long'])
    strip = sheet[GAP : GAP + CAPTION_ROWS]
    assert (strip[:, GAP : GAP + 60] < 128).any()
    assert (strip[:, : GAP - 2] == 255).all()
    assert (sheet[GAP + CAPTION_ROWS :][:40, GAP : GAP + 60] == 10).all()


def test_smaller_pictures_keep_their_aspect():
    sheet = contact_sheet([plain(10, 100, 100), plain(20, 10, 40)], columns=2)
    second = sheet[GAP : GAP + 100, GAP + 100 + GAP : GAP + 100 + GAP + 100]
    rows, columns = (second == 20).all(axis=-1).nonzero()
    assert (np.ptp(rows) + 1, np.ptp(columns) + 1) == (25, 100)


def test_refuses_nothing_and_wrong_captions():
    with pytest.raises(ConfigError):
        contact_sheet([])
    with pytest.raises(ConfigError, match='1 pictures have 2'):
        contact_sheet([plain(1)], ['a', 'b'])


@pytest.fixture
def scenes(make_box):
    reference = Scene(
        make_box('tray', (0.3, 0.2, 0.02), (0.0, 0.0, 0.01)),
        make_box('cup', (0.06, 0.06, 0.1), (0.05, 0.0, 0.07)),
    )
    before = Scene(
        make_box('carton', (0.2, 0.1, 0.1), (0.0, 0.0, 0.05)),
        make_box('can', (0.06, 0.06, 0.08), (0.3, 0.0, 0.04)),
    )
    after = before.with_poses(before.base.world_from_object, Pose(np.array([0.02, 0.0, 0.14])))
    return reference, before, after


def test_only_what_moved_leaves_a_ghost(scenes):
    _, before, after = scenes
    assert [item.object_id for item in moved_objects(before, after)] == ['can']
    assert moved_objects(before, before) == ()


def test_before_and_after_differ_only_where_something_moved(scenes):
    reference, before, after = scenes
    sheet = before_after(reference, before, after, width=200, height=150)
    top = GAP + CAPTION_ROWS
    left, right = (
        sheet[top : top + 150, GAP + idx * (200 + GAP) : GAP + idx * (200 + GAP) + 200].astype(int)
        for idx in (1, 2)
    )
    differing = np.abs(left - right).sum(axis=-1) > 30
    assert 0.01 < differing.mean() < 0.6
    same = before_after(reference, before, before, width=200, height=150)
    pair = [same[top : top + 150, GAP + idx * 214 : GAP + idx * 214 + 200] for idx in (1, 2)]
    assert np.array_equal(*pair)


def test_an_imitation_leaves_a_folder_of_pictures(scenes, tmp_path):
    reference, before, after = scenes
    paths = write_imitation_pictures(
        tmp_path / 'out',
        reference=reference,
        before=before,
        after=after,
        projections=lambda scene: np.full((3, 2, 20, 20), 100.0 + len(scene.base.object_id)),
        distance_history=[1.0, 0.4, 0.1],
    )
    assert {path.name for path in paths} == {item.name for item in (tmp_path / 'out').iterdir()}
    assert {path.stem for path in paths} == {
        'overview', 'reference', 'test_before', 'test_after', 'distance',
        'reference_projections', 'test_before_projections', 'test_after_projections',
    }  # fmt: skip
    assert all(read_image(path).std() > 1.0 for path in paths)
