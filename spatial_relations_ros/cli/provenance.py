"""What a measured number depends on besides its input: versions, revision, machine."""

from __future__ import annotations

import os
import platform
import subprocess
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from spatial_relations_ros import __version__

LIBRARIES = ('numpy', 'torch', 'open3d', 'roma', 'scikit-learn', 'metric-learn')


def provenance() -> dict[str, Any]:
    """Versions, git revision (None outside of a checkout) and machine."""
    import torch

    return {
        'version': __version__,
        'git_revision': git_revision(),
        'python': platform.python_version(),
        'libraries': library_versions(),
        'cpu': cpu_name(),
        'num_cpus': os.cpu_count(),
        'num_threads': torch.get_num_threads(),
    }


def library_versions() -> dict[str, str]:
    """Versions of the libraries that decide numbers; those not installed are left out."""
    versions = {}
    for name in LIBRARIES:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            continue
    return versions


def git_revision() -> str | None:
    """The checkout's revision, with ``-dirty`` for changed files."""
    repository = Path(__file__).resolve().parents[2]
    if not (repository / '.git').exists():
        return None
    try:
        described = subprocess.run(
            ['git', '-C', str(repository), 'describe', '--always', '--dirty', '--abbrev=12'],
            capture_output=True,
            text=True,
            timeout=10.0,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return described.stdout.strip() or None


def cpu_name() -> str:
    """The processor's name, as far as the system tells it."""
    try:
        for line in Path('/proc/cpuinfo').read_text().splitlines():
            if line.startswith('model name'):
                return line.partition(':')[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
