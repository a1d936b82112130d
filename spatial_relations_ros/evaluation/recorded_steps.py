"""An imitation as it ran, for pages, animations and recordings."""

from __future__ import annotations

from dataclasses import dataclass, field

from spatial_relations_ros.core import Scene
from spatial_relations_ros.imitation import ImitationProgress, ImitationResult
from spatial_relations_ros.visualization import ShownAnswer, ShownImitation, ShownStep

MAX_STEPS = 400


@dataclass
class StepRecorder:
    """Keeps how the best answer changed while an imitation ran."""

    steps: list[ShownStep] = field(default_factory=list)

    def record(self, progress: ImitationProgress) -> None:
        """Takes one report of progress; the same poses are kept once."""
        base, relative = progress.best.placements
        poses = base.target, relative.target
        if self.steps and self.steps[-1].poses == poses:
            return
        if len(self.steps) < MAX_STEPS:
            self.steps.append(
                ShownStep(poses, float(progress.distance), progress.step, progress.feasible)
            )


def shown_as_it_ran(
    reference: Scene,
    test: Scene,
    result: ImitationResult,
    recorder: StepRecorder,
    table_height: float | None = None,
) -> ShownImitation:
    """The result with its steps; without checks and without measuring anything anew."""
    answers = tuple(
        ShownAnswer(
            (answer.placements[0].target, answer.placements[1].target),
            float(answer.distance),
            answer.feasible,
        )
        for answer in result.answers
    )
    title = '/'.join(test.object_ids) + ' like ' + '/'.join(reference.object_ids)
    history = tuple(float(value) for value in result.distance_history)
    return ShownImitation(
        title, reference, test, answers, tuple(recorder.steps), history, result.success,
        result.message, (), table_height,
    )  # fmt: skip
