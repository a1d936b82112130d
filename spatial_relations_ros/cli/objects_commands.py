"""``relations objects``: a person's own objects."""

from __future__ import annotations

import dataclasses
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.markup import escape

from spatial_relations_ros.cli.options import ObjectsOption
from spatial_relations_ros.cli.output import JsonOption, Output

if TYPE_CHECKING:
    from spatial_relations_ros.datasets.own_objects import ObjectCard, OwnObjects, PreparedObject

objects_app = typer.Typer(
    name='objects',
    no_args_is_help=True,
    rich_markup_mode='markdown',
    help='Your own objects: make meshes and clouds fit for use, keep them under names.',
)

NameArgument = Annotated[str, typer.Argument(metavar='NAME', help='Name of the object.')]


class UpAxis(StrEnum):
    """Axis of a model file that points up; as ``own_objects.UP_AXES``, loaded without it."""

    Z = 'z'
    MINUS_Z = '-z'
    Y = 'y'
    MINUS_Y = '-y'
    X = 'x'
    MINUS_X = '-x'


@objects_app.command()
def add(
    file: Annotated[
        Path, typer.Argument(metavar='FILE', help='Mesh or cloud: ply, pcd, obj, stl, off.')
    ],
    name: Annotated[
        str | None,
        typer.Option('--name', help="Object id; the file's name by default.", show_default=False),
    ] = None,
    scale: Annotated[
        float | None,
        typer.Option(
            '--scale', show_default=False, help='Factor to metres, such as 0.001 for millimetres.'
        ),
    ] = None,
    size: Annotated[
        float | None,
        typer.Option(
            '--size', metavar='METRES', show_default=False,
            help='Instead of --scale: how long the largest side is.',
        ),
    ] = None,
    up: Annotated[UpAxis, typer.Option('--up', help='Axis of the file that points up.')]
    = UpAxis.Z,
    replace: Annotated[
        bool, typer.Option('--replace', help='Replace an object of that name.')
    ] = False,
    preview: Annotated[bool, typer.Option(help='Draw a picture of it.')] = True,
    objects: ObjectsOption = None,
    json_path: JsonOption = None,
) -> None:  # fmt: skip
    """Add a model file: its units are checked, its mesh is made watertight, a picture is drawn.

    Afterwards NAME stands for it wherever a command takes a model file, and the folder can be
    the perception node's models_path.
    """
    output = Output(json_path)
    from spatial_relations_ros.datasets.own_objects import OwnObjects, prepare_object

    prepared = prepare_object(file, name=name, scale=scale, size=size, up=up.value)
    library = OwnObjects(objects)
    path = library.add(prepared, replace=replace)
    card = prepared.card
    if preview:
        _write_preview(library, prepared)
    output.say(f'[bold]{card.name}[/]: {_measures(card)}')
    output.say(f'  {_origin(card)}')
    output.say(f'  stored as {escape(str(path))}')
    if preview:
        output.say(f'  picture: {escape(str(library.preview_path(card.name)))}')
    output.write_json(_entry(library, card))


@objects_app.command('list')
def list_objects(objects: ObjectsOption = None, json_path: JsonOption = None) -> None:
    """List your objects."""
    output = Output(json_path)
    from spatial_relations_ros.datasets.own_objects import OwnObjects

    library = OwnObjects(objects)
    cards = [library.card(name) for name in library.names()]
    noun = 'object' if len(cards) == 1 else 'objects'
    output.say(f'{len(cards)} {noun} in {escape(str(library.folder))}')
    if cards:
        output.table(
            ('name', 'size, cm', 'volume, cm3', 'triangles', 'made from'),
            [
                (
                    card.name, _size(card), round(card.volume * 1e6, 1), card.num_triangles,
                    f'{card.source} ({card.made_from})',
                )
                for card in cards
            ],
        )  # fmt: skip
    output.write_json(
        {'folder': str(library.folder), 'objects': [_entry(library, card) for card in cards]}
    )


@objects_app.command()
def show(
    name: NameArgument,
    objects: ObjectsOption = None,
    json_path: JsonOption = None,
) -> None:
    """Show what is known of an object."""
    output = Output(json_path)
    from spatial_relations_ros.datasets.own_objects import OwnObjects

    library = OwnObjects(objects)
    card = library.card(name)
    output.say(f'[bold]{card.name}[/]: {_measures(card)}')
    output.say(f'  {_origin(card)}')
    for path in (library.mesh_path(name), library.preview_path(name)):
        if path.is_file():
            output.say(f'  {escape(str(path))}')
    output.write_json(_entry(library, card))


def _write_preview(library: OwnObjects, prepared: PreparedObject) -> None:
    from spatial_relations_ros.core import Pose, SceneObject
    from spatial_relations_ros.visualization import render_scene, write_image

    name = prepared.card.name
    item = SceneObject(name, prepared.mesh.vertices, Pose(), mesh=prepared.mesh)
    write_image(library.preview_path(name), render_scene([item], width=480, height=360))


def _entry(library: OwnObjects, card: ObjectCard) -> dict[str, Any]:
    preview = library.preview_path(card.name)
    return {
        **dataclasses.asdict(card),
        'path': str(library.mesh_path(card.name)),
        'preview': str(preview) if preview.is_file() else None,
    }


def _size(card: ObjectCard) -> str:
    return ' x '.join(f'{100.0 * length:.1f}' for length in card.size)


def _measures(card: ObjectCard) -> str:
    return f'{_size(card)} cm, {card.volume * 1e6:.1f} cm3, {card.num_triangles} triangles'


def _origin(card: ObjectCard) -> str:
    words = {
        'mesh': 'watertight as it is',
        'repaired mesh': 'made watertight',
        'cloud': 'a solid made of a cloud',
    }
    return (
        f'from {escape(card.source)}, scale {card.scale:g}, {card.up} up; {words[card.made_from]}'
    )
