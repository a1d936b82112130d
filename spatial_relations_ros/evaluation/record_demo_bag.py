"""Records the demonstration that ``make demo`` replays.

    python -m spatial_relations_ros.evaluation.record_demo_bag bags

makes ``bags/demo`` (the bag), ``bags/objects`` (the objects' meshes) and ``bags/demo.yaml``. The
same seed gives the same bytes. With ``--moving`` it makes ``moving`` instead of ``demo``, in which
the cup is taken off the plate and put down beside it.
"""

from __future__ import annotations

import argparse
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from spatial_relations_ros.core import ConfigError, Pose, atomic_write
from spatial_relations_ros.core.rotations import matrix_from_rotvec
from spatial_relations_ros.datasets.kinect_simulator import SD_CAMERA, KinectSimulator
from spatial_relations_ros.datasets.object_files import save_mesh
from spatial_relations_ros.evaluation.bag_writer import BagWriter
from spatial_relations_ros.evaluation.demo_scenario import (
    IMITATIONS,
    TABLE_HEIGHT,
    DemoObject,
    make_scenario,
    scenario_surfaces,
    world_from_camera,
)
from spatial_relations_ros.evaluation.moving_scenario import objects_at
from spatial_relations_ros.perception.border import StampedTransform, TrackedPose
from spatial_relations_ros.perception.camera import PinholeCamera
from spatial_relations_ros.perception.series import NS_PER_SEC

WORLD_FRAME = 'world'
LINK_FRAME = 'kinect2_link'
IR_FRAME = 'kinect2_ir_optical_frame'
RGB_FRAME = 'kinect2_rgb_optical_frame'
POINTS_TOPIC = '/kinect2/sd/points'
TRACKS_TOPIC = '/tracked_objects'
POSE_TOPIC = '/simtrack/{}'
STATIC_TF_TOPIC = '/tf_static'

# Optical frame in a body frame (REP-103): x forward, y left, z up.
LINK_FROM_IR = Pose(np.zeros(3), np.array([0.5, -0.5, 0.5, -0.5]))
# The colour camera sits 52 mm beside the infrared one.
IR_FROM_RGB = Pose(np.array([-0.052, 0.0, 0.0]))


@dataclass(frozen=True)
class RecordingOptions:
    """What is recorded.

    Attributes:
        duration_sec: length of the bag.
        cloud_rate: clouds a second. A Kinect2 gives 30; the repository pays for each.
        pose_rate: tracked poses a second of each object.
        jitter_metres: standard deviation of each tracked coordinate.
        jitter_rad: standard deviation of the tracked rotation about each axis.
        tracker_delay_sec: from the image to its tracked poses.
        cloud_delay_sec: from the image to its cloud.
        start_ns: time of the first image.
        seed: of everything random; the default gives objects that all are well in view.
        is_moving: whether the first demonstration changes, as ``moving_scenario`` tells.
        camera: of the clouds.
    """

    duration_sec: float = 4.0
    cloud_rate: float = 5.0
    pose_rate: float = 30.0
    jitter_metres: float = 0.001
    jitter_rad: float = 0.006
    tracker_delay_sec: float = 0.012
    cloud_delay_sec: float = 0.020
    start_ns: int = 1_700_000_000 * NS_PER_SEC
    seed: int = 5
    is_moving: bool = False
    camera: PinholeCamera = SD_CAMERA

    def __post_init__(self) -> None:
        if not (self.duration_sec > 0 and self.cloud_rate > 0 and self.pose_rate > 0):
            raise ConfigError(f'duration and rates must be positive, got {self}')


def record_demo_bag(folder: Path | str, options: RecordingOptions | None = None) -> Path:
    """Writes bag, meshes and the list of imitations; an older demonstration is replaced.

    Returns:
        The folder of the bag.

    Raises:
        BagError: when the bag cannot be written.
        SpatialRelationsError: when no fitting objects are found for the seed.
    """
    folder = Path(folder)
    options = options or RecordingOptions()
    objects = make_scenario(options.seed)
    shutil.rmtree(folder / 'objects', ignore_errors=True)
    for item in objects:
        save_mesh(folder / 'objects' / f'{item.object_id}.ply', item.model.mesh)
    bag = folder / ('moving' if options.is_moving else 'demo')
    if (bag / 'metadata.yaml').is_file():
        shutil.rmtree(bag)
    folder.mkdir(parents=True, exist_ok=True)
    _write_bag(bag, objects, options)
    if options.is_moving:
        return bag
    with atomic_write(folder / 'demo.yaml') as temporary:
        temporary.write_text(_describe_demo(), encoding='utf-8')
    return bag


