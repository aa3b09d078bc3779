"""Mean, scatter and autocorrelation of NIST's sets, and the sums of squares that its analyses of variance rest on."""

from fractions import Fraction

import numpy as np
import pytest
from mpmath import log10, mpf

from stats.checks import as_sample
from stats.compare.summary import autocorrelation, describe
from stats.exact.numbers import moments
from stats.exact.tails import f_upper
from tests.helpers.nist import columns, digits, exact, groups, names

RIGHT = 14.0
"""Digits that hold of every number but a p-value: a relative error of 1e-14."""
RIGHT_OF_TAILS = 12.0


def of(fraction: Fraction) -> mpf:
    return mpf(fraction.numerator) / fraction.denominator


@pytest.mark.parametrize("decimals", [False, True])
@pytest.mark.parametrize("name", names("univariate"))
def test_mean_sd_and_autocorrelation(name, decimals):
    """On doubles against exact arithmetic on these; on decimals against the certified data, as no float program can."""
    values = columns(name)["y"] if decimals else np.array(columns(name)["y"], dtype=np.float64)
    found = describe(values)
    for quantity, number in (("mean", found.mean), ("sd", found.sd), ("autocorr_lag1", autocorrelation(values).r)):
        assert digits(number, exact(name, "univariate", quantity, decimals)) >= RIGHT, quantity


@pytest.mark.parametrize("decimals", [False, True])
@pytest.mark.parametrize("name", names("anova"))
def test_sums_of_squares_f_and_p(name, decimals):
    """scipy has 4 digits of SmLs07 to 09 on decimals rounded to doubles, and p = 0 for SmLs03, 06 and 09."""
    samples = [
        as_sample(group, values if decimals else np.array(values, dtype=np.float64))
        for group, values in groups(name).items()
    ]
    parts = [moments(sample.values, sample.rest) for sample in samples]
    n = sum(part.n for part in parts)
    grand = sum(part.n * part.exact_mean for part in parts) / n
    between = sum(part.n * (part.exact_mean - grand) ** 2 for part in parts)
    within = sum(part.exact_sum_squares for part in parts)
    df = (len(parts) - 1, n - len(parts))
    f = (between / df[0]) / (within / df[1])
    tail = f_upper(f, *df)
    for quantity, number in (("ss_between", between), ("ss_within", within), ("F", f)):
        assert digits(float(number), exact(name, "anova", quantity, decimals)) >= RIGHT, quantity
    p = exact(name, "anova", "p", decimals)
    if p > 1e-300:
        assert digits(tail.p, p) >= RIGHT_OF_TAILS
    assert digits(tail.log10_p, log10(p)) >= RIGHT
