"""The change of a result that a user lets pass, in words: `1%` or `0.01`."""

from __future__ import annotations

import math

from data_schema.errors import UsageError
from simulator.jump import limits_for

ACCURACIES_A_TOLERANCE = 10.0
"""A tolerance is at least so many times the accuracy: differences of results have the errors of both."""


def tolerance_of(words: str, accuracy: float) -> float:
    """Return the share that the words name: above 0, at most 1.

    Raises `UsageError` for what is no share, could mean two, or is finer than results of this accuracy can tell, and
    for an accuracy that cannot be had.
    """
    limits_for(accuracy)
    text = words.strip()
    percent = text.endswith("%")
    try:
        number = float(text.removesuffix("%"))
    except ValueError:
        number = math.nan
    share = number / 100.0 if percent else number
    if not 0.0 < share < math.inf:
        raise UsageError(f"--within {words} is not a share above 0: write for example --within 1% or --within 0.01.")
    if not percent and share >= 1.0:
        raise UsageError(f"--within {words} does not say of what: write --within {number:g}%, or a number below 1.")
    if share > 1.0:
        raise UsageError(f"--within {words} lets everything pass: give at most 100%.")
    if share < ACCURACIES_A_TOLERANCE * accuracy:
        raise UsageError(
            f"--within {words} is too fine to tell with results of accuracy {accuracy:g}: give at least "
            f"{100.0 * ACCURACIES_A_TOLERANCE * accuracy:g}%, or --accuracy {share / ACCURACIES_A_TOLERANCE:g}."
        )
    return share
