"""How far predictions lie from what was measured: the mean over days of each day's mean of predicted less measured.

Runs of a day are not independent, so the scatter between days is the error. What runs share by a calibration or a drain
line, and predictions by the inputs that they assume, no number of days averages out. The parts are added in quadrature,
with Welch's and Satterthwaite's degrees of freedom (JCGM 100:2008, G.4); assumed inputs count as known.
"""

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from labbook.scripts.templates.condition import condition_mean
from labbook.scripts.templates.predictions import predicted_mean
from labbook.scripts.templates.runs import Number, Runs, of_conditions
from labbook.scripts.templates.shared import (
    LEVEL,
    of_mean,
    quantile,
    satterthwaite_df,
    shared_df,
    shared_se,
    student,
    two_sided_p,
)

JUDGED: Mapping[str, Sequence[str]] = {}
"""The conditions of each group."""


class DayMeans(NamedTuple):
    """Of each day the mean of what was measured, and that of the predictions."""

    measured: list[float]
    predicted: list[float]


def conditions_of(runs: Runs) -> list[str]:
    """Return the conditions of runs, each once."""
    return list(dict.fromkeys(run.row["condition"] for run in runs))


def predictions_of(runs: Runs) -> dict[str, Number]:
    """Return the prediction of every condition with its standard uncertainty."""
    return {condition: predicted_mean(of_conditions(runs, [condition])) for condition in conditions_of(runs)}


def by_day_of(runs: Runs) -> DayMeans:
    """Return the means of each day, measured and predicted."""
    predicted = predictions_of(runs)
    measured_on: dict[str, list[float]] = {}
    predicted_on: dict[str, list[float]] = {}
    for run in runs:
        measured_on.setdefault(run.row["day"], []).append(run.value)
        predicted_on.setdefault(run.row["day"], []).append(predicted[run.row["condition"]]["value"])
    return DayMeans(*([float(np.mean(values)) for values in on.values()] for on in (measured_on, predicted_on)))


def bias_of(runs: Runs, *, assumed: bool) -> Number:
    """Return the bias with its interval and the p of none, with the errors of what predictions assume or without.

    On one day, or where nothing scatters, it has no interval.
    """
    means = by_day_of(runs)
    away = np.array(means.predicted) - np.array(means.measured)
    value, days = float(np.mean(away)), len(away)
    if days < 2:
        return {"value": value}
    shared, predicted = of_mean([run.shared for run in runs]), predictions_of(runs)
    parts = [(float(np.var(away, ddof=1)) / days, days - 1.0), (shared_se(shared) ** 2, shared_df(shared))]
    if assumed:
        parts.append((float(np.mean([predicted[run.row["condition"]]["se"] for run in runs])) ** 2, math.inf))
    se, df = math.sqrt(math.fsum(variance for variance, _df in parts)), satterthwaite_df(parts)
    if se == 0.0:
        return {"value": value}
    return {**student(value, se, df), "p": two_sided_p(value / se, df)}


def bias(runs: Runs) -> Number:
    """Return the bias with the errors of what was measured and of what was assumed."""
    return bias_of(runs, assumed=True)


def bias_of_measured(runs: Runs) -> Number:
    """Return the bias as if predictions had no error."""
    return bias_of(runs, assumed=False)


def measured_over_days(runs: Runs) -> Number:
    """Return the mean over days of what was measured."""
    return {"value": float(np.mean(by_day_of(runs).measured))}


def predicted_over_days(runs: Runs) -> Number:
    """Return the mean over days of the predictions."""
    return {"value": float(np.mean(by_day_of(runs).predicted))}


def joint_p(runs: Runs) -> Number:
    """Return the p of no bias in any group: Bonferroni's, the smallest p times their number."""
    groups = [bias_of(of_conditions(runs, conditions), assumed=True) for conditions in JUDGED.values()]
    ps = [group["p"] for group in groups if "p" in group]
    return {"value": min(1.0, len(ps) * min(ps))}


def tau_of_groups(runs: Runs) -> Number:
    """Return Kendall's tau of the measured and the predicted order of groups."""
    groups = [by_day_of(of_conditions(runs, conditions)) for conditions in JUDGED.values()]
    pairs = list(itertools.combinations(groups, 2))
    agreeing = sum(
        float(np.sign(np.mean(b.measured) - np.mean(a.measured)) * np.sign(np.mean(b.predicted) - np.mean(a.predicted)))
        for a, b in pairs
    )
    return {"value": agreeing / len(pairs)}


def limits_of(runs: Runs) -> dict[str, Number]:
    """Return the mean difference and the limits of agreement over conditions, each with Student's interval.

    Source: Bland and Altman (1986), The Lancet 327, 307.
    """
    predicted = predictions_of(runs)
    away = [
        predicted[condition]["value"] - condition_mean(of_conditions(runs, [condition]))["value"]
        for condition in conditions_of(runs)
    ]
    n, mean, sd, z = len(away), float(np.mean(away)), float(np.std(away, ddof=1)), quantile(LEVEL, math.inf)
    of_limit = sd * math.sqrt(1.0 / n + z**2 / (2.0 * (n - 1)))
    found = {"mean": (mean, sd / math.sqrt(n)), "low": (mean - z * sd, of_limit), "high": (mean + z * sd, of_limit)}
    return {name: student(value, se, n - 1.0) for name, (value, se) in found.items()}


def mean_difference(runs: Runs) -> Number:
    """Return the mean over conditions of predicted less measured."""
    return limits_of(runs)["mean"]


def lower_limit(runs: Runs) -> Number:
    """Return the lower limit of agreement."""
    return limits_of(runs)["low"]


def upper_limit(runs: Runs) -> Number:
    """Return the upper limit of agreement."""
    return limits_of(runs)["high"]
