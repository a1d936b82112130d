import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.visualization import draw_projections
from spatial_relations_ros.visualization.projections import projection_layout


def cell_of(picture, layout, plane_idx, channel_idx):
    row, column = layout.corner(plane_idx, channel_idx)
    return picture[row : row + layout.cell, column : column + layout.cell]


def test_each_image_lies_in_its_own_cell():
    layout = projection_layout(50)
    for plane_idx in range(3):
        for channel_idx in range(2):
            images = np.zeros((3, 2, 50, 50), dtype=np.float32)
            images[plane_idx, channel_idx] = 150.0
            picture = draw_projections(images)
            for other_plane in range(3):
                for other_channel in range(2):
                    cell = cell_of(picture, layout, other_plane, other_channel)
                    filled = (other_plane, other_channel) == (plane_idx, channel_idx)
                    assert (cell == 255).all() == (not filled)


def test_rows_grow_upwards_and_columns_to_the_right():
    images = np.zeros((3, 2, 50, 50), dtype=np.float32)
    images[1, 0, 40, 10] = 100.0
    layout = projection_layout(50)
    cell = cell_of(draw_projections(images), layout, 1, 0)
    rows, columns = np.nonzero((cell != 255).any(axis=-1))
    factor = layout.cell // 50
    assert rows.min() == (50 - 1 - 40) * factor
    assert rows.max() == (50 - 40) * factor - 1
    assert columns.min() == 10 * factor
    assert len(rows) == factor**2


def test_near_is_brighter_than_far():
    images = np.zeros((3, 2, 20, 20), dtype=np.float32)
    images[0, 0] = np.linspace(100.0, 200.0, 20)[None, :]
    layout = projection_layout(20)
    cell = cell_of(draw_projections(images), layout, 0, 0).astype(float)
    luminance = cell[0] @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(luminance) <= 0.5).all()
    assert luminance[0] > luminance[-1] + 100


def test_names_change_the_picture_outside_the_cells_only():
    images = np.full((3, 2, 20, 20), 120.0, dtype=np.float32)
    plain, named = draw_projections(images), draw_projections(images, object_ids=('cup', 'box'))
    layout = projection_layout(20)
    differing = (plain != named).any(axis=-1)
    assert differing.any()
    assert not differing[:, layout.left :].any()


def test_refuses_another_shape():
    with pytest.raises(ConfigError, match=r'\(3, 2, S, S\)'):
        draw_projections(np.zeros((2, 3, 10, 10)))
