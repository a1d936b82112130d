"""Starts the package's nodes as processes of their own and always ends them."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType

from spatial_relations_ros.core import (
    ConfigError,
    SpatialRelationsError,
    executable_path,
    share_path,
)
from spatial_relations_ros.core.interrupts import interrupts_held

# A node needs 3 s; a busy machine many times that.
STOP_TIMEOUT_SEC = 60.0
_PROFILE = 'FASTRTPS_DEFAULT_PROFILES_FILE'
TAIL_LINES = 15


class NodeProcessError(SpatialRelationsError):
    """A node that cannot be started or has ended on its own."""


def find_executable(name: str) -> Path:
    """The executable that ``ros2 run spatial_relations_ros NAME`` starts.

    Raises:
        NodeProcessError: when the package is not installed.
    """
    try:
        return executable_path(name)
    except ConfigError as error:
        raise NodeProcessError(str(error)) from error


def local_graph(domain_id: int, log_folder: Path) -> dict[str, str]:
    """Environment of a graph on this machine alone, fit for who publishes large clouds.

    Args:
        domain_id: ROS_DOMAIN_ID.
        log_folder: where rclpy writes its logs.
    """
    return {
        'ROS_DOMAIN_ID': str(domain_id),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'ROS_LOG_DIR': str(log_folder),
        _PROFILE: str(share_path('config', 'fastdds_large_clouds.xml')),
    }


class NodeProcesses:
    """Node processes, ended together when the ``with`` block is left.

    Args:
        environment: variables added to this process's own. Nodes publish no large clouds: they get
            the profile with less shared memory, whatever it says.
        log_folder: gets one file a node with all that it prints.
    """

    def __init__(self, environment: Mapping[str, str], log_folder: Path) -> None:
        self._environment = {
            **os.environ,
            'PYTHONUNBUFFERED': '1',
            **environment,
            _PROFILE: str(share_path('config', 'fastdds_nodes.xml')),
        }
        self._log_folder = log_folder
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        log_folder.mkdir(parents=True, exist_ok=True)

    def start(
        self, executable: str, *, parameters: Mapping[str, object] | None = None,
        remappings: Mapping[str, str] | None = None, arguments: Sequence[str] = (),
        name: str = '',
    ) -> subprocess.Popen[bytes]:  # fmt: skip
        """Starts a node.

        Args:
            executable: its name.
            parameters: values as on the command line.
            remappings: from -> to.
            arguments: further ``--ros-args``.
            name: of the process here, for several of one executable; else the executable's.

        Raises:
            NodeProcessError: when it is not installed.
        """
        name = name or executable
        command = [str(find_executable(executable)), '--ros-args']
        for parameter, value in (parameters or {}).items():
            command += ['-p', f'{parameter}:={_as_yaml(value)}']
        for source, target in (remappings or {}).items():
            command += ['-r', f'{source}:={target}']
        with open(self.log_path(name), 'ab') as log, interrupts_held():
            process = self._processes[name] = subprocess.Popen(
                [*command, *arguments],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                env=self._environment,
                # Ctrl-C reaches this process only; it ends the nodes in order.
                start_new_session=True,
            )
        return process

    def process(self, name: str) -> subprocess.Popen[bytes]:
        """The process of a node that was started."""
        return self._processes[name]

    def end(self, name: str, number: signal.Signals = signal.SIGINT) -> int:
        """Ends one node by a signal and waits for it; gives its exit code.

        Raises:
            subprocess.TimeoutExpired: when the signal does not end it.
        """
        process = self._processes.pop(name)
        _send(process, number)
        return process.wait(STOP_TIMEOUT_SEC)

    def log_path(self, name: str) -> Path:
        """What a node printed; when it was started again, all that it printed."""
        return self._log_folder / f'{name}.log'

    def check(self) -> None:
        """Makes sure that all nodes run.

        Raises:
            NodeProcessError: when one has ended; with its last lines.
        """
        for name, process in self._processes.items():
            if process.poll() is not None:
                lines = self.log_path(name).read_text(errors='replace').splitlines()
                tail = '\n  '.join(lines[-TAIL_LINES:])
                raise NodeProcessError(f'{name} ended with code {process.returncode}:\n  {tail}')

    def stop(self) -> dict[str, int]:
        """Interrupts all nodes, kills those that do not end; gives their exit codes."""
        codes = {}
        with interrupts_held():
            for process in self._processes.values():
                _send(process, signal.SIGINT)
            for name, process in self._processes.items():
                try:
                    codes[name] = process.wait(STOP_TIMEOUT_SEC)
                except subprocess.TimeoutExpired:
                    _send(process, signal.SIGKILL)
                    codes[name] = process.wait()
            self._processes.clear()
        return codes

    def __enter__(self) -> NodeProcesses:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.stop()


def _as_yaml(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f"'{value}'"
    if isinstance(value, (list, tuple)):
        return f'[{", ".join(_as_yaml(item) for item in value)}]'
    return str(value)


def _send(process: subprocess.Popen[bytes], number: signal.Signals) -> None:
    with contextlib.suppress(ProcessLookupError):
        os.killpg(process.pid, number)
