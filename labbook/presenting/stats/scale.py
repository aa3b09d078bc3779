"""Values as an axis can show them: at a large offset or a tiny scale, less a number or in powers of ten, exactly."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from fractions import Fraction

_LEAST_SPREAD = Fraction(1, 10**6)
"""A range that is less than so much of the largest value does not show on an axis that is labelled with values."""
_LONGEST = 30
"""Letters of a number that is written without a power of ten."""
_ORDINARY = 200
"""Powers of ten that doubles and axes take without loss."""


@dataclass(frozen=True, slots=True)
class Scale:
    """What is drawn is (value - `offset`) / 10 ** `power`; differences are divided only."""

    offset: Fraction = Fraction(0)
    power: int = 0

    def drawn(self, value: float | Decimal) -> float:
        """Return a value as it is drawn, rounded once."""
        if not self.offset and not self.power:
            return float(value)
        return float((Fraction(value) - self.offset) / Fraction(10) ** self.power)

    def difference(self, value: float) -> float:
        """Return a difference as it is drawn; an endless one stays so."""
        return float(Fraction(value) / Fraction(10) ** self.power) if math.isfinite(value) else value

    def quantity(self, name: str, unit: str) -> str:
        """Say what is subtracted."""
        if not self.offset:
            return name
        return f"{name} less {_exact_text(self.offset)}{'' if unit in ('', '1') else f' {unit}'}"

    def unit(self, unit: str) -> str:
        """Return the unit of what is drawn."""
        if not self.power:
            return unit
        return f"10^{self.power}{'' if unit in ('', '1') else f' {unit}'}"


def scale_of(values: Sequence[float | Decimal]) -> Scale:
    """Choose how these are drawn: as they are, where their spread shows so."""
    if not values:
        return Scale()
    low, high = Fraction(min(values)), Fraction(max(values))
    largest, spread = max(abs(low), abs(high)), high - low
    offset = _round_below(low, spread) if 0 < spread < _LEAST_SPREAD * largest else Fraction(0)
    size = spread if offset else largest
    power = _power(size) if size else 0
    return Scale(offset, power if abs(power) > _ORDINARY else 0)


def _round_below(low: Fraction, spread: Fraction) -> Fraction:
    """Return the next number at or below `low` that has no digit beyond the first of the spread."""
    step = Fraction(10) ** (_power(spread) - 1)
    return low // step * step


def _exact_text(value: Fraction) -> str:
    """Write a number of finitely many decimals with all of them, or as a power of ten times a whole number."""
    places = 0
    while (value * 10**places).denominator > 1:
        places += 1
    digits = int(value * 10**places)
    exact = Decimal((0 if digits >= 0 else 1, tuple(map(int, str(abs(digits)))), -places))
    with localcontext() as context:
        context.prec = len(str(abs(digits)))
        exact = exact.normalize()
    text = f"{exact:f}"
    return text if len(text) <= _LONGEST else f"{exact:E}"


def _power(size: Fraction) -> int:
    """Return the power of ten of a positive number, give or take one."""
    return len(str(size.numerator)) - len(str(size.denominator))
