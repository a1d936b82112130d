import pytest

from spatial_relations_ros.core import Scene
from spatial_relations_ros.learning import load_metric


@pytest.fixture(scope='module')
def metric():
    return load_metric()


@pytest.fixture(scope='module')
def on_top(solids):
    return Scene(
        solids.box('plate', (0.22, 0.2, 0.03), (0.4, 0.1, 0.015)),
        solids.cup('cup', 0.04, 0.1, (0.41, 0.1, 0.0805)),
    )


@pytest.fixture(scope='module')
def apart(solids):
    return Scene(
        solids.box('tray', (0.3, 0.2, 0.04), (0, 0, 0.02)),
        solids.box('carton', (0.07, 0.07, 0.18), (0.35, 0.05, 0.09)),
    )
