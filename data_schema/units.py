"""Units at the edge: a source unit becomes a factor and an offset to the unit that is stored.

Nothing here is applied sample by sample; readers multiply whole arrays once.
"""

from __future__ import annotations

import functools
import re
from typing import Any

from data_schema.errors import InputRefused

MAH_TO_COULOMB = 3.6
"""One milliampere hour in coulombs (exact)."""

STANDARD_GRAVITY_M_S2 = 9.80665
"""Standard gravity (CGPM 1901)."""

_SPELLINGS = {
    "": "1",
    "-": "1",
    "none": "1",
    "count": "1",
    "counts": "1",
    "°C": "degC",
    "C": "degC",
    "mAh": "mA*h",
    "Nm": "N*m",
    "Nmm": "N*mm",
    "N.m": "N*m",
    "N.mm": "N*mm",
    "sec": "s",
    "µs": "us",
}


_WORD = re.compile(r"N\.mm|N\.m|[A-Za-zµ°]+")


def _as_pint(unit: str) -> str:
    """Return a unit as pint spells it: `Nm/kg`, of which pint knows no `Nm`, as `(N*m)/kg`."""
    if unit in _SPELLINGS:
        return _SPELLINGS[unit]
    return _WORD.sub(lambda word: f"({_SPELLINGS[word[0]]})" if word[0] in _SPELLINGS else word[0], unit)


@functools.cache
def _registry() -> Any:
    import pint  # heavy: only where a unit is converted

    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


def is_unit(text: str) -> bool:
    """Tell whether the units library knows a unit."""
    try:
        _registry().Unit(_as_pint(text))
    except Exception:  # pint raises a dozen unrelated types for bad unit text
        return False
    return True


@functools.cache
def conversion(source: str, target: str) -> tuple[float, float]:
    """Return `(scale, offset)` so that `stored = scale * value + offset`.

    Raises `InputRefused` when the source unit is unknown or measures another quantity than the target.
    """
    if source == target:
        return 1.0, 0.0
    registry = _registry()
    try:
        given, stored = _as_pint(source), _as_pint(target)
        origin = registry.Quantity(0.0, given).to(stored).magnitude
        unit = registry.Quantity(1.0, given).to(stored).magnitude
    except Exception as error:  # pint raises a dozen unrelated types for bad unit text
        raise InputRefused(
            f"unit {source!r} cannot be converted to {target!r}: give a unit of the same quantity, "
            f"for example {target!r}."
        ) from error
    return float(unit - origin), float(origin)
