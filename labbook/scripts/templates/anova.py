"""One-way analysis of variance over the treated conditions of a group (thesis 5.2.1)."""

from collections.abc import Sequence

from scipy import stats

from labbook.scripts.templates.runs import Number, Runs, of_conditions, values_of

CONDITIONS: Sequence[str] = ()
"""The conditions whose means are compared."""


def analysed(runs: Runs) -> tuple[float, float]:
    """Return F, the mean square between conditions over that within, and the upper tail of F."""
    found = stats.f_oneway(*(values_of(of_conditions(runs, [condition])) for condition in CONDITIONS))
    return float(found.statistic), float(found.pvalue)


def anova_f(runs: Runs) -> Number:
    """Return F."""
    return {"value": analysed(runs)[0]}


def anova_p(runs: Runs) -> Number:
    """Return p."""
    return {"value": analysed(runs)[1]}
