"""NIST's sets that a lab meets: the library's digits, which docs/statistics.md tells."""

from __future__ import annotations

import numpy as np
import pytest

from stats.compare.summary import autocorrelation, describe
from stats.groups.anova import one_way_anova
from stats.lines.regression import fit_linear
from tests.helpers.nist import columns, digits, exact, groups, names

DIGITS = 12.0
"""Of sets with values of up to seven constant leading digits; more of them leave doubles fewer."""
AT_AN_OFFSET = {"SmLs07": 3.0, "SmLs08": 2.5, "SmLs09": 2.5, "NumAcc4": 8.0}
"""Thirteen leading digits are the same (nine of NumAcc4): so many are left in the doubles that are given."""


@pytest.mark.parametrize("name", names("univariate"))
def test_mean_sd_and_autocorrelation(name: str) -> None:
    values = np.array(columns(name)["y"], dtype=np.float64)
    found = describe(values)
    for quantity, number in (("mean", found.mean), ("sd", found.sd), ("autocorr_lag1", autocorrelation(values))):
        assert digits(number, exact(name, "univariate", quantity)) >= DIGITS, quantity  # type: ignore[arg-type]


@pytest.mark.parametrize("name", names("anova"))
def test_analysis_of_variance(name: str) -> None:
    found = one_way_anova({group: np.array(values, dtype=np.float64) for group, values in groups(name).items()})
    for quantity, number in (("F", found.f), ("r_squared", found.eta_squared), ("residual_sd", found.residual_sd)):
        assert digits(number, exact(name, "anova", quantity)) >= DIGITS, quantity  # type: ignore[arg-type]
        certified = digits(number, exact(name, "anova", quantity, decimals=True))  # type: ignore[arg-type]
        assert certified >= AT_AN_OFFSET.get(name, 8.0), quantity


LINES = {"Norris": 1, "Pontius": 2, "Wampler1": 5, "Wampler2": 5, "Wampler3": 5, "NoInt1": 0, "NoInt2": 0, "Longley": 0}
OF_LINES = {"Norris": 12.0, "Pontius": 11.0, "Wampler1": 7.5, "Wampler2": 10.0, "Wampler3": 7.5, "Longley": 11.0}
"""Powers of x up to the fifth are collinear by a part in 1e5 after centring, and cost so many digits."""


@pytest.mark.parametrize("name", LINES)
def test_lines(name: str) -> None:
    table = {key: np.array(values, dtype=np.float64) for key, values in columns(name).items()}
    y, given = table.pop("y"), table
    if LINES[name]:
        (x,) = given.values()
        given = {f"x{power}": x**power for power in range(1, LINES[name] + 1)}
    fit = fit_linear(y, given, intercept=not name.startswith("NoInt"))
    for number, value in enumerate(fit.coefficients, 1 if name.startswith("NoInt") else 0):
        assert digits(value, exact(name, "linear", f"B{number}")) >= OF_LINES.get(name, DIGITS)
