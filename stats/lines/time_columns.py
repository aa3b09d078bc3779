"""Which columns were moments or durations, and in what unit a fit therefore has them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

_UNITS = {"M": "s since 1970 UTC", "m": "s"}
"""By numpy's kind of type: moments and durations."""


def time_unit(values: Any) -> str | None:
    """Return "s since 1970 UTC" for moments, "s" for durations, and None for numbers."""
    first = values[:1] if isinstance(values, Sequence) else values  # of a list, no more than what tells the type
    return _UNITS.get(np.asarray(first).dtype.kind)


def time_units(columns: Mapping[str, Any]) -> tuple[str, ...]:
    """Return "start in s since 1970 UTC" or "duration in s" of each column that was given as time."""
    units = {name: time_unit(values) for name, values in columns.items()}
    return tuple(f"{name} in {unit}" for name, unit in units.items() if unit is not None)