def main(arguments: Sequence[str] | None = None) -> None:
    """The command: see the module."""
    parser = argparse.ArgumentParser(description='Records the demonstration bag.')
    parser.add_argument('folder', type=Path, help='such as bags')
    parser.add_argument('--seed', type=int, default=RecordingOptions.seed)
    parser.add_argument('--duration', type=float, default=RecordingOptions.duration_sec)
    parser.add_argument('--cloud-rate', type=float, default=RecordingOptions.cloud_rate)
    parser.add_argument('--moving', action='store_true', help='a demonstration that changes')
    args = parser.parse_args(arguments)
    options = RecordingOptions(
        seed=args.seed,
        duration_sec=args.duration,
        cloud_rate=args.cloud_rate,
        is_moving=args.moving,
    )
    bag = record_demo_bag(args.folder, options)
    num_bytes = sum(path.stat().st_size for path in bag.iterdir())
    print(f'{bag}: {num_bytes / 1e6:.1f} MB')


def _write_bag(bag: Path, objects: tuple[DemoObject, ...], options: RecordingOptions) -> None:
    # One stream each: another cloud rate leaves the poses as they are.
    cloud_rng, pose_rng = (
        np.random.default_rng([options.seed, stream_idx]) for stream_idx in (1, 2)
    )
    simulator = KinectSimulator(scenario_surfaces(objects), world_from_camera(), options.camera)
    rgb_from_world = (world_from_camera() @ IR_FROM_RGB).inverse()
    events = [
        (start + round(delay * NS_PER_SEC), kind, start)
        for kind, rate, delay in (
            ('poses', options.pose_rate, options.tracker_delay_sec),
            ('cloud', options.cloud_rate, options.cloud_delay_sec),
        )
        for start in _image_times(rate, options)
    ]
    with BagWriter(bag) as writer:
        transforms = writer.transforms(static_transforms(options.start_ns))
        writer.write(STATIC_TF_TOPIC, options.start_ns, transforms)
        for time_ns, kind, image_ns in sorted(events):
            present = objects
            if options.is_moving:
                share = (image_ns - options.start_ns) / NS_PER_SEC / options.duration_sec
                present = objects_at(objects, share)
            if kind == 'cloud':
                if options.is_moving:
                    surfaces = scenario_surfaces(present)
                    simulator = KinectSimulator(surfaces, world_from_camera(), options.camera)
                image = simulator.measure(cloud_rng)
                message = writer.cloud(image_ns, IR_FRAME, simulator.xyz(image), image.rgb)
                writer.write(POINTS_TOPIC, time_ns, message)
                continue
            tracks = [
                _track(item, image_ns, rgb_from_world, pose_rng, options) for item in present
            ]
            message = writer.tracked_objects(image_ns, RGB_FRAME, tracks)
            writer.write(TRACKS_TOPIC, time_ns, message)
            for track in tracks:
                topic = POSE_TOPIC.format(track.object_id)
                writer.write(topic, time_ns, writer.pose_stamped(track))


def static_transforms(stamp_ns: int) -> list[StampedTransform]:
    """From the world over the camera's housing to both of its optical frames."""
    world_from_link = world_from_camera() @ LINK_FROM_IR.inverse()
    poses = {
        (WORLD_FRAME, LINK_FRAME): world_from_link,
        (LINK_FRAME, IR_FRAME): LINK_FROM_IR,
        (LINK_FRAME, RGB_FRAME): LINK_FROM_IR @ IR_FROM_RGB,
    }
    return [
        StampedTransform(parent, child, stamp_ns, pose, is_static=True)
        for (parent, child), pose in poses.items()
    ]


def _image_times(rate: float, options: RecordingOptions) -> list[int]:
    num_images = max(1, round(rate * options.duration_sec))
    return [options.start_ns + round(idx * NS_PER_SEC / rate) for idx in range(num_images)]


def _track(
    item: DemoObject,
    stamp_ns: int,
    rgb_from_world: Pose,
    rng: np.random.Generator,
    options: RecordingOptions,
) -> TrackedPose:
    """The true pose with a tracker's jitter, in the colour camera's frame."""
    jitter = Pose.from_rotation(
        matrix_from_rotvec(rng.normal(0.0, options.jitter_rad, 3)),
        rng.normal(0.0, options.jitter_metres, 3),
    )
    rgb_from_object = rgb_from_world @ item.world_from_object @ jitter
    confidence = float(np.float32(rng.uniform(0.85, 0.99)))
    return TrackedPose(item.object_id, stamp_ns, RGB_FRAME, rgb_from_object, confidence)


def _describe_demo() -> str:
    lines = [
        '# What make demo replays and asks for; paths are relative to this file.',
        'bag: demo',
        'models_path: objects',
        f'world_frame: {WORLD_FRAME}',
        f'camera_frame: {IR_FRAME}',
        f'points_topic: {POINTS_TOPIC}',
        f'tracked_objects_topic: {TRACKS_TOPIC}',
        f'table_height: {TABLE_HEIGHT}  # true z of the table in the world, metres',
        '# [base, relative]; the first is the main one.',
        'imitations:',
    ]
    for imitation in IMITATIONS:
        reference, test = (', '.join(ids) for ids in (imitation.reference_ids, imitation.test_ids))
        lines += [
            f'  - relation: {imitation.relation.name.lower()}',
            f'    reference_ids: [{reference}]',
            f'    test_ids: [{test}]',
        ]
    return '\n'.join(lines) + '\n'


if __name__ == '__main__':
    main()
