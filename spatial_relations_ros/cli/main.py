"""The ``relations`` command: its subcommands and its entry point."""

from __future__ import annotations

from typing import Annotated

import typer

from spatial_relations_ros import __version__
from spatial_relations_ros.cli.bench_command import bench
from spatial_relations_ros.cli.dataset_commands import generate
from spatial_relations_ros.cli.embedding_commands import distance, embed
from spatial_relations_ros.cli.error_reports import ReportingGroup
from spatial_relations_ros.cli.generalize_command import generalize
from spatial_relations_ros.cli.imitate_command import imitate
from spatial_relations_ros.cli.learning_commands import train
from spatial_relations_ros.cli.memory_commands import forget, list_relations, nearest, remember
from spatial_relations_ros.cli.objects_commands import objects_app
from spatial_relations_ros.cli.output import JsonOption, Output
from spatial_relations_ros.cli.replay_command import replay
from spatial_relations_ros.cli.retrieve_command import retrieve

app = typer.Typer(
    name='relations',
    cls=ReportingGroup,
    no_args_is_help=True,
    rich_markup_mode='markdown',  # help texts show brackets, which Rich's own markup eats
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


def version(json_path: JsonOption = None) -> None:
    """Show the version of the package and of what it computes with."""
    from spatial_relations_ros.cli.provenance import git_revision, library_versions

    output = Output(json_path)
    content = {
        'version': __version__,
        'git_revision': git_revision(),
        'libraries': library_versions(),
    }
    output.say(f'spatial_relations_ros {__version__}')
    output.table(('library', 'version'), list(library_versions().items()))
    output.write_json(content)


SCENES, MEMORY = 'Scenes', 'Remembered relations'
LEARNING = 'Data, training, evaluation'
app.command(rich_help_panel=SCENES)(imitate)
app.command(rich_help_panel=SCENES)(embed)
app.command(rich_help_panel=SCENES)(distance)
app.command(rich_help_panel=SCENES)(replay)
app.command(rich_help_panel=MEMORY)(remember)
app.command(rich_help_panel=MEMORY)(nearest)
app.command('list', rich_help_panel=MEMORY)(list_relations)
app.command(rich_help_panel=MEMORY)(forget)
app.add_typer(objects_app, rich_help_panel=SCENES)
app.command(rich_help_panel=LEARNING)(generate)
app.command(rich_help_panel=LEARNING)(train)
app.command(rich_help_panel=LEARNING)(retrieve)
app.command(rich_help_panel=LEARNING)(generalize)
app.command(rich_help_panel=LEARNING)(bench)
app.command(rich_help_panel=LEARNING)(version)


def main() -> None:
    """Entry point of the ``relations`` executable."""
    app(prog_name='relations')


if __name__ == '__main__':
    main()
