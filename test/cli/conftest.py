import dataclasses
import json

import numpy as np
import pytest
import torch
from typer.testing import CliRunner

from spatial_relations_ros.core import Pose, Relation, TriangleMesh
from spatial_relations_ros.datasets.freiburg import (
    RelationDataset,
    RelationScene,
    Split,
    write_dataset,
)
from spatial_relations_ros.datasets.object_files import save_mesh
from spatial_relations_ros.learning import Calibration, ModelCard, make_encoder, save_metric

SIZES = {
    'tray': (0.24, 0.18, 0.02),
    'cup': (0.06, 0.06, 0.08),
    'carton': (0.14, 0.1, 0.06),
    'can': (0.05, 0.05, 0.07),
}


def box_mesh(size):
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2.0
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])]
    return TriangleMesh(corners * np.asarray(size), np.array(triangles))


@pytest.fixture(scope='session')
def weights(tmp_path_factory):
    """Weights of a real network that has learned nothing: enough to run every command."""
    torch.manual_seed(0)
    path = tmp_path_factory.mktemp('weights') / 'untrained.safetensors'
    save_metric(make_encoder('compact'), ModelCard('compact', num_points=256), path)
    return path


@pytest.fixture(scope='session')
def calibrated_weights(tmp_path_factory):
    """The same network with a calibration, under which every scene is novel."""
    torch.manual_seed(0)
    path = tmp_path_factory.mktemp('calibrated') / 'calibrated.safetensors'
    calibration = Calibration(
        np.array([0.0, 2.0]), np.array([0.9, 0.1]), np.full((1, 64), 9.0, dtype=np.float32), 2.0
    )
    save_metric(
        make_encoder('compact'), ModelCard('compact', num_points=256), path,
        calibration=calibration,
    )  # fmt: skip
    return path


@pytest.fixture(scope='session')
def data(tmp_path_factory):
    """A dataset in the paper's format: a cup on a tray, a can beside a carton, five times."""
    folder = tmp_path_factory.mktemp('data')
    scenes = []
    for number in range(5):
        shift = 0.01 * number
        on_top = Pose(np.array([shift, 0.0, 0.05]))
        beside = Pose(np.array([0.2, shift, 0.005]))
        scenes += [
            RelationScene(f'tray_cup_{number}', 'tray', 'cup', Pose(), on_top, Relation.ON_TOP),
            RelationScene(
                f'carton_can_{number}', 'carton', 'can', Pose(), beside, Relation.NEXT_TO
            ),
        ]
    names = tuple(scene.name for scene in scenes)
    meshes = {name: box_mesh(size) for name, size in SIZES.items()}
    rng = np.random.default_rng(0)
    dataset = RelationDataset(
        {name: mesh.sample_surface(600, rng) for name, mesh in meshes.items()},
        tuple(scenes),
        splits=(Split('split1', names[:8], names[8:]),),
    )
    write_dataset(folder, dataclasses.replace(dataset, meshes=meshes))
    return folder


@dataclasses.dataclass(frozen=True)
class SceneFiles:
    base: str
    relative: str
    poses: str

    def options(self, role=''):
        prefix = f'--{role}-' if role else '--'
        return [
            f'{prefix}base', self.base, f'{prefix}relative', self.relative,
            f'{prefix}poses', self.poses,
        ]  # fmt: skip


@pytest.fixture(scope='session')
def scene_files(tmp_path_factory):
    """Model and pose files of a demonstration (cup on tray) and a test (can beside carton)."""
    folder = tmp_path_factory.mktemp('models')
    for name, size in SIZES.items():
        save_mesh(folder / f'{name}.ply', box_mesh(size))

    def files(base, relative, base_z, relative_t):
        poses = folder / f'{base}.json'
        poses.write_text(
            json.dumps(
                {
                    'base': {'t': [0, 0, base_z], 'q_wxyz': [1, 0, 0, 0]},
                    'relative': {'t': relative_t, 'q_wxyz': [1, 0, 0, 0]},
                }
            )
        )
        return SceneFiles(str(folder / f'{base}.ply'), str(folder / f'{relative}.ply'), str(poses))

    return {
        'reference': files('tray', 'cup', 0.01, [0.02, 0.0, 0.06]),
        'test': files('carton', 'can', 0.03, [0.2, 0.05, 0.035]),
    }


@pytest.fixture
def relations(monkeypatch, tmp_path):
    """Runs the command in-process; returns its result."""
    from spatial_relations_ros.cli.main import app

    monkeypatch.setenv('XDG_DATA_HOME', str(tmp_path / 'share'))
    monkeypatch.setenv('COLUMNS', '200')
    runner = CliRunner()

    def run(*arguments):
        return runner.invoke(app, [str(argument) for argument in arguments])

    return run
