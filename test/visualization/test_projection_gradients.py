import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError
from spatial_relations_ros.visualization import draw_projection_gradients
from spatial_relations_ros.visualization.projections import projection_layout

LAYOUT = projection_layout(50)


def draw(by_images=None, descent=None, images=None):
    zeros = np.zeros((3, 2, 50, 50), dtype=np.float32)
    return draw_projection_gradients(
        zeros if images is None else images,
        zeros if by_images is None else by_images,
        np.zeros((3, 2, 50, 50, 2)) if descent is None else descent,
    )


def cell_of(picture, plane_idx, channel_idx):
    row, column = LAYOUT.corner(plane_idx, channel_idx)
    return picture[row : row + LAYOUT.cell, column : column + LAYOUT.cell].astype(int)


def test_what_raises_the_distance_is_red_and_what_lowers_it_blue():
    by_images = np.zeros((3, 2, 50, 50), dtype=np.float32)
    by_images[1, 0, :25], by_images[1, 0, 25:] = 1.0, -1.0
    cell = cell_of(draw(by_images), 1, 0)
    middle = LAYOUT.cell // 2
    upper, lower = cell[: middle - 1].mean(axis=(0, 1)), cell[middle + 1 :].mean(axis=(0, 1))
    assert lower[0] > lower[2], 'rows grow upwards: the first half lies below'
    assert upper[2] > upper[0]
    assert np.ptp(cell_of(draw(by_images), 2, 1)) <= 2


@pytest.mark.parametrize(
    ('direction', 'edge'),
    [((1, 0), 'right'), ((-1, 0), 'left'), ((0, 1), 'top'), ((0, -1), 'bottom')],
)
def test_arrows_point_where_the_points_are_to_go(direction, edge):
    descent = np.zeros((3, 2, 50, 50, 2), dtype=np.float32)
    descent[0, 1, 25:30, 25:30] = direction
    changed = (cell_of(draw(descent=descent), 0, 1) != cell_of(draw(), 0, 1)).any(axis=-1)
    rows, columns = np.nonzero(changed)
    tail = (LAYOUT.cell - 27.5 * LAYOUT.cell / 50, 27.5 * LAYOUT.cell / 50)
    reach = {
        'right': columns.max() - tail[1],
        'left': tail[1] - columns.min(),
        'top': tail[0] - rows.min(),
        'bottom': rows.max() - tail[0],
    }
    assert max(reach, key=reach.get) == edge
    assert reach[edge] > 25


def test_the_object_is_shaded():
    images = np.zeros((3, 2, 50, 50), dtype=np.float32)
    images[0, 0, 10:20, 10:20] = 150.0
    cell = cell_of(draw(images=images), 0, 0)
    assert (cell[..., 0] < cell.max() - 15).mean() == pytest.approx(0.04, abs=0.005)


def test_shapes_that_do_not_fit_are_named():
    with pytest.raises(ConfigError, match='do not fit'):
        draw(descent=np.zeros((3, 2, 40, 40, 2)))
    with pytest.raises(ConfigError, match=r'\(3, 2, S, S\)'):
        draw(by_images=np.zeros((2, 3, 50, 50)))
