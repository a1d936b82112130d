"""One of several processes that train together; started by a test."""

import os
import sys
from pathlib import Path

import numpy as np
import torch

from spatial_relations_ros.core import Pose, Relation, Scene, SceneObject
from spatial_relations_ros.learning import trainer
from spatial_relations_ros.learning.training_config import TrainingConfig
from spatial_relations_ros.learning.training_set import TrainingSet


def cloud(name, size, position):
    points = np.random.default_rng(0).uniform(-0.5, 0.5, (500, 3)) * size
    return SceneObject(name, points.astype(np.float32), Pose(np.array(position)))


def main(out):
    base = cloud('base', (0.2, 0.2, 0.1), (0.0, 0.0, 0.05))
    on_top = Scene(base, cloud('relative', (0.1, 0.1, 0.1), (0.0, 0.0, 0.15)))
    beside = Scene(base, cloud('relative', (0.1, 0.1, 0.1), (0.2, 0.0, 0.05)))
    labels = [Relation.ON_TOP, Relation.NEXT_TO] * 3
    training_set = TrainingSet.from_scenes([on_top, beside] * 3, labels)
    losses, kept = [], {}

    class Watched(trainer._Run):
        def advance(self):
            losses.append(super().advance())
            kept['mean_distance'] = float(self.batch_loss.ratio.running_mean)
            return losses[-1]

    trainer._Run = Watched
    config = TrainingConfig(
        steps=3, scenes_per_class=2, num_points=64, lifted_clones=2, loss='ratio'
    )
    encoder = trainer.train_encoder(
        training_set, config, seed=0, run_dir=out / 'run', device='cpu'
    )
    torch.save(
        {'weights': encoder.state_dict(), 'losses': losses, **kept},
        out / f'{os.environ["RANK"]}.pt',
    )


if __name__ == '__main__':
    main(Path(sys.argv[1]))
