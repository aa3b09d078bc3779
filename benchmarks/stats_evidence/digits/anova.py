"""F and p of NIST's eleven sets for one-way analysis of variance, by each program."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
import pingouin
import scipy.special
import scipy.stats
from mpmath import log10
from numpy.typing import NDArray
from statsmodels.stats.oneway import anova_oneway

from benchmarks.stats_evidence.digits.lre import Program, Row, lre, row, tried
from stats.groups.anova import one_way_anova
from tests.helpers.nist import exact, groups, names

Floats = NDArray[np.float64]
Groups = dict[str, Floats]
Found = tuple[float, float, float]
"""F, p, log10 p."""
SMALLEST_P = 1e-300


def _labbook(samples: Groups) -> Any:
    found = one_way_anova(samples)
    return found.f, found.p, found.log10_p


def _scipy(samples: Groups) -> Found:
    found = scipy.stats.f_oneway(*samples.values())
    return _with_log(found.statistic, found.pvalue)


def _statsmodels(samples: Groups) -> Found:
    found = anova_oneway(list(samples.values()), use_var="equal")
    return _with_log(found.statistic, found.pvalue)


def _pingouin(samples: Groups) -> Found:
    frame = pd.DataFrame([(name, value) for name, values in samples.items() for value in values], columns=["g", "y"])
    row = pingouin.anova(data=frame, dv="y", between="g").iloc[0]
    return _with_log(row["F"], row["p_unc"])


def _numpy(samples: Groups) -> Found:
    everything = np.concatenate(list(samples.values()))
    between = sum(values.size * (values.mean() - everything.mean()) ** 2 for values in samples.values())
    within = sum(((values - values.mean()) ** 2).sum() for values in samples.values())
    return _tested(float(between), float(within), len(samples), everything.size)


def _textbook(samples: Groups) -> Found:
    lists = [values.tolist() for values in samples.values()]
    n, total = sum(map(len, lists)), sum(sum(values) for values in lists)
    of_groups = sum(sum(values) ** 2 / len(values) for values in lists)
    squares = sum(value * value for values in lists for value in values)
    return _tested(of_groups - total**2 / n, squares - of_groups, len(lists), n)


def _tested(between: float, within: float, k: int, n: int) -> Found:
    f = (between / (k - 1)) / (within / (n - k))
    return _with_log(f, float(scipy.special.fdtrc(k - 1, n - k, f)))


def _with_log(f: float, p: float) -> Found:
    return float(f), float(p), math.log10(p) if p > 0.0 else -math.inf


PROGRAMS: dict[str, Program] = {
    "labbook": _labbook,
    "scipy f_oneway": _scipy,
    "statsmodels anova_oneway": _statsmodels,
    "pingouin anova": _pingouin,
    "numpy, two passes": _numpy,
    "textbook": _textbook,
}


def rows() -> Iterator[Row]:
    """Return the digits of F, and of p or, where that is below every double, of its logarithm."""
    for name in names("anova"):
        samples = {group: np.array(values, dtype=np.float64) for group, values in groups(name).items()}
        right_f, right_p = exact(name, "anova", "F"), exact(name, "anova", "p")
        for program, function in PROGRAMS.items():
            f, p, log10_p = tried(function, samples) or (math.nan, math.nan, math.nan)
            yield row("F", name, program, lre(f, right_f))
            if right_p > SMALLEST_P:
                yield row("p of F", name, program, lre(p, right_p))
            else:
                yield row("log10 of p of F", name, program, lre(log10_p, log10(right_p)))
