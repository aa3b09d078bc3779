"""Holm's adjusted p (Holm 1979) of one test among those of its family."""

from collections.abc import Mapping, Sequence

from labbook.scripts.templates.contrasts import Effect, contrast_of
from labbook.scripts.templates.days import compare, p_of
from labbook.scripts.templates.runs import Number, Pair, Runs

TESTS: Mapping[str, Pair] = {}
"""By test, the conditions of its control and of its treatment."""
CONTRASTS: Mapping[str, tuple[bool, Sequence[Effect]]] = {}
"""By test, whether its effects are savings in percent, and its effects."""
ASKED = ""
"""The test whose p is adjusted."""
WITHOUT_P = 0
"""Tests of the family that have no p; they count all the same."""


def holm(p_values: Mapping[str, float], tests: int) -> Number:
    """Multiply the smallest of m p-values by m, the next by m - 1 and so on; none is less than one before it."""
    adjusted, largest = {}, 0.0
    for place, name in enumerate(sorted(p_values, key=lambda name: p_values[name])):
        largest = adjusted[name] = max(largest, min(1.0, (tests - place) * p_values[name]))
    return adjusted


def adjusted_p(runs: Runs) -> Number:
    """Return Holm's p of the test among all comparisons with a control."""
    p_values = {name: p_of(compare(runs, pair)) for name, pair in TESTS.items()}
    return {"value": holm(p_values, len(p_values) + WITHOUT_P)[ASKED]}


def adjusted_p_of_contrast(runs: Runs) -> Number:
    """Return Holm's p of the contrast among all contrasts of means."""
    p_values = {
        name: contrast_of(runs, effects, percent=percent)["p"] for name, (percent, effects) in CONTRASTS.items()
    }
    return {"value": holm(p_values, len(p_values) + WITHOUT_P)[ASKED]}
