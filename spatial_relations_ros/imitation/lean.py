"""How far an object was turned over."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

_STANDS = 0.25


def turned_over(before: NDArray[np.float64], after: NDArray[np.float64]) -> float:
    """How far the direction that points up in the body has turned: 0, or 1 for upside down.

    Args:
        before: (3, 3) world from body.
        after: (3, 3) the same later.
    """
    cosine = float(before[2] @ after[2])
    return math.acos(max(-1.0, min(1.0, cosine))) / math.pi


def stands_as_before(before: NDArray[np.float64], after: NDArray[np.float64]) -> bool:
    """Whether what points up in the body still does, to within 45 degrees."""
    return turned_over(before, after) < _STANDS
