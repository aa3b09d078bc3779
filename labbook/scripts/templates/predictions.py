"""What the simulator gives for the runs as they were made, beside what was measured of them.

Simulated values stand in the table, of every condition with the parameters as they are, and with each assumed one
lowered and raised: only the simulator gives them again. The error adds in quadrature the simulator's own, and for each
assumed parameter the larger of both changes. Predicted and measured agree where the error ratio E_n of ISO 13528, their
difference over the expanded uncertainty of both, lies within -1 to 1.
"""

import math
from collections.abc import Callable, Sequence

import numpy as np

from labbook.scripts.templates.condition import condition_mean
from labbook.scripts.templates.days import PAIR, compare, saving_of
from labbook.scripts.templates.runs import Number, Row, Runs, of_conditions
from labbook.scripts.templates.shared import LEVEL, quantile

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
