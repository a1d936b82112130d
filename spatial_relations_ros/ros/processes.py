"""Starts the package's nodes as processes of their own and always ends them."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import TracebackType

from spatial_relations_ros.core import SpatialRelationsError, share_path
from spatial_relations_ros.core.share import PACKAGE_NAME

# A node needs 3 s; a busy machine many times that.
STOP_TIMEOUT_SEC = 60.0
TAIL_LINES = 15


class NodeProcessError(SpatialRelationsError):
    """A node that cannot be started or has ended on its own."""


def find_executable(name: str) -> Path:
    """The executable that ``ros2 run spatial_relations_ros NAME`` starts.

    Raises:
        NodeProcessError: when the package is not installed.
    """
    prefixes = [sys.prefix, *os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)]
    paths = [Path(prefix) / 'lib' / PACKAGE_NAME / name for prefix in prefixes if prefix]
    on_path = shutil.which(name)
    for path in [*paths, *([Path(on_path)] if on_path else [])]:
        if path.is_file():
            return path
    searched = ', '.join(str(path.parent) for path in paths)
    raise NodeProcessError(f'{name} is not installed; searched {searched}. Run `make build`.')


def local_graph(domain_id: int, log_folder: Path) -> dict[str, str]:
    """Environment of a graph on this machine alone, fit for large clouds.

    Args:
        domain_id: ROS_DOMAIN_ID.
        log_folder: where rclpy writes its logs.
    """
    return {
        'ROS_DOMAIN_ID': str(domain_id),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
        'ROS_LOG_DIR': str(log_folder),
        'FASTRTPS_DEFAULT_PROFILES_FILE': str(share_path('config', 'fastdds_large_clouds.xml')),
    }


class NodeProcesses:
    """Node processes, ended together when the ``with`` block is left.

    Args:
        environment: variables added to this process's own.
        log_folder: gets one file a node with all that it prints.
    """

    def __init__(self, environment: Mapping[str, str], log_folder: Path) -> None:
        self._environment = {**os.environ, 'PYTHONUNBUFFERED': '1', **environment}
        self._log_folder = log_folder
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        log_folder.mkdir(parents=True, exist_ok=True)

    def start(
        self, executable: str, *, parameters: Mapping[str, object] | None = None,
        remappings: Mapping[str, str] | None = None, arguments: Sequence[str] = (),
    ) -> subprocess.Popen[bytes]:  # fmt: skip
        """Starts a node.

        Args:
            executable: its name.
            parameters: values as on the command line.
            remappings: from -> to.
            arguments: further ``--ros-args``.

        Raises:
            NodeProcessError: when it is not installed.
        """
        command = [str(find_executable(executable)), '--ros-args']
        for name, value in (parameters or {}).items():
            command += ['-p', f'{name}:={_as_yaml(value)}']
        for source, target in (remappings or {}).items():
            command += ['-r', f'{source}:={target}']
        with open(self.log_path(executable), 'wb') as log:
            process = subprocess.Popen(
                [*command, *arguments],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                env=self._environment,
                # Ctrl-C reaches this process only; it ends the nodes in order.
                start_new_session=True,
            )
        self._processes[executable] = process
        return process

    def process(self, executable: str) -> subprocess.Popen[bytes]:
        """The process of a node that was started."""
        return self._processes[executable]

    def log_path(self, executable: str) -> Path:
        """What a node printed."""
        return self._log_folder / f'{executable}.log'

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
        for process in self._processes.values():
            _send(process, signal.SIGINT)
        codes = {}
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
