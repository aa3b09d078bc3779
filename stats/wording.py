"""Words that sentences of results share; how numbers are rounded says `data_schema.rounding`."""

from __future__ import annotations

from data_schema.rounding import decimals_for, fixed_text, interval_text, number_text
from data_schema.vocabulary import Undefined

_SHARE_DECIMALS = 3


def share_text(share: float | Undefined) -> str:
    """Return a share of 1, such as R squared: three decimals, and as many more as tell it from 1 where it is not."""
    if isinstance(share, Undefined):
        return "undefined"
    return fixed_text(share, max(_SHARE_DECIMALS, decimals_for(1.0 - share)))


def bounded_texts(
    value: float, interval: tuple[float, float] | Undefined, se: float, level: float, unit: str = ""
) -> tuple[str, str]:
    """Return an estimate and "95 % CI 1.23 to 4.56 J" with the decimals that their standard error is worth."""
    return number_text(value, error=se), interval_text(interval, level, unit, se)


def counted(number: int, what: str) -> str:
    """Return "1 day" or "3 days"."""
    return f"{number} {what}{'' if number == 1 else 's'}"


def with_unit(unit: str) -> str:
    """Return the unit with the space that belongs before it."""
    return f" {unit}" if unit else ""


def missing_text(*missing: int) -> str:
    """Return ", 3 missing left out", or nothing where none were."""
    return f", {sum(missing)} missing left out" if any(missing) else ""
