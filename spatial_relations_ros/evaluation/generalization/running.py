"""Running variants on cases, in one process or in several."""

from __future__ import annotations

import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TypeVar

import torch

from spatial_relations_ros.core import TriangleMesh
from spatial_relations_ros.evaluation.generalization.cases import Case
from spatial_relations_ros.evaluation.generalization.feasibility import (
    remember_parts,
    remembered_parts,
)
from spatial_relations_ros.evaluation.generalization.outcome import Outcome, judge_attempt
from spatial_relations_ros.evaluation.generalization.variants import Imitator, Weights
from spatial_relations_ros.evaluation.generalization.views import CaseView, draw_view
from spatial_relations_ros.placement.convex_parts import ConvexPart

OnProgress = Callable[[int, int], None]
Job = tuple[str, int]
"""A variant and a place in the list of cases."""

J = TypeVar('J')
R = TypeVar('R')


@dataclass(frozen=True)
class Settings:
    """How cases are run.

    Attributes:
        weights: of the metrics.
        seed: of every imitation.
        simulate: let results go in MuJoCo for a second.
    """

    weights: Weights
    seed: int = 0
    simulate: bool = True


class CaseBench:
    """Cases and what they are run with, in one process."""

    def __init__(self, cases: Sequence[Case], settings: Settings) -> None:
        """Loads the weights."""
        self.cases, self.settings = cases, settings
        self.imitator = Imitator(settings.weights, seed=settings.seed)

    def run(self, job: Job) -> Outcome:
        """Runs a variant on a case and judges what comes out."""
        variant, idx = job
        case = self.cases[idx]
        attempt = self.imitator.attempt(case, variant)
        return judge_attempt(case, variant, attempt, simulate=self.settings.simulate)

    def draw(self, job: tuple[int, Outcome]) -> CaseView:
        """Draws a case and what came out."""
        idx, outcome = job
        return draw_view(self.cases[idx], outcome)


class Runner:
    """Runs cases, with the same results for any number of processes.

    Args:
        cases: of all experiments.
        settings: how they are run.
        num_jobs: processes; with 1 the caller's own does the work, with all threads it has,
            with more each has one thread.
    """

    def __init__(self, cases: Sequence[Case], settings: Settings, *, num_jobs: int = 1) -> None:
        self._cases, self._settings, self._num_jobs = cases, settings, num_jobs
        self._pool: ProcessPoolExecutor | None = None
        self._bench: CaseBench | None = None

    @contextmanager
    def started(self) -> Iterator[Runner]:
        """Starts the processes, and ends them."""
        if self._num_jobs == 1:
            self._bench = CaseBench(self._cases, self._settings)
            yield self
            return
        with ProcessPoolExecutor(
            self._num_jobs,
            # A fork would copy the locks of the thread pools of Open3D and of OpenMP.
            mp_context=multiprocessing.get_context('spawn'),
            initializer=_start_worker,
            # One pickle of all cases: scenes of the same object go on sharing its mesh, and
            # with it all that is computed once for each mesh.
            initargs=(self._cases, self._settings, remembered_parts(_meshes(self._cases))),
        ) as pool:
            self._pool = pool
            try:
                yield self
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise

    def run(self, jobs: Sequence[Job], on_progress: OnProgress | None = None) -> list[Outcome]:
        """Outcomes in the order of the jobs."""
        outcomes = self._map(_run_in_worker, lambda bench: bench.run, jobs)
        return _counted(outcomes, len(jobs), on_progress)

    def draw(
        self, jobs: Sequence[tuple[int, Outcome]], on_progress: OnProgress | None = None
    ) -> list[CaseView]:
        """Pictures in the order of the jobs: places of cases, and what came out."""
        views = self._map(_draw_in_worker, lambda bench: bench.draw, jobs)
        return _counted(views, len(jobs), on_progress)

    def _map(
        self,
        in_worker: Callable[[J], R],
        method_of: Callable[[CaseBench], Callable[[J], R]],
        jobs: Sequence[J],
    ) -> Iterator[R]:
        if self._pool is not None:
            return self._pool.map(in_worker, jobs)
        assert self._bench is not None, 'not started'
        return map(method_of(self._bench), jobs)


def jobs_of(cases: Sequence[Case], variants: Sequence[str], limit: int | None) -> list[Job]:
    """What is to be run: the first variant on all cases, others on ``limit`` of each experiment.

    Chosen ones are spread evenly, so that each relation keeps about its share.
    """
    rows: dict[str, list[int]] = {}
    for idx, case in enumerate(cases):
        rows.setdefault(case.experiment, []).append(idx)
    jobs = []
    for number, variant in enumerate(variants):
        for members in rows.values():
            count = len(members)
            if number and limit is not None:
                count = min(limit, count)
            jobs += [(variant, members[place * len(members) // count]) for place in range(count)]
    return jobs


def _counted(results: Iterator[R], total: int, on_progress: OnProgress | None) -> list[R]:
    done: list[R] = []
    for result in results:
        done.append(result)
        if on_progress is not None:
            on_progress(len(done), total)
    return done


_worker_bench: CaseBench | None = None


def _meshes(cases: Sequence[Case]) -> list[TriangleMesh]:
    return [item.mesh for case in cases for item in case.test.objects if item.mesh is not None]


def _start_worker(
    cases: Sequence[Case],
    settings: Settings,
    parts: Sequence[tuple[TriangleMesh, tuple[ConvexPart, ...]]],
) -> None:
    global _worker_bench
    torch.set_num_threads(1)
    for mesh, its_parts in parts:
        remember_parts(mesh, its_parts)
    _worker_bench = CaseBench(cases, settings)


def _run_in_worker(job: Job) -> Outcome:
    assert _worker_bench is not None
    return _worker_bench.run(job)


def _draw_in_worker(job: tuple[int, Outcome]) -> CaseView:
    assert _worker_bench is not None
    return _worker_bench.draw(job)
