"""How far the runs of a battery pack lie from the means of their conditions."""

import math

import numpy as np

from labbook.scripts.templates.runs import Number, Runs, of_conditions, values_of
from labbook.scripts.templates.shared import student

PACK = ""
"""The pack that is asked about."""


def pack_deviation(runs: Runs) -> Number:
    """Return the mean deviation of the pack's runs, with Student's interval."""
    means = {
        condition: float(np.mean(values_of(of_conditions(runs, [condition]))))
        for condition in dict.fromkeys(run.row["condition"] for run in runs)
    }
    away = [run.value - means[run.row["condition"]] for run in runs if run.row["battery"] == PACK]
    n, value = len(away), math.fsum(away) / len(away)
    if n < 2:  # one run has no scatter
        return {"value": value}
    return student(value, float(np.std(away, ddof=1)) / math.sqrt(n), n - 1.0)
