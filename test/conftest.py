"""Shared fixtures: simple solids with known geometry, and the data folder where there is one."""

from pathlib import Path

import numpy as np
import pytest
import torch
from chromium import reason_to_skip, running_browser
from manifold3d import Manifold

from spatial_relations_ros.core import Pose, SceneObject, TriangleMesh

# Small networks: more threads only wait for each other on a busy machine.
torch.set_num_threads(1)

REPOSITORY = Path(__file__).resolve().parents[1]


@pytest.fixture(autouse=True)
def _seed_torch():
    """Random tensors of a test are the same in each run."""
    torch.manual_seed(0)


@pytest.fixture(scope='session')
def shared_data():
    """The folder of real data beside the repository; tests skip where it is absent."""
    folder = REPOSITORY.parent / 'shared' / 'data'
    if not folder.is_dir():
        pytest.skip(f'{folder} is absent')
    return folder


class Solids:
    """Makes scene objects of simple solids, origin at the middle, z up, metres."""

    @staticmethod
    def of(name, manifold, position):
        mesh = manifold.to_mesh()
        surface = TriangleMesh(mesh.vert_properties[:, :3], mesh.tri_verts)
        points = surface.sample_surface(4096, np.random.default_rng(0))
        return SceneObject(name, points, Pose(np.array(position, float)), mesh=surface)

    @staticmethod
    def box(name, size, position):
        return Solids.of(name, Manifold.cube(size, True), position)

    @staticmethod
    def cup(name, radius, height, position, wall=0.004):
        outer = Manifold.cylinder(height, radius, radius, 48, True)
        inner = Manifold.cylinder(height, radius - wall, radius - wall, 48, True)
        return Solids.of(name, outer - inner.translate((0, 0, wall)), position)


@pytest.fixture(scope='session')
def solids():
    return Solids


@pytest.fixture(scope='session')
def browser(tmp_path_factory):
    """A headless Chromium, once for all tests; they skip where there is none."""
    reason = reason_to_skip()
    if reason is not None:
        pytest.skip(reason)
    with running_browser(tmp_path_factory.mktemp('browser')) as browser:
        yield browser
