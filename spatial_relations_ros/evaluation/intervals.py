"""Confidence intervals of counts."""

from __future__ import annotations

import numpy as np

_WILSON_Z = 1.959964


def wilson_interval(hits: int, total: int) -> tuple[float, float]:
    """95 % confidence interval of a share, after Wilson 1927."""
    share, z2 = hits / total, _WILSON_Z**2
    middle = (share + z2 / (2 * total)) / (1 + z2 / total)
    spread = (
        _WILSON_Z / (1 + z2 / total) * np.sqrt(share * (1 - share) / total + z2 / (4 * total**2))
    )
    return max(float(middle - spread), 0.0), min(float(middle + spread), 1.0)
