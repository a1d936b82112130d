import dataclasses

import numpy as np
import pytest

from spatial_relations_ros.core import Pose, Relation, Scene
from spatial_relations_ros.datasets.freiburg import RelationDataset, RelationScene
from spatial_relations_ros.evaluation.generalization.attempt import Attempt
from spatial_relations_ros.evaluation.generalization.cases import Case


@pytest.fixture(scope='session')
def boxes(solids):
    """A board with a cube on it, at its edge, and beside it: scenes on the table z = 0."""
    board = solids.box('board', (0.2, 0.16, 0.04), (0, 0, 0.02))
    cube = solids.box('cube', (0.06, 0.06, 0.06), (0, 0, 0.07))

    def scene(x, z=0.07):
        return Scene(board, dataclasses.replace(cube, world_from_object=Pose(np.array([x, 0, z]))))

    return {
        Relation.ON_TOP: scene(0.01),
        Relation.ON_TOP_EDGE: scene(0.09),
        Relation.NEXT_TO: scene(0.15, 0.03),
    }


@pytest.fixture(scope='session')
def case(boxes):
    """The cube beside the board shall stand on it."""
    return Case(
        3, 'known', Relation.ON_TOP, boxes[Relation.ON_TOP], boxes[Relation.NEXT_TO],
        'board_cube_0', 'board_cube_1',
    )  # fmt: skip


@pytest.fixture
def attempt_at(case):
    """Makes an attempt that puts the cube somewhere."""

    def make(x, z, quat_wxyz=(1.0, 0.0, 0.0, 0.0), *, claimed=True):
        pose = Pose(np.array([x, 0.0, z]), np.array(quat_wxyz))
        base = case.test.base.world_from_object
        return Attempt((base, pose), claimed, 0.9, 0.1, 1.0, 7, 0.5, 0.5, 'words')

    return make


@pytest.fixture(scope='session')
def labelled(solids):
    """Two scenes of each of four relations, made of eight boxes and four cups."""
    items = {
        f'board{number}': solids.box(f'board{number}', (0.2, 0.16, 0.04), (0, 0, 0))
        for number in range(6)
    }
    items |= {
        f'cube{number}': solids.box(f'cube{number}', (0.04, 0.04, 0.04), (0, 0, 0))
        for number in range(8)
    }
    items |= {
        f'cup{number}': solids.cup(f'cup{number}', 0.05, 0.1, (0, 0, 0)) for number in range(2)
    }
    places = [
        ('board', Relation.ON_TOP, (0.01, 0.0, 0.04)),
        ('board', Relation.ON_TOP_EDGE, (0.1, 0.0, 0.04)),
        ('board', Relation.NEXT_TO, (0.15, 0.0, 0.0)),
        ('cup', Relation.INSIDE, (0.0, 0.0, -0.026)),
    ]
    scenes = []
    for kind, (base, relation, place) in enumerate(places):
        for number in range(2):
            base_id = f'{base}{number if base == "cup" else 2 * kind + number}'
            relative_id = f'cube{2 * kind + number}'
            name = f'{base_id}_{relative_id}_{len(scenes)}'
            pose = Pose(np.array(place))
            scenes.append(RelationScene(name, base_id, relative_id, Pose(), pose, relation))
    return RelationDataset(
        {name: item.points for name, item in items.items()},
        tuple(scenes),
        meshes={name: item.mesh for name, item in items.items()},
    )
