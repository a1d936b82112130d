import numpy as np
import pytest
import torch

from spatial_relations_ros.imitation.layout import MAX_GAP, Layout


def clouds(offset, base_half=0.1, relative_half=0.05):
    """Corners of two cubes, the second one beside the first along x."""
    corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, 8).T
    pair = [base_half * corners, relative_half * corners + [offset, 0.0, 0.0]]
    return torch.from_numpy(np.array(pair)[None]).float()


@pytest.mark.parametrize(('offset', 'spacing'), [(0.0, 0.0), (0.05, 1 / 3), (0.15, 1.0)])
def test_spacing_is_one_where_they_touch_side_by_side(offset, spacing):
    layout = Layout.of(clouds(offset))
    assert float(layout.spacing[0]) == pytest.approx(spacing, abs=1e-6)
    assert float(layout.spacing_within[0]) == pytest.approx(1 / 3, abs=1e-6)


def test_the_same_layout_at_another_size_does_not_differ():
    wanted = Layout.of(clouds(0.2))
    larger = Layout.of(1.5 * clouds(0.2))
    assert float(larger.difference(wanted)[0]) == pytest.approx(0.0, abs=1e-6)
    farther = Layout.of(clouds(0.3))
    assert float(farther.difference(wanted)[0]) == pytest.approx(0.5 / 0.6, abs=1e-5)


def test_wide_gaps_are_kept_only_as_far_as_neighbours_stand():
    wanted = Layout.of(clouds(0.6))
    at_most = Layout.of(clouds(0.15 + MAX_GAP))
    assert float(at_most.difference(wanted)[0]) == pytest.approx(0.0, abs=1e-5)
    assert float(Layout.of(clouds(0.15)).difference(wanted)[0]) > 0.4


def test_on_each_other_the_place_within_the_larger_one_counts():
    wanted = Layout.of(clouds(0.0))
    moved = Layout.of(clouds(0.025))
    assert float(moved.difference(wanted)[0]) == pytest.approx(1 / 6 / 0.6, abs=1e-5)


def test_no_more_is_asked_than_the_smaller_one_can_reach_within():
    wanted = Layout.of(clouds(0.08, relative_half=0.02))  # 2/3 of the way
    at_border = Layout.of(clouds(0.05))
    assert float(at_border.difference(wanted)[0]) == pytest.approx(0.0, abs=1e-5)


def test_what_stands_low_and_reaches_over_the_border_is_beside():
    beside, over = clouds(0.13), clouds(0.13)
    beside[0, 1, :, 2] -= 0.05  # both stand on the table
    over[0, 1, :, 2] += 0.2
    assert Layout.of(beside).is_beside
    assert not Layout.of(over).is_beside
    assert not Layout.of(clouds(0.0)).is_beside
