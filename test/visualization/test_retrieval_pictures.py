import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError, Relation
from spatial_relations_ros.visualization import (
    ShownScene,
    draw_confusion,
    draw_embedding_map,
    draw_neighbour_sheet,
)
from spatial_relations_ros.visualization.palette import (
    INK,
    RELATION_COLOURS,
    RIGHT,
    WRONG,
    as_bytes,
)
from spatial_relations_ros.visualization.sheets import CAPTION_ROWS, GAP


def plain(value=128, height=30, width=40):
    return np.full((height, width, 3), value, dtype=np.uint8)


def near(picture, colour, tolerance=12):
    return (np.abs(picture.astype(int) - as_bytes(colour)).max(axis=-1) <= tolerance).sum()


def test_a_map_shows_dots_in_the_colours_of_their_relations():
    places = np.random.default_rng(0).normal(size=(60, 2))
    labels = np.where(np.arange(60) < 30, Relation.ON_TOP, Relation.INSIDE)
    picture = draw_embedding_map(places, labels)
    assert picture.shape == (1200, 1920, 3)
    for relation in Relation:
        is_there = relation in (Relation.ON_TOP, Relation.INSIDE)
        assert (near(picture, RELATION_COLOURS[relation]) > 500) == is_there


def test_thumbnails_lie_at_the_sides_of_the_map():
    places = np.array([[-1.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
    thumbnails = {0: plain(10), 1: plain(200)}
    picture = draw_embedding_map(places, np.array([0, 1, 2]), thumbnails=thumbnails)
    left, right = picture[:, :350], picture[:, -350:]
    assert (left == 10).all(axis=-1).sum() > 5000
    assert (right == 200).all(axis=-1).sum() > 5000
    assert (left == 200).all(axis=-1).sum() < 500


@pytest.mark.parametrize('places', [np.zeros((0, 2)), np.zeros((3, 3)), np.zeros((4, 2))])
def test_a_map_of_something_else_is_refused(places):
    with pytest.raises(ConfigError, match='a map needs'):
        draw_embedding_map(places, np.zeros(3 if len(places) else 0, int))


def test_a_confusion_is_dark_where_scenes_are():
    confusion = np.zeros((7, 7), dtype=int)
    confusion[np.arange(7), np.arange(7)] = 50
    diagonal = draw_confusion(confusion)
    assert diagonal.shape == (960, 1140, 3)
    assert draw_confusion(np.zeros((7, 7), int)).mean() > diagonal.mean() + 5.0
    with pytest.raises(ConfigError, match='7 relations'):
        draw_confusion(np.zeros((6, 7), int))


def test_neighbours_are_framed_by_whether_they_are_right():
    row = [
        ShownScene(plain(), Relation.ON_TOP),
        ShownScene(plain(), Relation.ON_TOP, 0.1),
        ShownScene(plain(), Relation.INSIDE, 0.2),
    ]
    sheet = draw_neighbour_sheet([row])
    top = GAP + CAPTION_ROWS
    for idx, colour in enumerate((INK, RIGHT, WRONG)):
        left = GAP + idx * (50 + GAP)
        assert (sheet[top + 1, left + 1] == as_bytes(colour)).all()
        assert (sheet[top + 8, left + 8] == 128).all()
    for rows in ([], [[]], [row, row[:2]]):
        with pytest.raises(ConfigError, match='one length'):
            draw_neighbour_sheet(rows)
