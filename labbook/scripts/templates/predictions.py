"""What the simulator gives for the runs as they were made, beside what was measured of them.

Simulated values stand in the table, of every condition with the parameters as they are, and with each assumed one
lowered and raised: only the simulator gives them again. The error adds in quadrature the simulator's own, and for each
assumed parameter the larger of both changes. Predicted and measured agree where the error ratio E_n of ISO 13528, their
difference over the expanded uncertainty of both, lies within -1 to 1.
"""

import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from labbook.scripts.templates.days import PAIR, compare, saving_of
from labbook.scripts.templates.runs import (
    LEVEL,
    Number,
    Row,
    Runs,
    condition_mean,
    of_conditions,
    of_mean,
    quantile,
    satterthwaite_df,
    shared_df,
    shared_se,
    student,
    two_sided_p,
)

ERROR_BY = "accuracy"
"""The part of the error that is asked about: the simulator's accuracy, or an assumed parameter."""
COVERAGE_FACTOR = 2.0
"""Standard uncertainties of a prediction that its expanded uncertainty has."""

Sides = Sequence[Runs]
"""The runs of each mean that is compared."""


def varied_in(row: Row) -> dict[str, list[float]]:
    """Return what was simulated with each assumed parameter otherwise; nan where the jump has no apex."""
    found: dict[str, list[float]] = {}
    if row["varied"]:
        for name, value in zip(row["varied"].split(";"), row["simulated_varied"].split(";"), strict=True):
            found.setdefault(name, []).append(float(value))
    return found


def simulated_mean(runs: Runs, parameter: str = "", place: int = 0) -> float:
    """Return the mean of the simulated values over runs, with a parameter lowered (place 0) or raised (1)."""
    values = []
    for run in runs:
        varied = varied_in(run.row).get(parameter)
        values.append(float(run.row["simulated"]) if varied is None else varied[place])
    return math.fsum(values) / len(values)


def relative_error(sides: Sides) -> float:
    """Return the largest relative error of the simulations."""
    return max(float(run.row["simulated_error"]) for side in sides for run in side)


def errors_by(sides: Sides, of_means: Callable[[Sequence[float]], float], accuracy: float) -> Number:
    """Return the parts of the error of what follows from means: a parameter is another in all of them at once."""
    value, parts = of_means([simulated_mean(side) for side in sides]), {"accuracy": accuracy}
    counts = {name: len(values) for side in sides for run in side for name, values in varied_in(run.row).items()}
    for name, count in counts.items():
        others = [of_means([simulated_mean(side, name, place) for side in sides]) for place in range(count)]
        parts[name] = float(np.max(np.abs(np.array(others) - value)))
    return parts


def with_error(value: float, parts: Number) -> Number:
    """Return a prediction with its standard uncertainty; without one where a varied jump has no apex."""
    se = math.hypot(*parts.values())
    return {"value": value} if math.isnan(se) else {"value": value, "se": se}


def saving_in_percent(means: Sequence[float]) -> float:
    """Return 100 (1 - T / C) of the means of a control and of what is compared with it."""
    return 100.0 * (1.0 - means[1] / means[0])


def sides_of_pair(runs: Runs) -> Sides:
    """Return the runs of the control, and those that are compared with it."""
    return [of_conditions(runs, conditions) for conditions in PAIR]


def errors_of_mean(runs: Runs) -> Number:
    """Return the parts of the error of the simulated mean."""
    return errors_by([runs], lambda means: means[0], relative_error([runs]) * abs(simulated_mean(runs)))


def errors_of_saving(runs: Runs) -> Number:
    """Return the parts of the error of the simulated saving: the simulator's is in both means."""
    sides = sides_of_pair(runs)
    saved = saving_in_percent([simulated_mean(side) for side in sides])
    return errors_by(sides, saving_in_percent, math.sqrt(2.0) * relative_error(sides) * abs(100.0 - saved))


def predicted_mean(runs: Runs) -> Number:
    """Return the simulated mean of a condition's runs with its standard uncertainty."""
    return with_error(simulated_mean(runs), errors_of_mean(runs))


def predicted_saving(runs: Runs) -> Number:
    """Return the simulated saving with its standard uncertainty."""
    means = [simulated_mean(side) for side in sides_of_pair(runs)]
    return with_error(saving_in_percent(means), errors_of_saving(runs))


def error_of_mean_by(runs: Runs) -> Number:
    """Return one part of the error of the simulated mean."""
    return {"value": errors_of_mean(runs)[ERROR_BY]}


def error_of_saving_by(runs: Runs) -> Number:
    """Return one part of the error of the simulated saving."""
    return {"value": errors_of_saving(runs)[ERROR_BY]}


def away_from(measured: Number, predicted: Number) -> Number:
    """Return predicted less measured."""
    return {"value": predicted["value"] - measured["value"]}


def error_ratio(measured: Number, predicted: Number, level: float) -> Number:
    """Return E_n: the half interval on the side of the prediction, at 95 %, beside two standard uncertainties."""
    difference = predicted["value"] - measured["value"]
    half = measured["ci_high" if difference > 0.0 else "ci_low"] - measured["value"]
    if level != 0.95:
        half *= quantile(0.95, measured["df"]) / quantile(level, measured["df"])
    return {"value": difference / math.hypot(half, COVERAGE_FACTOR * predicted["se"])}


def mean_predicted_less_measured(runs: Runs) -> Number:
    """Return the simulated mean less the measured one."""
    return away_from(condition_mean(runs), predicted_mean(runs))


def error_ratio_of_mean(runs: Runs) -> Number:
    """Return E_n of a condition's mean."""
    return error_ratio(condition_mean(runs), predicted_mean(runs), LEVEL)


def saving_predicted_less_measured(runs: Runs) -> Number:
    """Return the simulated saving less the measured one."""
    return away_from(saving_of(compare(runs, PAIR)), predicted_saving(runs))


def error_ratio_of_saving(runs: Runs) -> Number:
    """Return E_n of a saving."""
    return error_ratio(saving_of(compare(runs, PAIR)), predicted_saving(runs), LEVEL)


"""What the simulator gives for a hypothesis: the change of a mean in percent of another, or of a saving in points."""

COMPARED: Sequence[Sequence[str]] = ()
"""The conditions of a mean and of what is compared with it; of four, the change of the last two less that of the first
two."""


def change_in_percent(means: Sequence[float]) -> float:
    """Return 100 (B / A - 1) of two means; of four A, B, C, D 100 (B / A - D / C), in percentage points."""
    changes = [100.0 * (other / one - 1.0) for one, other in zip(means[::2], means[1::2], strict=True)]
    return changes[0] if len(changes) == 1 else changes[0] - changes[1]


def simulated_change(runs: Runs) -> Number:
    """Return the simulated change with its standard uncertainty; the simulator errs in each mean by itself."""
    sides = [of_conditions(runs, conditions) for conditions in COMPARED]
    accuracy = math.sqrt(len(sides)) * relative_error(sides) * 100.0
    value = change_in_percent([simulated_mean(side) for side in sides])
    return with_error(value, errors_by(sides, change_in_percent, accuracy))


"""How far predictions lie from what was measured: the mean over days of each day's mean of predicted less measured.

Runs of a day are not independent, so the scatter between days is the error. What runs share by a calibration or a drain
line, and predictions by the inputs that they assume, no number of days averages out. The parts are added in quadrature,
with Welch's and Satterthwaite's degrees of freedom (JCGM 100:2008, G.4); assumed inputs count as known.
"""

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
