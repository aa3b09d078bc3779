"""Designs in which every day holds every condition."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Labels = NDArray[np.intp]


def crossed(conditions: int, days: int, times: int) -> tuple[Labels, Labels]:
    """Return the condition and the day of every value, each condition `times` a day."""
    condition = np.tile(np.repeat(np.arange(conditions), times), days)
    return condition, np.repeat(np.arange(days), conditions * times)
