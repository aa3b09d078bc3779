"""Predictions of made-up content judged without a book: the biases of its levels by group, and all jointly."""

import itertools
import math
import statistics

from reports.numbers import Number
from reports.results import POOLED, Judged, JudgedGroup, Limits, PredictedQuantity
from stats.compare.agreement import FEWEST_DIFFERENCES, limits_of_agreement
from stats.tails import t_two_sided

QUANTITIES = (PredictedQuantity.JOULES, PredictedQuantity.APEX, PredictedQuantity.CONTACT_TIME)
DAYS = 5


def judged(items, identity=lambda what: ""):
    """Judge the levels that have a prediction, as a normal approximation does; `identity` gives each number's id."""
    found = []
    for quantity in QUANTITIES:
        levels = {}
        for item in items:
            if item.quantity is quantity and item.level != POOLED and isinstance(item.check.predicted.value, float):
                levels.setdefault(tuple(item.group.items()), []).append(item)
        groups = tuple(_group(dict(group), each, quantity, identity) for group, each in levels.items())
        if groups:
            every = [item for each in levels.values() for item in each]
            found.append(_together(quantity, groups, _limits(every, identity), identity))
    return tuple(found)


def _group(group, items, quantity, identity):
    measured = statistics.fmean(item.measured.value for item in items)
    predicted = statistics.fmean(item.check.predicted.value for item in items)
    of_measured = math.hypot(*(item.measured.se for item in items)) / len(items)
    se = math.hypot(of_measured, statistics.fmean(item.check.predicted.se for item in items))
    bias, unit = predicted - measured, items[0].measured.unit
    identity = identity(f"bias of {quantity}, {' '.join(group.values())}")

    def number(error):
        low, high = bias - 1.96 * error, bias + 1.96 * error
        return Number(bias, unit, se=error, ci_low=low, ci_high=high, n=60, provenance=identity)

    p = Number(t_two_sided(bias / se, math.inf), "1", provenance=identity)
    return JudgedGroup(group, number(se), number(of_measured), p, Number(measured, unit), Number(predicted, unit), DAYS)


def _limits(items, identity):
    differences = [item.check.predicted.value - item.measured.value for item in items]
    if len(differences) < FEWEST_DIFFERENCES:
        return None
    found, unit = limits_of_agreement(differences), items[0].measured.unit
    key = identity(f"limits of agreement of {items[0].quantity}")

    def number(value, ci):
        return Number(value, unit, ci_low=ci[0], ci_high=ci[1], ci_level=0.95, n=found.n, provenance=key)

    ends = (found.mean, found.ci), (found.low, found.low_ci), (found.high, found.high_ci)
    return Limits(*(number(value, ci) for value, ci in ends))


def _together(quantity, groups, limits, identity):
    signs = [
        math.copysign(1, (b.measured.value - a.measured.value) * (b.predicted.value - a.predicted.value))
        for a, b in itertools.combinations(groups, 2)
    ]
    p = min(1.0, len(groups) * min(group.p.value for group in groups))
    key = identity(f"joint bias of {quantity}")
    tau = Number(statistics.fmean(signs), "1", provenance=key) if signs else None
    return Judged(quantity, groups, Number(p, "1", provenance=key), tau, limits)
