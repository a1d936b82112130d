"""Options that several commands share."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

DataOption = Annotated[
    Path | None,
    typer.Option(
        '--data', metavar='DIR', help='Dataset folder that scene names refer to.',
        show_default=False,
    ),
]  # fmt: skip
WeightsOption = Annotated[
    Path | None,
    typer.Option(
        '--weights', metavar='FILE', help='Weights (safetensors) instead of the shipped ones.',
        show_default=False,
    ),
]  # fmt: skip
MemoryOption = Annotated[
    Path | None,
    typer.Option(
        '--memory', metavar='FILE', show_default=False,
        help='File of remembered relations; below XDG_DATA_HOME by default.',
    ),
]  # fmt: skip
ObjectsOption = Annotated[
    Path | None,
    typer.Option(
        '--objects', metavar='DIR', show_default=False,
        help='Folder of your own objects; below XDG_DATA_HOME by default.',
    ),
]  # fmt: skip
SeedOption = Annotated[
    int, typer.Option('--seed', min=0, max=2**32 - 1, help='Of everything random.')
]


def name_option(*names: str, role: str) -> object:
    """An option that names a scene of a dataset."""
    return typer.Option(
        *names, metavar='NAME', help=f'Scene of the dataset: the {role}.', show_default=False
    )


def file_option(*names: str, what: str) -> object:
    """An option that takes a file."""
    return typer.Option(*names, metavar='FILE', help=what, show_default=False)


ReferenceName = Annotated[str | None, name_option('--reference', role='demonstration')]
ReferenceBase = Annotated[
    Path | None, file_option('--reference-base', what='Model of the reference base, or its name.')
]
ReferenceRelative = Annotated[
    Path | None,
    file_option('--reference-relative', what='Model of the reference relative, or its name.'),
]
ReferencePoses = Annotated[
    Path | None, file_option('--reference-poses', what='JSON of both reference poses.')
]
TestName = Annotated[str | None, name_option('--test', role='objects to place')]
TestBase = Annotated[
    Path | None, file_option('--test-base', what='Model of the test base, or its name.')
]
TestRelative = Annotated[
    Path | None, file_option('--test-relative', what='Model of the test relative, or its name.')
]
TestPoses = Annotated[
    Path | None,
    file_option(
        '--test-poses', what='JSON of both test poses; upright beside each other without it.'
    ),
]
RememberedName = Annotated[
    str | None,
    typer.Option(
        '--remembered', metavar='NAME', show_default=False,
        help='A remembered relation as the reference.',
    ),
]  # fmt: skip

SceneName = Annotated[str | None, name_option('--scene', '--reference', role='scene')]
SceneBase = Annotated[
    Path | None, file_option('--base', '--reference-base', what='Model of the base, or its name.')
]
SceneRelative = Annotated[
    Path | None,
    file_option('--relative', '--reference-relative', what='Model of the relative, or its name.'),
]
ScenePoses = Annotated[
    Path | None, file_option('--poses', '--reference-poses', what='JSON of both poses.')
]
