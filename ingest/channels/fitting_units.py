"""Which unit a column may have been written in, where its values cannot be in the one that was read."""

from __future__ import annotations

import math

from ingest.channels.columns import ColumnPlan
from ingest.channels.factors import FACTORS
from ingest.channels.synonyms import channel_kind

_LENGTHS = {**FACTORS["m"], "in": 0.0254, "ft": 0.3048}
_USUAL = {"m": 0.4}
"""What a value of a hopping leg is about, in stored units; of the rest only that it is within what is allowed."""


def fitting_unit(plan: ColumnPlan, value: float, low: float, high: float, *, usual: float | None = None) -> str | None:
    """Return the unit in which a stored `value` would lie in `low` to `high`, the nearest to what is usual."""
    source = value / plan.scale
    units = _LENGTHS if plan.unit == "m" else FACTORS.get(plan.unit or "", {})
    fitting = {unit: abs(source * scale) for unit, scale in units.items() if low <= source * scale <= high}
    fitting.pop(plan.source_unit or plan.unit or "", None)
    near = usual or _USUAL.get(plan.unit or "", 1.0)
    return min(fitting, key=lambda unit: abs(math.log((fitting[unit] or 1e-30) / near)), default=None)


def in_unit(plan: ColumnPlan, value: float, unit: str) -> float:
    """Return a stored length as it would be, its column being in another unit."""
    return value / plan.scale * _LENGTHS[unit]


def say_unit(plan: ColumnPlan, unit: str) -> str:
    """Return the flags that have the column read in a unit."""
    if channel_kind(plan.channel) is None:
        return f'`--unit "{plan.source_name}={unit}" --override-units`'
    return f'`--column "{plan.source_name}={plan.channel}:{unit}" --override-units`'
