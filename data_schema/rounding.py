"""Rounding that keeps what a number says: a p-value stays on its side of alpha, and a level stays below 100 %."""

from __future__ import annotations

from collections.abc import Iterable
from decimal import Decimal

USUAL_ALPHAS = (0.1, 0.05, 0.025, 0.02, 0.01, 0.005, 0.001, 0.0001)
"""What p-values are compared with: no p is rounded onto one of these, or past it."""
_LEVEL_TOLERANCE = Decimal("1e-6")
"""Share of a level's distance to 0 or 100 % by which it may be rounded."""


def on_its_side(p: float, texts: Iterable[str], *alphas: float) -> str:
    """Return the first of a p-value's texts that lies where it does: beside, or exactly on, each usual level."""
    levels = (*USUAL_ALPHAS, *alphas)
    return next((text for text in texts if all(_side(float(text), at) == _side(p, at) for at in levels)), repr(p))


def _side(p: float, alpha: float) -> int:
    return (p > alpha) - (p < alpha)


def alpha_beside(level: float) -> float:
    """Return 1 - level of the decimal that a level is written as: 0.1 for 0.9, which in doubles is a little less."""
    return float(1 - Decimal(repr(float(level))))


def level_text(level: float) -> str:
    """Return a level in percent: "95 %", or "99.99999 %" with the digits that tell it from 0 and from 100 %."""
    percent = 100 * Decimal(repr(float(level)))
    tolerance = _LEVEL_TOLERANCE * min(percent, 100 - percent)
    decimals = 0
    while abs(round(percent, decimals) - percent) > tolerance:
        decimals += 1
    return f"{round(percent, decimals):f} %"
