"""Mean, scatter, autocorrelation and analysis of variance of NIST's sets."""

from functools import partial

import numpy as np
import pytest
from mpmath import log10

from stats.compare.summary import autocorrelation, describe
from stats.groups.anova import one_way_anova
from tests.helpers.nist import columns, digits, exact, groups, names

RIGHT = 14.0
"""Digits that hold of every number: a relative error of 1e-14."""


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
def test_analysis_of_variance(name, decimals):
    """At an offset of 1e12 (SmLs07 to 09) statsmodels and pingouin keep 2 to 3 digits of F, the textbook formula none.

    Where p is 2.1e-2477 (SmLs03, 06 and 09) every library gives 0, and minus infinity for its logarithm.
    """
    found = one_way_anova(
        {group: values if decimals else np.array(values, dtype=np.float64) for group, values in groups(name).items()}
    )
    right = partial(exact, name, "anova", decimals=decimals)
    for quantity, number in (
        ("F", found.f),
        ("ss_between", found.ss_between),
        ("ss_within", found.ss_within),
        ("r_squared", found.eta_squared),
        ("residual_sd", found.residual_sd),
    ):
        assert digits(number, right(quantity)) >= RIGHT, quantity
    assert (found.df_between, found.df_within) == (right("df_between"), right("df_within"))
    p = right("p")
    assert digits(found.log10_p, log10(p)) >= RIGHT
    if p > 1e-300:
        assert found.p == pytest.approx(float(p), rel=1e-14)
    else:
        assert found.p == 0.0
        assert -2477.0 < found.log10_p < -2476.0
