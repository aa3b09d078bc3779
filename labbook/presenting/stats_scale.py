"""Values as an axis can show them: at a large offset or a tiny scale, less a number or in powers of ten, exactly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction

_LEAST_SPREAD = Fraction(1, 10**6)
"""A range that is less than so much of the largest value does not show on an axis that is labelled with values."""
_ORDINARY = 200
"""Powers of ten that doubles and axes take without loss."""


@dataclass(frozen=True, slots=True)
class Scale:
    """What is drawn is (value - `offset`) / 10 ** `power`; differences are divided only."""

    offset: Fraction = Fraction(0)
    power: int = 0

    def drawn(self, value: float | Decimal) -> float:
        """Return a value as it is drawn, rounded once."""
        return float((Fraction(value) - self.offset) / Fraction(10) ** self.power)

    def difference(self, value: float) -> float:
        """Return a difference as it is drawn; an endless one stays so."""
        return float(Fraction(value) / Fraction(10) ** self.power) if math.isfinite(value) else value

    def quantity(self, name: str, unit: str) -> str:
        """Say what is subtracted."""
        if not self.offset:
            return name
        return f"{name} less {float(self.offset):.17g}{'' if unit in ('', '1') else f' {unit}'}"

    def unit(self, unit: str) -> str:
        """Return the unit of what is drawn."""
        if not self.power:
            return unit
        return f"10^{self.power}{'' if unit in ('', '1') else f' {unit}'}"


def scale_of(values: Sequence[float | Decimal]) -> Scale:
    """Choose how these are drawn: as they are, where their spread shows so."""
    exact = [Fraction(value) for value in values]
    if not exact:
        return Scale()
    low, high = min(exact), max(exact)
    largest, spread = max(abs(low), abs(high)), high - low
    offset = Fraction(float(low)) if 0 < spread < _LEAST_SPREAD * largest else Fraction(0)
    size = spread if offset else largest
    power = _power(size) if size else 0
    return Scale(offset, power if abs(power) > _ORDINARY else 0)


def _power(size: Fraction) -> int:
    """Return the power of ten of a positive number, give or take one."""
    return len(str(size.numerator)) - len(str(size.denominator))
