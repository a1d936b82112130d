"""Fixtures of the tests with real nodes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
import torch
from ros_graph import Graph

from spatial_relations_ros.learning import ModelCard, make_encoder, save_metric


@pytest.fixture(scope='module')
def graph(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Graph]:
    graph = Graph(tmp_path_factory.mktemp('graph'))
    yield graph
    codes = graph.close()
    assert set(codes.values()) <= {0}, f'exit codes {codes}'


@pytest.fixture(scope='session')
def weights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small untrained network: what is tested here is not how good it is."""
    torch.manual_seed(0)
    path = tmp_path_factory.mktemp('weights') / 'compact.safetensors'
    save_metric(make_encoder('compact'), ModelCard('compact', 512), path)
    return path


@pytest.fixture(scope='session')
def bags() -> Path:
    return Path(__file__).resolve().parents[2] / 'bags'
