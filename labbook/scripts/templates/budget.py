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


def budget(runs: Runs) -> Number:
    """Return what each source gives one run and the mean, all in quadrature, and what 1 mAh is worth."""
    n, alike, step = len(runs), rounded_alike(runs), of_one_step(runs)
    scatter = float(np.std(values_of(runs), ddof=1))
    drains = [parted(run.shared, rounding=False) for run in runs]
    drain = math.sqrt(float(np.mean(np.square([shared_se(each) for each in drains]))))
    drain_of_mean = shared_se(of_mean(drains))  # all runs share it
    return {
        "scatter between runs": scatter,
        "drain fit": drain,
        "charger resolution": step,
        "reference voltage": 0.0,
        "in all": math.hypot(scatter, drain, step if alike else 0.0),
        "scatter between runs, mean": scatter / math.sqrt(n),
        "drain fit, mean": drain_of_mean,
        "charger resolution, mean": alike or step / math.sqrt(n),
        "reference voltage, mean": 0.0,
        "in all, mean": math.hypot(scatter / math.sqrt(n), drain_of_mean, alike),
        "1 mAh": joules_of_mah(runs),
    }
