"""What the uncertainty of joules a jump is made of (thesis 5.1.4): of one run, and of the mean of a condition's runs.

A charger that counts in steps errs by at most half a step. Where that differs from run to run the scatter holds it
already; where repeats are rounded alike, their mean errs by it, too. The reference voltage counts as known.
"""

import math

import numpy as np

from labbook.scripts.templates.joules import COULOMB_PER_MAH, REFERENCE_VOLTAGE_V, rounding_sd_mah
from labbook.scripts.templates.runs import Number, Runs, Shared, values_of
from labbook.scripts.templates.shared import of_mean, shared_se


def joules_of_mah(runs: Runs) -> float:
    """Return what 1 mAh is worth in joules a jump, the mean over runs."""
    return float(np.mean([COULOMB_PER_MAH * REFERENCE_VOLTAGE_V / float(run.row["jumps_made"]) for run in runs]))


def parted(shared: Shared, *, rounding: bool) -> Shared:
    """Return the errors of rounding among those that runs share, or those of the drain line."""
    return {source: size for source, size in shared.items() if (source.fit == "rounding") is rounding}


def of_one_step(runs: Runs) -> float:
    """Return the standard deviation that the coarsest step of the charger gives one run."""
    return joules_of_mah(runs) * rounding_sd_mah(max(float(run.row["resolution_mah"]) for run in runs))


def rounded_alike(runs: Runs) -> float:
    """Return what rounding gives the mean where repeats are rounded alike; 0 where they are not."""
    return shared_se(of_mean([parted(run.shared, rounding=True) for run in runs]))


def run_by_scatter(runs: Runs) -> Number:
    """Return the standard deviation of runs."""
    return {"value": float(np.std(values_of(runs), ddof=1))}


def mean_by_scatter(runs: Runs) -> Number:
    """Return the standard error of the mean that the scatter gives it."""
    return {"value": run_by_scatter(runs)["value"] / math.sqrt(len(runs))}


def run_by_drain(runs: Runs) -> Number:
    """Return what the drain line gives one run: the root of the mean square over runs."""
    errors = [shared_se(parted(run.shared, rounding=False)) for run in runs]
    return {"value": math.sqrt(float(np.mean(np.square(errors))))}


def mean_by_drain(runs: Runs) -> Number:
    """Return what the drain line gives the mean: all runs share it."""
    return {"value": shared_se(of_mean([parted(run.shared, rounding=False) for run in runs]))}


def run_by_step(runs: Runs) -> Number:
    """Return what the step of the charger gives one run."""
    return {"value": of_one_step(runs)}


def mean_by_step(runs: Runs) -> Number:
    """Return what the step of the charger gives the mean."""
    return {"value": rounded_alike(runs) or of_one_step(runs) / math.sqrt(len(runs))}


def of_voltage(runs: Runs) -> Number:
    """Return what the reference voltage gives: nothing, for it counts as known."""
    return {"value": 0.0 * len(runs)}


def run_in_all(runs: Runs) -> Number:
    """Return all sources of one run in quadrature; the step where the scatter does not hold it."""
    step = of_one_step(runs) if rounded_alike(runs) else 0.0
    return {"value": math.hypot(run_by_scatter(runs)["value"], run_by_drain(runs)["value"], step)}


def mean_in_all(runs: Runs) -> Number:
    """Return all sources of the mean in quadrature."""
    parts = mean_by_scatter(runs)["value"], mean_by_drain(runs)["value"], rounded_alike(runs)
    return {"value": math.hypot(*parts)}


def one_mah(runs: Runs) -> Number:
    """Return what 1 mAh is worth in joules a jump."""
    return {"value": joules_of_mah(runs)}
