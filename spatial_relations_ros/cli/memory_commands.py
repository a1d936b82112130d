"""``relations remember``, ``nearest``, ``list`` and ``forget``."""

from __future__ import annotations

import dataclasses
import time
from pathlib import Path
from typing import Annotated

import typer
from rich.markup import escape

from spatial_relations_ros.cli.options import (
    DataOption,
    MemoryOption,
    ObjectsOption,
    SceneBase,
    SceneName,
    ScenePoses,
    SceneRelative,
    WeightsOption,
)
from spatial_relations_ros.cli.output import JsonOption, Output
from spatial_relations_ros.cli.scene_sources import SceneSource

NameArgument = Annotated[str, typer.Argument(metavar='NAME', help='Name of the relation.')]


def remember(
    name: NameArgument,
    scene: SceneName = None,
    data: DataOption = None,
    base: SceneBase = None,
    relative: SceneRelative = None,
    poses: ScenePoses = None,
    objects: ObjectsOption = None,
    replace: Annotated[
        bool, typer.Option('--replace', help='Replace a relation of that name.')
    ] = False,
    memory: MemoryOption = None,
    weights: WeightsOption = None,
    json_path: JsonOption = None,
) -> None:
    """Remember a scene's relation under a name; a name that is taken is refused."""
    output = Output(json_path)
    loaded = SceneSource('', scene, data, base, relative, poses, objects=objects).load()
    from spatial_relations_ros.learning import load_metric
    from spatial_relations_ros.memory import RelationMemory

    if loaded.stamp_ns == 0:
        loaded = dataclasses.replace(loaded, stamp_ns=time.time_ns())
    metric = load_metric(weights)
    embedding = metric.embed_scenes([loaded])[0]
    with RelationMemory(memory) as store:
        store.remember(name, loaded, embedding, metric.model_hash, replace=replace)
        output.say(f'remembered [bold]{escape(name)}[/] in {escape(str(store.path))}')
        output.write_json({'name': name, 'memory': str(store.path)})


def nearest(
    scene: SceneName = None,
    data: DataOption = None,
    base: SceneBase = None,
    relative: SceneRelative = None,
    poses: ScenePoses = None,
    objects: ObjectsOption = None,
    k: Annotated[int, typer.Option('-k', '--count', min=1, help='At most so many.')] = 5,
    memory: MemoryOption = None,
    weights: WeightsOption = None,
    json_path: JsonOption = None,
) -> None:
    """The remembered relations that are most like a scene's."""
    output = Output(json_path)
    _check_there(memory)
    loaded = SceneSource('', scene, data, base, relative, poses, objects=objects).load()
    from spatial_relations_ros.learning import load_metric
    from spatial_relations_ros.memory import RelationMemory

    metric = load_metric(weights)
    with RelationMemory(memory) as store:
        neighbours = store.nearest(
            metric.embed_scenes([loaded])[0], k, metric.model_hash, embed=metric.embed_scenes
        )
    output.table(('relation', 'distance'), [(item.name, item.distance) for item in neighbours])
    output.write_json(
        {
            'neighbours': [dataclasses.asdict(item) for item in neighbours],
            'model_hash': metric.model_hash,
        }
    )


def list_relations(memory: MemoryOption = None, json_path: JsonOption = None) -> None:
    """List the remembered relations."""
    from spatial_relations_ros.memory import RelationMemory

    output = Output(json_path)
    _check_there(memory)
    with RelationMemory(memory) as store:
        relations = store.list()
        noun = 'relation' if len(relations) == 1 else 'relations'
        output.say(f'{len(relations)} {noun} in {escape(str(store.path))}')
    output.table(
        ('name', 'base', 'relative', 'model'),
        [(item.name, item.base_id, item.relative_id, item.model_hash[:12]) for item in relations],
    )
    output.write_json({'relations': [dataclasses.asdict(item) for item in relations]})


def forget(name: NameArgument, memory: MemoryOption = None, json_path: JsonOption = None) -> None:
    """Forget a remembered relation."""
    from spatial_relations_ros.memory import RelationMemory

    output = Output(json_path)
    _check_there(memory)
    with RelationMemory(memory) as store:
        store.forget(name)
    output.say(f'forgot [bold]{escape(name)}[/]')
    output.write_json({'name': name})


def _check_there(memory: Path | None) -> None:
    """Refuses a mistyped file, which would be made anew, of commands that only look into it."""
    if memory is not None and not memory.is_file():
        raise typer.BadParameter(f'--memory: there is no file {memory}')
