"""Pictures of cases: the demonstration, the test objects before and after."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from spatial_relations_ros.evaluation.generalization.cases import Case
from spatial_relations_ros.evaluation.generalization.outcome import Outcome
from spatial_relations_ros.visualization import (
    Image,
    contact_sheet,
    frame_objects,
    render_scene,
    write_image,
)

CASES_A_SHEET = 30
_COLUMNS = 3
_WIDTH, _HEIGHT = 200, 150


@dataclass(frozen=True, eq=False)
class CaseView:
    """A case drawn.

    Attributes:
        picture: (150, 600, 3): demonstration, before, after.
        outcome: what came out.
    """

    picture: Image
    outcome: Outcome

    @property
    def caption(self) -> str:
        """Number, relation and what went wrong."""
        outcome = self.outcome
        return f'{outcome.number} {outcome.relation.description}: {outcome.cause or "right"}'


def draw_view(case: Case, outcome: Outcome) -> CaseView:
    """Draws a case; each picture has a camera of its own, so that small objects stay visible."""
    scenes = (case.reference, case.test, outcome.attempt.scene(case))
    pictures = [
        render_scene(
            scene.objects,
            camera=frame_objects([scene.objects], width=_WIDTH, height=_HEIGHT),
            table_height=0.0,
        )
        for scene in scenes
    ]
    return CaseView(np.concatenate(pictures, axis=1), outcome)


def write_sheets(folder: Path, views: Sequence[CaseView]) -> list[Path]:
    """Writes ``EXPERIMENT_VARIANT_NN.png``, thirty cases each; returns their paths.

    Failures come first, grouped by cause, the most frequent cause before the others.
    """
    groups: dict[tuple[str, str], list[CaseView]] = {}
    for view in views:
        groups.setdefault((view.outcome.experiment, view.outcome.variant), []).append(view)
    paths = []
    for (experiment, variant), members in groups.items():
        ordered = failures_first(members)
        for number, first in enumerate(range(0, len(ordered), CASES_A_SHEET), start=1):
            chosen = ordered[first : first + CASES_A_SHEET]
            stem = re.sub(r'[^\w.-]+', '_', f'{experiment}_{variant}_{number:02d}')
            sheet = contact_sheet(
                [view.picture for view in chosen],
                [view.caption for view in chosen],
                columns=_COLUMNS,
            )
            paths.append(write_image(folder / f'{stem}.png', sheet))
    return paths


def failures_first(views: Sequence[CaseView]) -> list[CaseView]:
    """Failures grouped by cause, the most frequent first, then what is right; else as given."""
    causes = [view.outcome.cause for view in views]
    return sorted(
        views,
        key=lambda view: (
            not view.outcome.cause, -causes.count(view.outcome.cause), view.outcome.cause,
        ),
    )  # fmt: skip
