"""Train on scenes of your own: write them in the folder format, train, measure."""

# %% Scenes are two objects, two poses and a label. Here rules place them; yours come from people.
import dataclasses
import json
from pathlib import Path

import numpy as np

from spatial_relations_ros.core import Pose, Relation
from spatial_relations_ros.datasets.freiburg import (
    RelationDataset,
    RelationScene,
    Split,
    load_dataset,
    write_dataset,
)
from spatial_relations_ros.datasets.objects import sample_object
from spatial_relations_ros.evaluation.training import train_metric
from spatial_relations_ros.learning import load_metric

OUT = Path('out/examples/train')
STEPS = 4  # the shipped weights took 5,000
rng = np.random.default_rng(0)
objects = {
    f'{family}{number}': sample_object(family, rng)
    for family in ('tray', 'can')
    for number in range(4)
}

# %% Poses are world_from_object, metres, z up; the base's translation is zero in files.
scenes = []
for number in range(16):
    base, relative = f'tray{number % 4}', f'can{number // 4}'
    for relation, shift in ((Relation.ON_TOP, 0.0), (Relation.NEXT_TO, 0.25)):
        height = np.ptp(objects[relative].mesh.vertices[:, 2]) / 2.0
        place = rng.normal((shift, 0.0, 0.02 + height), 0.005)
        name = f'{base}_{relative}_{len(scenes)}'
        scenes.append(RelationScene(name, base, relative, Pose(), Pose(place), relation))
names = tuple(scene.name for scene in scenes)
dataset = RelationDataset(
    {name: model.mesh.sample_surface(2000, rng) for name, model in objects.items()},
    tuple(scenes),
    splits=(Split('split1', names[:20], names[20:]),),
)
write_dataset(
    OUT / 'data',
    dataclasses.replace(dataset, meshes={name: model.mesh for name, model in objects.items()}),
)
print(len(load_dataset(OUT / 'data').scenes), 'scenes in', OUT / 'data')

# %% Training writes weights, their card and the loss curve; a run that was stopped goes on.
card = train_metric(
    OUT / 'data',
    OUT / 'my.safetensors',
    steps=STEPS,
    run_dir=OUT / 'run',
    device='cpu',
    on_progress=lambda progress: print(f'step {progress.step}: loss {progress.loss:.3f}'),
)
assert card is not None

# %% The weights are used by naming them; the card says how well they retrieve held-out scenes.
metric = load_metric(OUT / 'my.safetensors')
loaded = load_dataset(OUT / 'data')
print('distance of two scenes:', metric.distance(loaded.scene(names[0]), loaded.scene(names[1])))
(OUT / 'retrieval.json').write_text(json.dumps(card.retrieval, indent=2))
