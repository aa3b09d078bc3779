"""One-way analysis of variance over the treated conditions of a group (thesis 5.2.1)."""

from collections.abc import Sequence

from scipy import stats

from labbook.scripts.templates.runs import Number, Runs, of_conditions, values_of

CONDITIONS: Sequence[str] = ()
"""The conditions whose means are compared."""


def analysis_of_variance(runs: Runs) -> Number:
    """Return F, the mean square between conditions over that within, and the upper tail of F."""
    found = stats.f_oneway(*(values_of(of_conditions(runs, [condition])) for condition in CONDITIONS))
    return {"f": float(found.statistic), "p": float(found.pvalue)}
