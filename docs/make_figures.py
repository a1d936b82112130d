"""Draws the pictures of these pages anew: ``make figures``; takes minutes, mostly for the map."""

from __future__ import annotations

import argparse
import dataclasses
import os
import runpy
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image as PillowImage

from spatial_relations_ros.cli.pose_files import read_pose_file
from spatial_relations_ros.core import Pose, Scene, SceneObject
from spatial_relations_ros.datasets.freiburg import load_dataset
from spatial_relations_ros.datasets.generator import generate_dataset
from spatial_relations_ros.datasets.object_files import load_object_model
from spatial_relations_ros.evaluation.comparison import compare_metric
from spatial_relations_ros.evaluation.labelled_scenes import LabelledScenes
from spatial_relations_ros.evaluation.retrieval_pictures import SceneGallery, embedding_map
from spatial_relations_ros.imitation import ImitationOptions, imitate
from spatial_relations_ros.learning import RelationMetric, load_metric
from spatial_relations_ros.visualization import (
    Image,
    before_after,
    contact_sheet,
    draw_distance_curve,
    draw_projection_gradients,
    draw_projections,
    read_image,
)

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / 'docs' / 'images'
EXAMPLES = {
    'own_objects': ('own_objects.py', 'own_objects/overview.png'),
    'support': ('evaluate_a_bag.py', 'bag/support.png'),
    'moves': ('moves_for_an_arm.py', 'moves/moves.png'),
}
GRADIENTS = ('silhouette', 'sobel')
DESCENT_STEPS = 60


def main() -> None:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('names', nargs='*', help='of figures; all without')
    parser.add_argument('--out', type=Path, default=IMAGES)
    parser.add_argument('--held-out', type=Path, help='unseen scenes; drawn anew without')
    args = parser.parse_args()
    metric = load_metric()
    makers = {
        'demo': lambda: demonstration(metric),
        'projections': lambda: projections(metric),
        'gradients': lambda: gradients(metric),
        'descent': lambda: descent(metric),
        **{name: lambda name=name: example(*EXAMPLES[name]) for name in EXAMPLES},
        'embedding': lambda: embedding(metric, args.held_out),
    }
    unknown = sorted(set(args.names) - set(makers))
    if unknown:
        parser.error(f'no figure {unknown[0]!r}; there are {", ".join(makers)}')
    for name in args.names or makers:
        path = args.out / f'{name}.png'
        write_small(path, makers[name]())
        print(f'{path}: {path.stat().st_size / 1000:.0f} kB', flush=True)


def write_small(path: Path, image: Image) -> None:
    """A PNG of 256 colours: a third of the size, and no difference that one sees."""
    path.parent.mkdir(parents=True, exist_ok=True)
    small = PillowImage.fromarray(image).quantize(256, dither=PillowImage.Dither.FLOYDSTEINBERG)
    small.save(path, optimize=True)


def shown_scene(base: str, relative: str, poses: str) -> Scene:
    """A demonstration of the recorded bag."""
    base_pose, relative_pose = read_pose_file(ROOT / 'examples' / f'{poses}.json')
    return Scene(bag_object(base, base_pose), bag_object(relative, relative_pose))


def test_scene() -> Scene:
    """Tray and mug beside each other on a table at z = 0."""
    tray, mug = bag_object('tray', Pose()), bag_object('mug', Pose())
    heights = [-float(item.mesh.vertices[:, 2].min()) for item in (tray, mug)]
    return Scene(
        tray.moved_to(Pose((0.0, 0.0, heights[0]))), mug.moved_to(Pose((0.27, 0.0, heights[1])))
    )


def bag_object(object_id: str, world_from_object: Pose) -> SceneObject:
    """An object of the recorded bag, at a pose."""
    mesh, points = load_object_model(ROOT / 'bags' / 'objects' / f'{object_id}.ply')
    return SceneObject(object_id, points, world_from_object, mesh=mesh)


def demonstration(metric: RelationMetric) -> Image:
    """Demonstration, before and after."""
    reference, test = shown_scene('plate', 'cup', 'cup_on_plate'), test_scene()
    result = imitate(metric, reference, test, ImitationOptions(seed=0))
    return before_after(reference, test, result.answers[0].scene(test))


def projections(metric: RelationMetric) -> Image:
    """The six images of the demonstration, as the network sees them."""
    scene = shown_scene('plate', 'cup', 'cup_on_plate')
    return draw_projections(metric.projections(scene), object_ids=scene.object_ids, cell=200)


def gradients(metric: RelationMetric) -> Image:
    """The distance's gradient by images and by points; the mug stands too far to a side."""
    reference, test = shown_scene('plate', 'cup', 'cup_on_plate'), test_scene()
    tray = test.base.world_from_object
    mug = test.relative.world_from_object
    beside = mug.translation + (-0.18, 0.03, 0.008)
    scene = test.with_poses(tray, Pose(beside, mug.quat_wxyz))
    pictures = []
    for name in GRADIENTS:
        with metric.projecting(gradient=name):
            found = metric.projection_gradients(reference, scene)
        pictures.append(
            draw_projection_gradients(
                found.images, found.by_images, found.descent, object_ids=scene.object_ids, cell=200
            )
        )
    return contact_sheet(pictures, GRADIENTS, columns=1)


def descent(metric: RelationMetric) -> Image:
    """Descent through the metric alone, as in the paper, from a start near the goal."""
    reference, test = shown_scene('plate', 'cup', 'cup_on_plate'), test_scene()
    mug = test.relative.world_from_object
    test = test.with_poses(
        test.base.world_from_object, Pose(mug.translation + (-0.15, 0.05, 0.06), mug.quat_wxyz)
    )
    options = dataclasses.replace(
        ImitationOptions.paper(), movable=('relative',), max_steps=DESCENT_STEPS,
        learning_rate=ImitationOptions.learning_rate,
    )  # fmt: skip
    result = imitate(metric, reference, test, options)
    curve = draw_distance_curve(
        result.distance_history, title='Distance to the demonstration', width=1100, height=360
    )
    scenes = before_after(reference, test, result.answers[0].scene(test))
    return contact_sheet([scenes, curve], columns=1)


def embedding(metric: RelationMetric, held_out: Path | None) -> Image:
    """t-SNE of unseen scenes, coloured by relation."""
    with tempfile.TemporaryDirectory() as folder:
        if held_out is None:
            held_out = Path(folder)
            generate_dataset(held_out, num_scenes=1050, num_objects=194, seed=202)
        scenes = LabelledScenes.of(load_dataset(held_out))
        compared = compare_metric('shipped', metric, scenes, ('scene',))
        assert compared.embeddings is not None
        gallery = SceneGallery(scenes, 14)
        return embedding_map(compared.embeddings, scenes, gallery, name='shipped weights', seed=0)


def example(script: str, picture: str) -> Image:
    """What an example leaves, run in a folder that is thrown away."""
    before = Path.cwd()
    with tempfile.TemporaryDirectory() as folder:
        for name in ('bags', 'examples'):
            (Path(folder) / name).symlink_to(ROOT / name)
        os.chdir(folder)
        try:
            runpy.run_path(f'examples/{script}')
            image = read_image(Path('out', 'examples', picture))
        finally:
            os.chdir(before)
    return np.ascontiguousarray(image)


if __name__ == '__main__':
    main()
