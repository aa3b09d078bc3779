"""The rows of `docs/statistics/digits.csv`: all of NIST's sets, and what a common offset costs.

`digits` is -log10 of the relative error, 0 to 15, against exact arithmetic on the same doubles: NIST's certified values
hold for its decimals, and rounding these to doubles alone costs SmLs07 to 09 eleven digits, which no program can give
back. Where the exact value is 0 (standard errors of Wampler1) the error itself counts. labbook fits Norris, Pontius,
Filip and Wampler's sets by `fit_polynomial` from x and the degree, NoInt and Longley by `fit_linear`; polyfit gets x
and the degree too, the others a matrix of powers. Filip's powers rounded to doubles cap every program that is given
them at about 8 digits. What scatters in Wampler2 is the rounding of its decimals alone, 1e-16 of y.
"""

from __future__ import annotations

from benchmarks.stats_evidence.digits import anova, offsets, regression, univariate
from benchmarks.stats_evidence.digits.lre import Row


def rows() -> list[Row]:
    """Return a row for each quantity, set and program; the same on every call."""
    return [*univariate.rows(), *anova.rows(), *regression.rows(), *offsets.rows()]
