"""Correct digits of a number: -log10 of its relative error against exact arithmetic on the same doubles."""

from __future__ import annotations

import importlib.metadata
import math
import warnings
from collections.abc import Callable, Iterable
from typing import Any

from mpmath import mpf

CAP = 15.0
"""No double says more about a number than 15 to 16 digits."""

LIBRARIES = ("numpy", "scipy", "statsmodels", "pingouin")
Program = Callable[..., Any]
Row = dict[str, str]


def lre(found: float, right: mpf) -> float | None:
    """Return the digits of `found` that are right, 0 to 15; None where it is no number.

    Where the exact value is 0 the error itself counts instead of its share.
    """
    if not math.isfinite(found):
        return None
    error = abs(mpf(float(found)) - right) / (abs(right) if right else 1)
    return CAP if error == 0 else min(max(0.0, -math.log10(error)), CAP)


def worst(found: Iterable[float], right: Iterable[mpf]) -> float | None:
    """Return the least of the digits of several numbers; None where one is no number."""
    scores = [lre(value, true) for value, true in zip(found, right, strict=True)]
    return None if any(score is None for score in scores) else min(score for score in scores if score is not None)


def tried(program: Program, *given: Any) -> Any:
    """Call a program as its users do, its warnings unseen; None where it stops with an error."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return program(*given)
        except Exception:  # whatever a peer raises on such data is its answer
            return None


def row(quantity: str, data: str, program: str, score: float | None) -> Row:
    """Return a row of `docs/statistics/digits.csv`; "none" where a program gave no number."""
    digits = "none" if score is None else f"{score:.1f}"
    library = next((one for one in LIBRARIES if program.startswith(one)), None)
    version = importlib.metadata.version(library) if library else ""
    return {"quantity": quantity, "data": data, "program": program, "version": version, "digits": digits}
