"""A small simulated bag: four boxes, of which the can is lost in the last cloud."""

import numpy as np
import torch

from spatial_relations_ros.core import Pose, TriangleMesh
from spatial_relations_ros.datasets.kinect_simulator import (
    KinectSimulator,
    Surface,
    look_at,
    table_mesh,
)
from spatial_relations_ros.datasets.object_files import save_mesh
from spatial_relations_ros.evaluation.bag_writer import BagWriter
from spatial_relations_ros.evaluation.replay import ReplayOptions
from spatial_relations_ros.imitation import ImitationOptions
from spatial_relations_ros.learning import ModelCard, make_encoder, save_metric
from spatial_relations_ros.perception.border import StampedTransform, TrackedPose
from spatial_relations_ros.perception.camera import PinholeCamera

CAMERA = PinholeCamera(160, 120, fx=110.0, fy=110.0, cx=79.5, cy=59.5)
WORLD_FROM_CAMERA = look_at((0.0, -1.0, 0.8), (0.0, 0.0, 0.0))
OBJECTS = {
    'tray': ((0.24, 0.18, 0.02), (-0.25, 0.0, 0.01)),
    'cup': ((0.06, 0.06, 0.1), (-0.25, 0.0, 0.07)),
    'carton': ((0.14, 0.1, 0.06), (0.2, 0.0, 0.03)),
    'can': ((0.06, 0.06, 0.08), (0.4, -0.05, 0.04)),
}
NUM_CLOUDS = 8
# Five clouds a second: the first one at which all has held still for a second.
SETTLED = 5
START_NS = 1_700_000_000_000_000_000
STEP_NS = 200_000_000
ASKED = ReplayOptions(
    reference_ids=('tray', 'cup'),
    test_ids=('carton', 'can'),
    every=3,
    imitation=ImitationOptions(max_steps=1, num_starts=1, propose=False),
)


def box_mesh(size):
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) / 2.0
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    triangles = [t for a, b, c, d in quads for t in ([a, b, c], [a, c, d])]
    return TriangleMesh(corners * np.asarray(size), np.array(triangles))


def record(folder):
    """Fills a folder with ``bag``, ``models`` and ``w.safetensors``."""
    poses = {name: Pose(np.array(place)) for name, (_, place) in OBJECTS.items()}
    meshes = {name: box_mesh(size) for name, (size, _) in OBJECTS.items()}
    for name, mesh in meshes.items():
        save_mesh(folder / 'models' / f'{name}.ply', mesh)
    surfaces = [Surface(table_mesh((1.6, 1.0)))]
    surfaces += [Surface(mesh.transformed(poses[name])) for name, mesh in meshes.items()]
    simulator = KinectSimulator(surfaces, WORLD_FROM_CAMERA, CAMERA)
    rng = np.random.default_rng(0)
    camera_from_world = WORLD_FROM_CAMERA.inverse()
    with BagWriter(folder / 'bag') as writer:
        mount = StampedTransform('world', 'camera', START_NS, WORLD_FROM_CAMERA, is_static=True)
        writer.write('/tf_static', START_NS, writer.transforms([mount]))
        for cloud_idx in range(NUM_CLOUDS):
            stamp = START_NS + cloud_idx * STEP_NS
            tracks = [
                TrackedPose(name, stamp, 'camera', camera_from_world @ pose)
                for name, pose in poses.items()
                if not (name == 'can' and cloud_idx == NUM_CLOUDS - 1)
            ]
            objects = writer.tracked_objects(stamp, 'camera', tracks)
            writer.write('/tracked_objects', stamp + 1, objects)
            image = simulator.measure(rng)
            cloud = writer.cloud(stamp, 'camera', simulator.xyz(image), image.rgb)
            writer.write('/points', stamp + 2, cloud)
    torch.manual_seed(0)
    encoder = make_encoder('compact')
    save_metric(encoder, ModelCard('compact', num_points=256), folder / 'w.safetensors')
