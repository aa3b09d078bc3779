"""Numbers in sentences: rounding happens here and nowhere else."""

from __future__ import annotations

import math
from collections.abc import Sequence

from data_schema.vocabulary import Undefined


def number_text(value: float | Undefined, digits: int = 4) -> str:
    """Return a number with `digits` significant digits, or "undefined"; 12345 stays 12345, never 1.2e+04."""
    if isinstance(value, Undefined):
        return "undefined"
    text = f"{value:.{digits}g}"
    if "e" in text and 1e-4 <= abs(value) < 1e15:
        text = f"{value:.0f}"
    return "0" if text == "-0" else text


def df_text(df: float | Undefined) -> str:
    """Return degrees of freedom: 64 for 64.0, 20.9 for 20.93."""
    if isinstance(df, Undefined):
        return "undefined"
    return f"{df:.0f}" if math.isclose(df, round(df), rel_tol=1e-9) or df >= 1e4 else f"{df:.1f}"


def estimate_texts(values: Sequence[float], se: float) -> list[str]:
    """Return an estimate and its ends with the decimals that their standard error is worth: two digits of it."""
    decimals = max(0, 1 - math.floor(math.log10(se))) if se > 0.0 and math.isfinite(se) else 3
    return [f"{value:.{decimals}f}" for value in values]


def p_text(p: float | Undefined, log10_p: float | Undefined | None = None) -> str:
    """Return "p = 0.023", "p < 0.0001", with its logarithm "p = 10^-2476.7" below 1e-300, or "p undefined"."""
    if isinstance(p, Undefined):
        return "p undefined"
    if isinstance(log10_p, float) and log10_p < -300.0:
        return f"p = 10^{log10_p:.1f}"
    return "p < 0.0001" if p < 0.0001 else f"p = {p:.2g}"


def interval_text(interval: tuple[float, float] | Undefined, level: float, unit: str = "") -> str:
    """Return "95 % CI 1.2 to 3.4 J", or "95 % CI undefined"."""
    name = f"{100.0 * level:g} % CI"
    if isinstance(interval, Undefined):
        return f"{name} undefined"
    return f"{name} {number_text(interval[0])} to {number_text(interval[1])}{with_unit(unit)}"


def counted(number: int, what: str) -> str:
    """Return "1 day" or "3 days"."""
    return f"{number} {what}{'' if number == 1 else 's'}"


def with_unit(unit: str) -> str:
    """Return the unit with the space that belongs before it."""
    return f" {unit}" if unit else ""


def missing_text(*missing: int) -> str:
    """Return ", 3 missing left out", or nothing where none were."""
    return f", {sum(missing)} missing left out" if any(missing) else ""
