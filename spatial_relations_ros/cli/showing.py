"""``--show``: the picture of an imitation, in a window or in the terminal."""

from __future__ import annotations

import os
import platform
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from rich.markup import escape

from spatial_relations_ros.cli.output import Output

if TYPE_CHECKING:
    from spatial_relations_ros.core import Scene
    from spatial_relations_ros.imitation import ImitationResult


def show_imitation(
    output: Output,
    reference: Scene,
    test: Scene,
    result: ImitationResult,
    table_height: float | None,
) -> None:
    """Opens the overview (demonstration, before, after) where there is a display.

    Without one it is drawn with coloured half blocks in a terminal; where text goes to a file, the
    path of the picture is all that is told.
    """
    from spatial_relations_ros.visualization import before_after, terminal_picture, write_image

    after = result.answers[0].scene(test) if result.answers else test
    picture = before_after(reference, test, after, table_height=table_height)
    path = Path(tempfile.mkdtemp(prefix='relations-')) / 'overview.png'
    write_image(path, picture)
    if has_display():
        typer.launch(str(path))
    elif sys.stdout.isatty():
        columns = os.get_terminal_size().columns
        typer.echo(terminal_picture(picture, columns=columns))
    output.say(f'picture: [bold]{escape(str(path))}[/]')


def has_display() -> bool:
    """Whether a window can be opened here."""
    if platform.system() == 'Linux':
        return bool(os.environ.get('DISPLAY') or os.environ.get('WAYLAND_DISPLAY'))
    return True
