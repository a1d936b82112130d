"""``relations retrieve``."""

from __future__ import annotations

import math
from collections.abc import Sequence
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape

from spatial_relations_ros.cli.options import SeedOption
from spatial_relations_ros.cli.output import (
    JsonOption,
    Output,
    check_file,
    check_folder,
    progress_bar,
)

if TYPE_CHECKING:
    from spatial_relations_ros.evaluation.comparison import ComparedMetric
    from spatial_relations_ros.evaluation.labelled_scenes import LabelledScenes


class Protocol(StrEnum):
    """Which splits retrieval runs over."""

    SCENE = 'scene'
    OBJECT = 'object'
    BOTH = 'both'


class Baselines(StrEnum):
    """What runs beside the weights."""

    NONE = 'none'
    FEATURES = 'features'
    ALL = 'all'


def retrieve(
    folder: Annotated[Path, typer.Argument(metavar='DIR', help='Dataset folder.')],
    protocol: Annotated[
        Protocol, typer.Option('--protocol', help='Splits over scenes, over objects, or both.')
    ] = Protocol.BOTH,
    weights: Annotated[
        list[Path] | None,
        typer.Option(
            '--weights', metavar='FILE', show_default=False,
            help='Weights (safetensors) instead of the shipped ones; give it several times to '
            'compare.',
        ),
    ] = None,
    baselines: Annotated[
        Baselines,
        typer.Option(
            '--baselines',
            help='Hand-made features (Mees 2017) on the same splits: none; features, Euclidean; '
            'all, also under LMNN fitted to each split.',
        ),
    ] = Baselines.ALL,
    pose_error_deg: Annotated[
        float,
        typer.Option(
            '--pose-error', metavar='DEG', min=0.0, max=45.0,
            help='Turn each object at random first, with this standard deviation about each axis, '
            'and shift it to match, as a tracker errs; human-made scenes have 3.',
        ),
    ] = 0.0,
    markdown: Annotated[
        Path | None,
        typer.Option(
            '--markdown', metavar='OUT', show_default=False, help='Write the table as Markdown.'
        ),
    ] = None,
    pictures: Annotated[
        Path | None,
        typer.Option(
            '--pictures', metavar='DIR', show_default=False,
            help='Write maps, confusion matrices and nearest neighbours as PNG.',
        ),
    ] = None,
    seed: SeedOption = 0,
    json_path: JsonOption = None,
) -> None:  # fmt: skip
    """Measure retrieval over the splits of a dataset: 3-of-5 and 5-of-5 nearest scenes.

    The weights are used as they are. Numbers mean something only on scenes that they were not
    trained with; object splits ask for scenes of objects that are not in the gallery.
    """
    from spatial_relations_ros.cli.provenance import provenance
    from spatial_relations_ros.cli.scene_sources import read_dataset
    from spatial_relations_ros.evaluation.comparison import (
        calibration_entries,
        protocols_of,
        seed_groups,
    )
    from spatial_relations_ros.evaluation.held_out import describe_data
    from spatial_relations_ros.evaluation.labelled_scenes import LabelledScenes
    from spatial_relations_ros.evaluation.retrieval_tables import markdown_table, table_rows

    output = Output(json_path)
    check_file(markdown, '--markdown')
    check_folder(pictures, '--pictures')
    dataset = read_dataset(folder)
    data = describe_data(folder, dataset)
    if pose_error_deg > 0.0:
        from spatial_relations_ros.evaluation.pose_errors import with_pose_errors

        dataset = with_pose_errors(dataset, math.radians(pose_error_deg), seed=seed)
    scenes = LabelledScenes.of(dataset)
    protocols = protocols_of(dataset, protocol.value)
    compared = _compare(scenes, protocols, weights or [], baselines)
    calibrations = calibration_entries(
        compared,
        scenes,
        # Scenes with other poses are other data than the calibration was fitted on.
        scenes_sha256='' if pose_error_deg > 0.0 else data['scenes_sha256'],
        seed=seed,
    )
    groups = seed_groups(compared)
    is_trained_on = _trained_on(output, compared, data['scenes_sha256'])
    output.table(*table_rows(compared, groups))
    _say_calibrations(output, calibrations)
    if markdown is not None:
        from spatial_relations_ros.core import atomic_write

        with atomic_write(markdown) as temporary:
            temporary.write_text(markdown_table(compared, groups))
    paths = _draw(pictures, compared, scenes, seed) if pictures is not None else []
    output.write_json(
        {
            'protocols': compared[0].protocols(),
            'model_hash': compared[0].about['model_hash'],
            'metrics': [
                {
                    **item.entry(),
                    'trained_on_this_data': item.name in is_trained_on,
                    'calibration': calibrations.get(item.name),
                }
                for item in compared
            ],
            'seeds': groups,
            'pictures': [str(path) for path in paths],
            'data': data,
            'pose_error_deg': pose_error_deg,
            'seed': seed,
            'provenance': provenance(),
        }
    )


