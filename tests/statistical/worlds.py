"""Small scenes and renders that the statistical, analytic, invariance and hard-case tests share."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["direction"]

Array = NDArray[np.float64]


def direction(theta: float, phi: float = 0.0) -> Array:
    """Return the local direction at `theta` degrees from the normal, `phi` degrees round it, as float32 has it."""
    t, p = np.radians(theta), np.radians(phi)
    wi = np.array([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)])
    return wi.astype(np.float32).astype(np.float64)
