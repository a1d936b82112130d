"""``relations generalize``: announced, not built yet."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from spatial_relations_ros.cli.error_reports import FAILED
from spatial_relations_ros.cli.output import JsonOption, Output


def generalize(
    folder: Annotated[Path, typer.Argument(metavar='DIR', help='Dataset folder.')],
    json_path: JsonOption = None,
) -> None:
    """The paper's two generalisation experiments (not built yet)."""
    Output(json_path)
    typer.echo(
        f'relations generalize is not built yet: nothing was measured on {folder} and nothing '
        'was written; relations imitate runs single pairs of its scenes',
        err=True,
    )
    raise typer.Exit(FAILED)
