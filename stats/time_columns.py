"""Which columns were moments or durations, and in what unit a fit therefore has them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

_UNITS = {"M": "s since 1970 UTC", "m": "s"}
"""By numpy's kind of type: moments and durations."""


def time_units(columns: Mapping[str, Any]) -> tuple[str, ...]:
    """Return "start in s since 1970 UTC" or "duration in s" of each column that was given as time."""
    units = {name: _UNITS.get(_first(values).dtype.kind) for name, values in columns.items()}
    return tuple(f"{name} in {unit}" for name, unit in units.items() if unit is not None)


def _first(values: Any) -> np.ndarray[Any, Any]:
    """Return an array of the type of the values; of a list, no more than what tells the type."""
    return np.asarray(values[:1] if isinstance(values, Sequence) else values)
