"""All three nodes before the simulated table."""

from __future__ import annotations

from pathlib import Path

from ros_graph import Graph
from spatial_relations_msgs.srv import Imitate, ListRelations

from .cell import Cell

PAIR = ['box', 'post']


class ThreeNodes:
    """perception_node, metric_node and imitate_node, which imitates with few steps.

    Args:
        graph: gets the nodes.
        folder: for models.
        weights: of the metric.
        memory: the file of remembered relations.
    """

    def __init__(self, graph: Graph, folder: Path, weights: Path, memory: Path) -> None:
        self.graph = graph
        folder.mkdir(exist_ok=True)
        self._common = {'weights': str(weights), 'service_timeout': 3.0, 'num_threads': 1}
        self._memory = memory
        self.start_metric()
        self.start_imitate()
        # The last scene stays: these tests are not about clouds.
        self.cell = Cell(graph, folder, max_age=0.0)
        self.cell.wait_well(150.0)
        graph.call(ListRelations, '/metric_node/list')
        assert self.imitate().answers

    def start_metric(self) -> None:
        self.graph.processes.start(
            'metric_node', parameters={**self._common, 'memory_path': str(self._memory)}
        )

    def start_imitate(self) -> None:
        self.graph.processes.start(
            'imitate_node',
            parameters={
                **self._common,
                'standalone': False,
                'time_budget': 0.0,
                'num_starts': 1,
                'max_steps': 2,
                'num_proposals': 4,
            },
        )

    def imitate(self) -> Imitate.Response:
        """As a client does that asks again when there is no answer."""
        ids = {'reference_ids': PAIR, 'test_ids': PAIR[::-1]}
        return self.graph.call_until_answered(Imitate, '/imitate', **ids)