def _compare(
    scenes: LabelledScenes,
    protocols: Sequence[str],
    weights: Sequence[Path],
    baselines: Baselines,
) -> list[ComparedMetric]:
    """The weights in the order given, then the baselines."""
    from spatial_relations_ros.evaluation.baselines import EUCLIDEAN, LMNN, compare_baselines
    from spatial_relations_ros.evaluation.comparison import compare_metric
    from spatial_relations_ros.learning import load_metric

    compared = []
    for name, path in _named(weights):
        metric = load_metric(path)
        with progress_bar(f'{name}: scenes embedded') as advance:
            compared.append(
                compare_metric(name, metric, scenes, protocols, weights=path, on_progress=advance)
            )
    names = {
        Baselines.NONE: (),
        Baselines.FEATURES: (EUCLIDEAN,),
        Baselines.ALL: (EUCLIDEAN, LMNN),
    }
    with progress_bar('baselines') as advance:
        compared += compare_baselines(names[baselines], scenes, protocols, on_progress=advance)
    return compared


def _trained_on(
    output: Output, compared: Sequence[ComparedMetric], scenes_sha256: str
) -> set[str]:
    """Names of the metrics that were trained with scenes of this data, which is said."""
    from spatial_relations_ros.evaluation.comparison import trained_on

    names = set()
    for item in compared:
        if item.metric is not None and trained_on(item.metric, scenes_sha256):
            names.add(item.name)
            split = item.metric.card.retrieval.get('split')
            but = f', but for those of {split}' if split else ''
            output.say(
                f'[bold]{escape(item.name)} was trained with scenes of this data[/]: '
                f'its numbers flatter it{but}'
            )
    return names


def _named(weights: Sequence[Path]) -> list[tuple[str, Path | None]]:
    """A short name that is not used twice for each file."""
    if not weights:
        return [('shipped', None)]
    stems = [path.stem for path in weights]
    if len(set(stems)) < len(stems):
        stems = [str(path) for path in weights]
    if len(set(stems)) < len(stems):
        raise typer.BadParameter('--weights names the same file twice')
    return list(zip(stems, weights, strict=True))


def _draw(
    folder: Path, compared: Sequence[ComparedMetric], scenes: LabelledScenes, seed: int
) -> list[Path]:
    from spatial_relations_ros.evaluation.retrieval_pictures import write_retrieval_pictures

    with progress_bar('scenes drawn') as advance:
        return write_retrieval_pictures(folder, compared, scenes, seed=seed, on_picture=advance)


def _say_calibrations(output: Output, calibrations: dict[str, dict[str, Any]]) -> None:
    for name, entry in calibrations.items():
        novelty, reliability = entry['novelty'], entry['reliability']
        where = 'the data it was fitted on' if entry['fitted_on_this_data'] else 'other data'
        found = ', '.join(
            f'{kind.replace("_", " ")} {100.0 * share:.0f} %'
            for kind, share in novelty['detected_at_1_percent'].items()
        )
        error = (
            f'calibration error {100.0 * reliability["expected_calibration_error"]:.1f} % '
            f'on {where}; '
            if reliability
            else ''
        )
        output.say(
            f'{name}: same relation below {entry["same_relation_distance"]:.3f}; {error}'
            f'{100.0 * novelty["false_alarms"]:.1f} % of the scenes called novel; nonsense '
            f'detected at 1 % false alarms: {found}'
        )
