"""Fixtures of the tests with real nodes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import torch
from ros_graph import Graph, running_graph

from spatial_relations_ros.learning import Calibration, ModelCard, make_encoder, save_metric


@pytest.fixture(scope='module')
def graph(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Graph]:
    yield from running_graph(tmp_path_factory.mktemp('graph'))


@pytest.fixture(scope='session')
def weights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small untrained network: what is tested here is not how good it is."""
    torch.manual_seed(0)
    path = tmp_path_factory.mktemp('weights') / 'compact.safetensors'
    calibration = Calibration(
        np.array([0.0, 2.0]), np.array([0.9, 0.1]), np.zeros((1, 64), dtype=np.float32), 0.01
    )
    save_metric(make_encoder('compact'), ModelCard('compact', 512), path, calibration=calibration)
    return path


@pytest.fixture(scope='session')
def bags() -> Path:
    return Path(__file__).resolve().parents[2] / 'bags'
