"""Real Kinect captures of table tops with labelled objects; skipped where the data is absent."""

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
import open3d as o3d
import pytest
from scipy.spatial import cKDTree

from spatial_relations_ros.core import Pose
from spatial_relations_ros.perception.border import Frame, StampedTransform, TrackedPose
from spatial_relations_ros.perception.camera import estimate_camera
from spatial_relations_ros.perception.object_models import KnownModel
from spatial_relations_ros.perception.point_cloud2 import PointCloud, read_xyz
from spatial_relations_ros.perception.scene_perception import ScenePerception

pytestmark = pytest.mark.shared_data

NEXT_TO, ON_TOP, ON_EDGE, INCLINED = 'learn0', 'learn17', 'learn25', 'learn26'
CAPTURES = (NEXT_TO, ON_TOP, ON_EDGE, INCLINED)


@dataclass
class Capture:
    """A labelled cloud, and the world that its table defines: z = 0 on it, z up."""

    cloud: PointCloud
    labels: np.ndarray
    world_from_camera: Pose

    def labelled(self, first, last):
        """World points of a range of labels."""
        chosen = (self.labels >= first) & (self.labels <= last) & self.cloud.finite
        return self.world_from_camera.apply(self.cloud.xyz[chosen])

    def objects(self):
        return {'first': self.labelled(20, 29), 'second': self.labelled(30, 39)}

    def frame(self, places):
        """A frame with an object tracked at each place in the world."""
        transform = StampedTransform('world', 'camera', 0, self.world_from_camera, is_static=True)
        tracks = [TrackedPose(name, 0, 'world', Pose(place)) for name, place in places.items()]
        return Frame(0, 'camera', self.cloud, tuple(tracks), (transform,))


@pytest.fixture(scope='module')
def captures(shared_data):
    return {name: load(shared_data / 'kinect' / f'mosd_{name}.pcd') for name in CAPTURES}


def load(path):
    points = o3d.t.io.read_point_cloud(
        str(path), remove_nan_points=False, remove_infinite_points=False
    ).point
    labels = points['label'].numpy().reshape(480, 640)
    cloud = PointCloud(points.positions.numpy().reshape(480, 640, 3))
    table = cloud.xyz[(labels >= 1) & (labels <= 9) & cloud.finite].astype(float)
    centre = table.mean(axis=0)
    up = np.linalg.eigh(np.cov(table.T))[1][:, 0]
    up *= -np.sign(up @ centre)  # towards the camera
    right = np.cross([0.0, 0.0, 1.0], up)
    right /= np.linalg.norm(right)
    rotation = np.stack([right, np.cross(up, right), up])
    return Capture(cloud, labels, Pose.from_rotation(rotation, -rotation @ centre))


def as_message(capture, byte_order):
    """The cloud as a message with the capture's own field order, and a padded row."""
    dtype = np.dtype(
        [('label', byte_order + 'u4')]
        + [(axis, byte_order + 'f4') for axis in 'xyz']
        + [('rgba', byte_order + 'u4')]
    )
    rows = np.zeros((480, 640), dtype)
    rows['label'] = capture.labels
    for axis_idx, axis in enumerate('xyz'):
        rows[axis] = capture.cloud.xyz[..., axis_idx]
    data = np.zeros((480, 640 * 20 + 12), dtype=np.uint8)
    data[:, : 640 * 20] = rows.view(np.uint8).reshape(480, -1)
    fields = [
        SimpleNamespace(name=name, offset=4 * idx, datatype=7 if name in 'xyz' else 6, count=1)
        for idx, name in enumerate(dtype.names)
    ]
    return SimpleNamespace(
        height=480,
        width=640,
        fields=fields,
        is_bigendian=byte_order == '>',
        point_step=20,
        row_step=640 * 20 + 12,
        data=data.tobytes(),
        is_dense=True,
    )


@pytest.mark.parametrize('byte_order', ['<', '>'])
def test_the_reader_keeps_every_pixel(captures, byte_order):
    capture = captures[NEXT_TO]
    read = read_xyz(as_message(capture, byte_order))
    np.testing.assert_array_equal(read.xyz, capture.cloud.xyz)
    assert read.num_finite == 182_292
    assert read.xyz.base is not None or byte_order == '>'


@pytest.mark.parametrize('name', CAPTURES)
def test_the_camera_is_the_one_of_the_driver(captures, name):
    camera = estimate_camera(captures[name].cloud)
    np.testing.assert_allclose(
        [camera.fx, camera.fy, camera.cx, camera.cy], [525.0, 525.0, 319.5, 239.5], rtol=1e-5
    )


@pytest.mark.parametrize('name', CAPTURES)
def test_the_table_is_found_under_the_objects(captures, name):
    capture = captures[name]
    places = {key: points.mean(axis=0) for key, points in capture.objects().items()}
    result = ScenePerception().step(capture.frame(places))
    assert result.table_height == pytest.approx(0.0, abs=0.004)


@pytest.mark.parametrize('name', CAPTURES)
def test_objects_are_cut_out_of_the_table_and_from_each_other(captures, name):
    capture = captures[name]
    truth = capture.objects()
    places = {key: points.mean(axis=0) for key, points in truth.items()}
    result = ScenePerception().step(capture.frame(places))
    assert result.rejected == {}
    for key, item in result.objects.items():
        # The same points up to the rounding of two transforms.
        to_found = cKDTree(item.world_points).query(truth[key])[0] < 1e-4
        to_truth = cKDTree(truth[key]).query(item.world_points)[0] < 1e-4
        # Those that lie on each other are divided between their centres: that is coarse.
        least = 0.7 if name in (ON_TOP, ON_EDGE) else 0.95
        assert to_found.mean() > least, f'{key}: too little of the object'
        assert to_truth.mean() > least, f'{key}: too much of something else'


@pytest.mark.parametrize('name', CAPTURES)
def test_a_pose_is_confirmed_where_the_object_is_and_nowhere_else(captures, name):
    capture = captures[name]
    truth = capture.objects()
    places = {key: points.mean(axis=0) for key, points in truth.items()}

    class SeenSurface:
        """What the camera saw of an object, as if it were its model."""

        def find(self, object_id):
            points = (truth[object_id] - places[object_id]).astype(np.float32)
            return KnownModel(np.random.default_rng(0).permutation(points)[:5000])

    result = ScenePerception(models=SeenSurface()).step(capture.frame(places))
    assert min(item.support for item in result.objects.values()) > 0.97
    eye = capture.world_from_camera.translation
    nearer = {
        key: place + 0.1 * (eye - place) / np.linalg.norm(eye - place)
        for key, place in places.items()
    }
    refused = ScenePerception(models=SeenSurface()).step(capture.frame(nearer)).rejected
    assert 'no support in the cloud' in refused['first']
    assert 'no support in the cloud' in refused['second']
