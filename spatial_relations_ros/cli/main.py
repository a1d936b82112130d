"""The ``relations`` command: its subcommands and its entry point."""

from __future__ import annotations

from typing import Annotated

import typer

from spatial_relations_ros.cli.error_reports import ReportingGroup
from spatial_relations_ros.cli.lazy_group import MARKUP, CommandEntry, LazyGroup

SCENES, MEMORY = 'Scenes', 'Remembered relations'
LEARNING = 'Data, training, evaluation'
_CLI = 'spatial_relations_ros.cli'


class Relations(ReportingGroup, LazyGroup):
    """The subcommands; summaries are those of their help, as a test compares."""

    entries = (
        CommandEntry(
            'imitate', SCENES,
            'Imitate the relation of the reference objects with the test objects.',
            f'{_CLI}.imitate_command:imitate',
        ),
        CommandEntry(
            'embed', SCENES, 'Embed a scene: where the metric places its relation.',
            f'{_CLI}.embedding_commands:embed',
        ),
        CommandEntry(
            'distance', SCENES,
            'Distance of two scenes under the metric, small for like relations, and what it '
            'means.',
            f'{_CLI}.embedding_commands:distance',
        ),
        CommandEntry(
            'replay', SCENES, 'Replay bags through perception, and imitate what they show.',
            f'{_CLI}.replay_command:replay',
        ),
        CommandEntry(
            'objects', SCENES,
            'Your own objects: make meshes and clouds fit for use, keep them under names.',
            f'{_CLI}.objects_commands:objects_app',
        ),
        CommandEntry(
            'remember', MEMORY,
            "Remember a scene's relation under a name; a name that is taken is refused.",
            f'{_CLI}.memory_commands:remember',
        ),
        CommandEntry(
            'nearest', MEMORY, "The remembered relations that are most like a scene's.",
            f'{_CLI}.memory_commands:nearest',
        ),
        CommandEntry(
            'list', MEMORY, 'List the remembered relations.',
            f'{_CLI}.memory_commands:list_relations',
        ),
        CommandEntry(
            'forget', MEMORY, 'Forget a remembered relation.', f'{_CLI}.memory_commands:forget'
        ),
        CommandEntry(
            'generate', LEARNING, "Generate a synthetic dataset in the paper's folder format.",
            f'{_CLI}.dataset_commands:generate',
        ),
        CommandEntry(
            'train', LEARNING, 'Train a metric on a dataset; weights and their card are written.',
            f'{_CLI}.learning_commands:train',
        ),
        CommandEntry(
            'retrieve', LEARNING,
            'Measure retrieval over the splits of a dataset: 3-of-5 and 5-of-5 nearest scenes.',
            f'{_CLI}.retrieve_command:retrieve',
        ),
        CommandEntry(
            'generalize', LEARNING,
            'Measure how relations generalise to other objects, judged by geometry and '
            'simulation.',
            f'{_CLI}.generalize_command:generalize',
        ),
        CommandEntry(
            'bench', LEARNING,
            'Time the steps on this machine: medians and spread after a warm-up.',
            f'{_CLI}.bench_command:bench_app',
        ),
        CommandEntry(
            'version', LEARNING,
            'Show the version of the package and of what it computes with.',
            f'{_CLI}.version_command:version',
        ),
    )  # fmt: skip


app = typer.Typer(
    name='relations',
    cls=Relations,
    no_args_is_help=True,
    rich_markup_mode=MARKUP,
    pretty_exceptions_enable=False,
    context_settings={'help_option_names': ['-h', '--help']},
)


@app.callback()
def relations(
    debug: Annotated[bool, typer.Option('--debug', help='Show the traceback of errors.')] = False,
) -> None:
    """Imitate spatial relations between objects, offline: no ROS graph is needed.

    Exit codes: 0 done, 1 ran but failed, 2 bad input.
    """


def main() -> None:
    """Entry point of the ``relations`` executable."""
    app(prog_name='relations')


if __name__ == '__main__':
    main()
