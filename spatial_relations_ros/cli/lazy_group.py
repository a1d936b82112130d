"""Commands whose modules are imported when they are asked for, not before."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import import_module
from typing import Any, Literal

import typer
from typer.core import TyperCommand, TyperGroup

# Help texts show brackets, which Rich's own markup eats.
MARKUP: Literal['markdown'] = 'markdown'


@dataclass(frozen=True)
class CommandEntry:
    """What is known of a command before its module is loaded.

    Attributes:
        name: what the user types.
        panel: heading that it is listed under.
        summary: the first line of its help.
        target: ``module:attribute``, a function or a Typer application.
    """

    name: str
    panel: str
    summary: str
    target: str

    def listed(self) -> TyperCommand:
        """A command that can be listed, but not run."""
        return TyperCommand(self.name, help=self.summary, rich_help_panel=self.panel)

    def load(self) -> Any:
        """The command itself: a click command, whose type has moved between Typer's releases."""
        module, _, attribute = self.target.partition(':')
        target = getattr(import_module(module), attribute)
        if not isinstance(target, typer.Typer):
            function, target = target, typer.Typer(add_completion=False, rich_markup_mode=MARKUP)
            target.command(self.name)(function)
        command = typer.main.get_command(target)
        command.name = self.name
        return command


class LazyGroup(TyperGroup):
    """A group that lists its commands from a table, and loads one to run or complete it.

    Subclasses set ``entries``; their order is that of the help.
    """

    entries: tuple[CommandEntry, ...] = ()

    def __init__(self, **settings: Any) -> None:
        super().__init__(**settings)
        self.commands = {entry.name: entry.listed() for entry in self.entries}

    def resolve_command(self, ctx: Any, args: list[str]) -> tuple[Any, Any, list[str]]:
        """Finds the command that the arguments begin with; it is loaded here."""
        name, listed, rest = super().resolve_command(ctx, args)
        return name, listed and self.load(listed.name), rest

    def load(self, name: str | None) -> Any:
        """The command itself.

        Raises:
            KeyError: when there is none of that name.
        """
        return {entry.name: entry for entry in self.entries}[str(name)].load()

    def load_all(self) -> dict[str, Any]:
        """All commands by name; those of groups by both words, such as ``objects add``."""
        loaded: dict[str, Any] = {}
        for entry in self.entries:
            command = entry.load()
            if isinstance(command, TyperGroup):
                if command.invoke_without_command:
                    loaded[entry.name] = command
                loaded |= {f'{entry.name} {name}': sub for name, sub in command.commands.items()}
            else:
                loaded[entry.name] = command
        return loaded
