"""Errors of a command, in words; exit codes."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import typer
from rich.console import Console
from rich.markup import escape
from typer.core import TyperGroup

OK, FAILED, BAD_INPUT = 0, 1, 2
DEBUG_FLAG = '--debug'
# What is wrong with the run or the machine; every other named error is wrong with the input.
RUN_ERRORS = ('ImitationError', 'MemoryFileError')


class ReportingGroup(TyperGroup):
    """Commands whose named errors end with a sentence and an exit code, not with a traceback.

    The context's type has moved between releases of Typer, hence ``Any``.
    """

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Takes ``--debug`` from wherever it stands."""
        if DEBUG_FLAG in args:
            args = [DEBUG_FLAG, *(arg for arg in args if arg != DEBUG_FLAG)]
        return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> object:
        """Runs the command and reports what goes wrong."""
        debug = bool(ctx.params.get('debug'))
        with _spoken_warnings():
            try:
                return super().invoke(ctx)
            except KeyboardInterrupt:
                _say('stopped', 'yellow')
                raise typer.Exit(130) from None
            except BrokenPipeError:
                raise
            except OSError as error:
                if debug:
                    raise
                _report(error, str(error))
                raise typer.Exit(FAILED) from None
            except Exception as error:
                code = exit_code(error)
                if debug or code is None:
                    raise
                _report(error, str(error))
                raise typer.Exit(code) from None


def exit_code(error: Exception) -> int | None:
    """The exit code of a named error; None for any other, which is a bug of ours."""
    # A named error can only come from a command that has imported them; loading them here would
    # cost every other command a second.
    errors = sys.modules.get('spatial_relations_ros.core.errors')
    if errors is None or not isinstance(error, errors.SpatialRelationsError):
        return None
    return FAILED if type(error).__name__ in RUN_ERRORS else BAD_INPUT


def _report(error: Exception, message: str) -> None:
    _say(message or type(error).__name__, 'red', title='error')


def _say(message: str, colour: str, *, title: str = '') -> None:
    head = f'[bold {colour}]{title}:[/] ' if title else ''
    Console(stderr=True, soft_wrap=True, highlight=False).print(f'{head}{escape(message)}')


@contextmanager
def _spoken_warnings() -> Iterator[None]:
    """Our own warnings as one line each; those of libraries are not the user's business."""
    with warnings.catch_warnings():
        warnings.simplefilter('ignore')
        warnings.filterwarnings('default', module='spatial_relations_ros')
        warnings.showwarning = lambda message, *_, **__: _say(
            str(message), 'yellow', title='warning'
        )
        yield
