"""``relations imitate``."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape

from spatial_relations_ros.cli.error_reports import FAILED
from spatial_relations_ros.cli.imitation_files import (
    ANIMATION_SUFFIXES,
    REPORT_SUFFIXES,
    check_suffix,
    shown_imitation,
    write_shown,
)
from spatial_relations_ros.cli.options import (
    DataOption,
    MemoryOption,
    ObjectsOption,
    ReferenceBase,
    ReferenceName,
    ReferencePoses,
    ReferenceRelative,
    RememberedName,
    SeedOption,
    TestBase,
    TestName,
    TestPoses,
    TestRelative,
    WeightsOption,
)
from spatial_relations_ros.cli.output import JsonOption, Output, check_folder, progress_bar
from spatial_relations_ros.cli.pose_files import ROLES
from spatial_relations_ros.cli.recording import RerunOption, check_recording, record_shown
from spatial_relations_ros.cli.robot_options import (
    ApproachOption,
    GraspOption,
    ObstaclesOption,
    ReachFarthest,
    ReachNearest,
    ShoulderOption,
    robot_options,
)
from spatial_relations_ros.cli.scene_sources import SceneSource
from spatial_relations_ros.cli.showing import show_imitation
from spatial_relations_ros.cli.simulation import require_mujoco, simulated_answers

if TYPE_CHECKING:
    from spatial_relations_ros.core import Scene
    from spatial_relations_ros.evaluation.recorded_steps import StepRecorder
    from spatial_relations_ros.imitation import (
        ImitationOptions,
        ImitationProgress,
        ImitationResult,
    )
    from spatial_relations_ros.learning import RelationMetric


class Movable(StrEnum):
    """Which test objects may move."""

    RELATIVE = 'relative'
    BASE = 'base'
    BOTH = 'both'


def imitate(
    reference: ReferenceName = None,
    test: TestName = None,
    data: DataOption = None,
    reference_base: ReferenceBase = None,
    reference_relative: ReferenceRelative = None,
    reference_poses: ReferencePoses = None,
    test_base: TestBase = None,
    test_relative: TestRelative = None,
    test_poses: TestPoses = None,
    objects: ObjectsOption = None,
    remembered: RememberedName = None,
    memory: MemoryOption = None,
    weights: WeightsOption = None,
    movable: Annotated[
        Movable, typer.Option('--movable', help='Which test objects may move.')
    ] = Movable.RELATIVE,
    num_answers: Annotated[int, typer.Option('--answers', min=1, help='At most so many.')] = 1,
    keep_heading: Annotated[
        bool, typer.Option('--keep-heading', help="Keep the demonstration's direction as well.")
    ] = False,
    keep_upright: Annotated[
        bool, typer.Option('--keep-upright', help='Turn what is placed about the vertical only.')
    ] = False,
    keep_on_table: Annotated[
        bool, typer.Option('--keep-on-table', help='Leave what is placed standing on the table.')
    ] = False,
    num_proposals: Annotated[
        int | None,
        typer.Option('--proposals', min=1, help='Placements to compare.', show_default=False),
    ] = None,
    physics: Annotated[
        bool,
        typer.Option('--physics', help='Let go what is placed for a second (needs MuJoCo).'),
    ] = False,
    time_budget: Annotated[
        float, typer.Option('--time-budget', min=0.0, help='Seconds; 0 for no limit.')
    ] = 0.0,
    max_steps: Annotated[
        int | None,
        typer.Option('--steps', min=0, help='Of each refinement.', show_default=False),
    ] = None,
    gradient: Annotated[
        str | None,
        typer.Option(
            '--gradient', metavar='NAME', show_default=False,
            help='Of the projection: silhouette, sobel, released, soft or straight_through.',
        ),
    ] = None,
    table_height: Annotated[
        float | None,
        typer.Option(
            '--table-height', show_default=False,
            help='World z of the table, metres; where the test objects stand by default.',
        ),
    ] = None,
    obstacles: ObstaclesOption = None,
    shoulder: ShoulderOption = None,
    reach_min: ReachNearest = None,
    reach_max: ReachFarthest = None,
    approach_height: ApproachOption = None,
    grasp: GraspOption = None,
    seed: SeedOption = 0,
    out: Annotated[
        Path | None,
        typer.Option(
            '--out', metavar='DIR', help='Write pictures and result.json there.',
            show_default=False,
        ),
    ] = None,
    report: Annotated[
        Path | None,
        typer.Option(
            '--report', metavar='HTML', show_default=False,
            help='Write a page to look at: 3-D, steps, checks.',
        ),
    ] = None,
    animation: Annotated[
        Path | None,
        typer.Option(
            '--animation', metavar='FILE', show_default=False,
            help='Write the way to the best answer as .gif, .webp or .mp4.',
        ),
    ] = None,
    recording: RerunOption = None,
    show: Annotated[
        bool, typer.Option('--show', help='Show a picture: in a window, else in the terminal.')
    ] = False,
    json_path: JsonOption = None,
) -> None:  # fmt: skip
    """Imitate the relation of the reference objects with the test objects.

    Scenes are named in a dataset (--data DIR --reference R --test T) or given by model files in
    metres (ply, pcd, obj, stl, off), or names of your own objects, and a JSON file of their poses:
    {"base": {"t": [x,y,z], "q_wxyz": [w,x,y,z]}, "relative": {...}}, z up. Test objects without
    poses stand upright beside each other.

    Exit code 1 when no feasible answer that is similar to the demonstration was found.
    """
    output = Output(json_path)
    check_suffix(report, '--report', REPORT_SUFFIXES)
    check_suffix(animation, '--animation', ANIMATION_SUFFIXES)
    check_recording(recording)
    check_folder(out, '--out')
    if data is not None and reference is None and test is None:
        raise typer.BadParameter('--data goes with --reference or --test, names of scenes in it')
    if memory is not None and remembered is None:
        raise typer.BadParameter('--memory goes with --remembered, a name in it')
    reference_scene = SceneSource(
        'reference', reference, data, reference_base, reference_relative, reference_poses,
        remembered, memory, objects,
    ).load()  # fmt: skip
    test_scene = SceneSource(
        'test', test, data, test_base, test_relative, test_poses, objects=objects
    ).load()  # fmt: skip
    from spatial_relations_ros.imitation import ImitationOptions
    from spatial_relations_ros.learning import load_metric

    options = ImitationOptions(
        movable=ROLES if movable is Movable.BOTH else (movable.value,),
        num_answers=num_answers,
        keep_heading=keep_heading,
        keep_upright=keep_upright,
        keep_on_table=keep_on_table,
        num_proposals=num_proposals or ImitationOptions.num_proposals,
        time_budget_sec=time_budget or None,
        max_steps=ImitationOptions.max_steps if max_steps is None else max_steps,
        table_height=table_height,
        seed=seed,
        **robot_options(
            test_scene, obstacles, grasp, approach_height, shoulder, (reach_min, reach_max)
        ),
    )
    if physics:
        require_mujoco()
    metric = load_metric(weights, gradient=gradient)
    from spatial_relations_ros.evaluation.recorded_steps import StepRecorder

    recorder = StepRecorder()
    result = _run(metric, reference_scene, test_scene, options, recorder)
    _show(output, result, test_scene)
    content = result_entry(result)
    if physics:
        simulations = simulated_answers(result, test_scene, table_height)
        for idx, (answer, entry) in enumerate(
            zip(content['answers'], simulations, strict=True), start=1
        ):
            answer['simulation'] = entry
            output.say(f'answer {idx} {"stays" if entry["stays"] else "moves"} in simulation')
    output.write_json(content)
    if out is not None:
        _write_folder(out, metric, reference_scene, test_scene, result, content, table_height)
        output.say(f'pictures and result.json in [bold]{escape(str(out))}[/]')
    if report is not None or animation is not None or recording is not None:
        shown = shown_imitation(
            metric, reference_scene, test_scene, result,
            steps=recorder.steps, table_height=table_height,
        )  # fmt: skip
        write_shown(output, shown, report, animation)
        if recording is not None:
            record_shown(output, recording, shown, metric)
    if show:
        show_imitation(output, reference_scene, test_scene, result, table_height)
    if not result.success:
        raise typer.Exit(FAILED)


def _run(
    metric: RelationMetric,
    reference: Scene,
    test: Scene,
    options: ImitationOptions,
    recorder: StepRecorder,
) -> ImitationResult:
    from spatial_relations_ros.imitation import imitate as run_imitation

    with progress_bar('steps') as advance:

        def on_progress(progress: ImitationProgress) -> bool:
            recorder.record(progress)
            advance(
                progress.step,
                max(options.max_steps, progress.step),
                f'distance {progress.distance:.3f}',
            )
            return True

        return run_imitation(metric, reference, test, options, on_progress=on_progress)


def result_entry(result: ImitationResult) -> dict[str, Any]:
    """The result as it stands in JSON."""
    from spatial_relations_ros.evaluation.entries import answer_entry

    return {
        'answers': [answer_entry(answer) for answer in result.answers],
        'initial_distance': float(result.initial_distance),
        'duration': float(result.duration_sec),
        'steps': int(result.num_steps),
    }


def _show(output: Output, result: ImitationResult, test: Scene) -> None:
    mark = '[bold green]imitated[/]' if result.success else '[bold red]not imitated[/]'
    output.say(f'{mark}: {escape(result.message)}')
    width = max(len(object_id) for object_id in test.object_ids)
    for idx, answer in enumerate(result.answers, start=1):
        feasible = '[green]feasible[/]' if answer.feasible else '[red]not feasible[/]'
        output.say(f'answer {idx}: distance [bold]{answer.distance:.4f}[/], {feasible}')
        for role, placement in zip(ROLES, answer.placements, strict=True):
            t = ' '.join(f'{value:+.4f}' for value in placement.target.translation)
            q_wxyz = ' '.join(f'{value:+.4f}' for value in placement.target.quat_wxyz)
            label = f'{role:8} {escape(placement.object_id):{width}}'
            output.say(f'  {label}  t {t}  q_wxyz {q_wxyz}')
        for violation in answer.violations:
            output.say(f'  {escape(violation)}')
        if len(answer.order) > 1:
            steps = (
                f'{move.object_id}{"" if move.to_target else " aside"}' for move in answer.order
            )
            output.say(f'  move {escape(", then ".join(steps))}')
    output.say(
        f'distance {result.initial_distance:.4f} before, {result.num_steps} steps, '
        f'{result.duration_sec:.2f} s'
    )


def _write_folder(
    folder: Path,
    metric: RelationMetric,
    reference: Scene,
    test: Scene,
    result: ImitationResult,
    content: Mapping[str, Any],
    table_height: float | None,
) -> None:
    from spatial_relations_ros.cli.output import json_text
    from spatial_relations_ros.core import atomic_write
    from spatial_relations_ros.visualization import (
        answer_sheet,
        draw_projection_gradients,
        write_image,
        write_imitation_pictures,
    )

    write_imitation_pictures(
        folder,
        reference=reference,
        before=test,
        after=result.answers[0].scene(test) if result.answers else test,
        projections=metric.projections,
        distance_history=result.distance_history,
        table_height=table_height,
    )
    found = metric.projection_gradients(reference, test)
    gradients = draw_projection_gradients(
        found.images, found.by_images, found.descent, object_ids=test.object_ids
    )
    write_image(folder / 'test_before_gradients.png', gradients)
    if len(result.answers) > 1:
        captions = [
            f'answer {idx}: {answer.distance:.3f}{"" if answer.feasible else ", not feasible"}'
            for idx, answer in enumerate(result.answers, start=1)
        ]
        scenes = [answer.scene(test) for answer in result.answers]
        sheet = answer_sheet(test, scenes, captions, table_height=table_height)
        write_image(folder / 'answers.png', sheet)
    with atomic_write(folder / 'result.json') as temporary:
        temporary.write_text(json_text(content))
