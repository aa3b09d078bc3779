"""Mean, standard deviation and autocorrelation of NIST's nine univariate sets, by each program."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import scipy.stats
from numpy.typing import NDArray
from statsmodels.stats.weightstats import DescrStatsW
from statsmodels.tsa.stattools import acf

from benchmarks.stats_evidence.digits.lre import Program, Row, lre, row, tried
from stats.compare.summary import autocorrelation, describe
from tests.helpers.nist import columns, exact, names

Floats = NDArray[np.float64]


def _two_pass_autocorrelation(x: Floats) -> Any:
    d = x - x.mean()
    return d[:-1] @ d[1:] / (d @ d)


def _textbook_sd(x: Floats) -> float:
    numbers = x.tolist()
    n = len(numbers)
    return math.sqrt((sum(value * value for value in numbers) - sum(numbers) ** 2 / n) / (n - 1))


def _textbook_autocorrelation(x: Floats) -> float:
    numbers: list[float] = x.tolist()
    n, mean = len(numbers), sum(numbers) / len(numbers)
    products = sum(a * b for a, b in itertools.pairwise(numbers))
    both = products - mean * (sum(numbers[:-1]) + sum(numbers[1:])) + (n - 1) * mean * mean
    return both / (sum(value * value for value in numbers) - n * mean * mean)


MEAN: dict[str, Program] = {
    "labbook": lambda x: describe(x).mean,
    "scipy tmean": scipy.stats.tmean,
    "statsmodels DescrStatsW": lambda x: DescrStatsW(x).mean,
    "numpy": np.mean,
    "textbook": lambda x: sum(x.tolist()) / len(x),
}
SD: dict[str, Program] = {
    "labbook": lambda x: describe(x).sd,
    "scipy tstd": scipy.stats.tstd,
    "statsmodels DescrStatsW": lambda x: DescrStatsW(x, ddof=1).std,
    "numpy": lambda x: np.std(x, ddof=1),
    "textbook": _textbook_sd,
}
AUTOCORRELATION: dict[str, Program] = {
    "labbook": lambda x: autocorrelation(x).r,
    "statsmodels acf": lambda x: acf(x, nlags=1)[1],
    "numpy, two passes": _two_pass_autocorrelation,
    "textbook": _textbook_autocorrelation,
}


QUANTITIES = {
    "mean": ("mean", MEAN),
    "standard deviation": ("sd", SD),
    "autocorrelation at lag 1": ("autocorr_lag1", AUTOCORRELATION),
}
"""What is computed: its name in the certified values, and who computes it; pingouin offers none."""


def rows() -> Iterator[Row]:
    """Return the digits of each quantity, set by set."""
    samples = {name: np.array(columns(name)["y"], dtype=np.float64) for name in names("univariate")}
    for quantity, (certified, programs) in QUANTITIES.items():
        for name, sample in samples.items():
            right = exact(name, "univariate", certified)
            for program, function in programs.items():
                found = tried(function, sample)
                yield row(quantity, name, program, None if found is None else lre(float(found), right))
