import cv2
import numpy as np
import pytest

from spatial_relations_ros.core import ConfigError, Pose
from spatial_relations_ros.visualization import (
    BASE_COLOUR,
    RELATIVE_COLOUR,
    frame_objects,
    render_scene,
)


def hue_of(image):
    """+1 where a pixel is rather orange, -1 where rather blue, 0 where grey."""
    warm = image[..., 0].astype(int) - image[..., 2].astype(int)
    return np.where(warm > 40, 1, np.where(warm < -40, -1, 0))


def hull_mask(camera, item):
    """Pixels inside the convex outline of an object's mesh, by cross products."""
    pixels, _ = camera.project(item.world_from_object.apply(item.mesh.vertices))
    mask = np.zeros((camera.height, camera.width), dtype=np.uint8)
    cv2.fillConvexPoly(mask, cv2.convexHull(np.round(pixels).astype(np.int32)), 1)
    return mask.astype(bool)


def test_a_box_is_where_the_pinhole_puts_it(make_box):
    box = make_box('box', (0.2, 0.1, 0.15), (0.4, 0.2, 0.075))
    camera = frame_objects([[box]], width=320, height=240)
    blue = hue_of(render_scene([box], camera=camera)) == -1
    expected = hull_mask(camera, box)
    differing = blue ^ expected
    outline = np.count_nonzero(expected) ** 0.5 * 4
    assert np.count_nonzero(expected) > 5000
    assert np.count_nonzero(differing) < 1.5 * outline


def test_colours_follow_the_roles(make_box):
    base = make_box('base', (0.1, 0.1, 0.1), (0.0, 0.0, 0.05))
    relative = make_box('relative', (0.1, 0.1, 0.1), (0.3, 0.0, 0.05))
    camera = frame_objects([[base, relative]], width=320, height=240)
    hue = hue_of(render_scene([base, relative], camera=camera))
    for item, sign in ((base, -1), (relative, 1)):
        (column, row), _ = camera.project(item.world_from_object.translation)
        assert hue[round(row), round(column)] == sign
    assert BASE_COLOUR[2] > BASE_COLOUR[0]
    assert RELATIVE_COLOUR[0] > RELATIVE_COLOUR[2]


def test_the_nearer_object_hides_the_other(make_box):
    far = make_box('far', (0.1, 0.1, 0.1), (0.0, 0.0, 0.05))
    camera = frame_objects([[far]], width=200, height=150)
    towards = camera.position - far.world_from_object.translation
    near = far.moved_to(Pose(far.world_from_object.translation + 0.3 * towards))
    alone = np.count_nonzero(hue_of(render_scene([far], camera=camera, table_height=0.0)) == -1)
    hue = hue_of(render_scene([far, near], camera=camera, table_height=0.0))
    assert alone > 1000
    assert np.count_nonzero(hue == -1) < 0.02 * alone


def test_the_table_hides_what_sinks_into_it(make_box):
    box = make_box('box', (0.1, 0.1, 0.1), (0.0, 0.0, 0.0))
    camera = frame_objects([[box]], width=200, height=150)
    whole = np.count_nonzero(hue_of(render_scene([box], camera=camera)) == -1)
    sunk = np.count_nonzero(hue_of(render_scene([box], camera=camera, table_height=0.0)) == -1)
    assert 0.2 * whole < sunk < 0.8 * whole


def test_a_shadow_falls_on_the_table_beside_the_object(make_box):
    box = make_box('box', (0.06, 0.06, 0.2), (0.0, 0.0, 0.1))
    wide = make_box('wide', (0.5, 0.5, 0.001), (0.0, 0.0, 0.0005))
    camera = frame_objects([[wide, box]], width=320, height=240)
    with_box = render_scene([box], camera=camera, table_height=0.0).astype(int)
    flat = make_box('flat', (0.06, 0.06, 0.001), (0.0, 0.0, 0.0005))
    without = render_scene([flat], camera=camera, table_height=0.0).astype(int)
    table = (hue_of(with_box) == 0) & (hue_of(without) == 0)
    darker = table & ((without - with_box).sum(axis=-1) > 60)
    assert np.count_nonzero(darker) > 300


