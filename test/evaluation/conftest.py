import numpy as np
import pytest

from spatial_relations_ros.core import Pose, Relation
from spatial_relations_ros.datasets.freiburg import RelationDataset, RelationScene, Split


@pytest.fixture(scope='session')
def relation_scenes(solids):
    """Sixteen boxes on top of and beside a larger one, with two splits."""
    items = {
        'base': solids.box('base', (0.2, 0.2, 0.1), (0, 0, 0)),
        'cube': solids.box('cube', (0.06, 0.06, 0.06), (0, 0, 0)),
    }
    rng = np.random.default_rng(0)
    scenes = []
    for number in range(8):
        x, y = rng.uniform(-0.05, 0.05, 2)
        on_top, beside = Pose(np.array([x, y, 0.08])), Pose(np.array([0.2 + x, y, -0.02]))
        for label, pose in ((Relation.ON_TOP, on_top), (Relation.NEXT_TO, beside)):
            name = f'base_cube_{2 * number + (label is Relation.NEXT_TO)}'
            scenes.append(RelationScene(name, 'base', 'cube', Pose(), pose, label))
    names = tuple(scene.name for scene in scenes)
    return RelationDataset(
        {name: item.points for name, item in items.items()},
        tuple(scenes),
        splits=(Split('split1', names[:12], names[12:]), Split('split2', names[4:], names[:4])),
        meshes={name: item.mesh for name, item in items.items()},
    )
