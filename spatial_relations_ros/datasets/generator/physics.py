"""Whether a scene stays as it is when it is let go, by simulation in MuJoCo (optional)."""

from __future__ import annotations

from spatial_relations_ros.datasets.generator.checks import Measured


def settling_reason(measured: Measured) -> str:
    """Why a scene is refused."""
    raise NotImplementedError