def test_a_ghost_is_translucent_and_of_its_objects_colour(make_box):
    base = make_box('base', (0.1, 0.1, 0.1), (0.0, 0.0, 0.05))
    relative = make_box('relative', (0.1, 0.1, 0.1), (0.0, 0.0, 0.15))
    before = relative.moved_to(Pose(np.array([0.3, 0.0, 0.05])))
    camera = frame_objects([[base, relative, before]], width=320, height=240)
    plain = render_scene([base, relative], camera=camera).astype(int)
    ghostly = render_scene([base, relative], ghosts=[before], camera=camera).astype(int)
    solid = render_scene([base, relative, before], camera=camera).astype(int)
    (column, row), _ = camera.project(before.world_from_object.translation)
    at = (round(row), round(column))
    warmth = [image[at][0] - image[at][2] for image in (plain, ghostly)]
    assert warmth[1] > warmth[0] + 15
    changed = np.abs(ghostly[at] - plain[at]).sum()
    assert 0 < changed < 0.6 * np.abs(solid[at] - plain[at]).sum()


def test_clouds_are_drawn_where_their_meshes_would_be(make_box):
    mesh = make_box('box', (0.2, 0.1, 0.15), (0.0, 0.0, 0.075))
    cloud = make_box('box', (0.2, 0.1, 0.15), (0.0, 0.0, 0.075), as_cloud=True)
    camera = frame_objects([[mesh]], width=320, height=240)
    solid, beads = (
        hue_of(render_scene([item], camera=camera, table_height=0.0)) == -1
        for item in (mesh, cloud)
    )
    assert np.count_nonzero(solid & beads) > 0.6 * np.count_nonzero(solid)
    assert np.count_nonzero(beads & ~solid) < 0.12 * np.count_nonzero(solid)


def test_the_same_scene_gives_the_same_picture(make_box):
    items = [
        make_box('base', (0.1, 0.2, 0.1), (0.0, 0.0, 0.05)),
        make_box('relative', (0.1, 0.1, 0.1), (0.02, 0.0, 0.15), as_cloud=True),
    ]
    first = render_scene(items, width=200, height=150)
    assert np.array_equal(first, render_scene(items, width=200, height=150))


def test_edges_are_antialiased(make_box):
    box = make_box('box', (0.2, 0.2, 0.2), (0.0, 0.0, 0.1))
    image = render_scene([box], width=320, height=240).astype(int)
    red = image[40:200, :, 0]
    steps = np.abs(np.diff(red, axis=1)).max(axis=1)
    between = [
        row
        for row in red
        if np.any((row[1:-1] > row[:-2] + 12) & (row[2:] > row[1:-1] + 12))
        or np.any((row[1:-1] < row[:-2] - 12) & (row[2:] < row[1:-1] - 12))
    ]
    assert steps.max() > 30
    assert len(between) > 20


def test_no_objects_give_a_bare_light_picture():
    image = render_scene([], width=64, height=48)
    assert image.shape == (48, 64, 3)
    assert image.min() > 200
    assert len(np.unique(image.reshape(-1, 3), axis=0)) == 1


def test_only_ghosts(make_box):
    ghost = make_box('box', (0.1, 0.1, 0.1), (0.0, 0.0, 0.05))
    image = render_scene([], ghosts=[ghost], width=160, height=120)
    assert len(np.unique(image.reshape(-1, 3), axis=0)) > 10


def test_objects_out_of_the_picture_leave_the_table(make_box):
    box = make_box('box', (0.1, 0.1, 0.1), (0.0, 0.0, 0.05))
    camera = frame_objects([[box]], width=160, height=120)
    away = box.moved_to(Pose(np.array([3.0, 3.0, 0.05])))
    assert not (hue_of(render_scene([away], camera=camera)) == -1).any()


def test_needs_pixels():
    with pytest.raises(ConfigError):
        render_scene([], width=0)
