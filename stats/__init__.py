"""Arrays in, numbers out: statistics of runs, and jumps and apexes of height logs. No database, no files.

The functions that users call are here by name (`stats.compare_two(a, b)`); each is loaded when it is first asked for.
They return frozen results, whose fields may be undefined with a reason.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stats.apexes.detectors import find_jumps
    from stats.compare.effect_size import bayes_factor
    from stats.compare.equivalence import equivalence
    from stats.compare.savings import percent_savings
    from stats.compare.shared_error import SharedError, describe_shared, difference_with_shared
    from stats.compare.summary import autocorrelation, describe
    from stats.compare.two_sample import compare_two
    from stats.groups.anova import one_way_anova, welch_anova
    from stats.groups.dunnett import dunnett
    from stats.groups.multiple import holm
    from stats.groups.residuals import additive_residuals, normal_quantiles, residuals_of_groups, rmse_over_iqr
    from stats.groups.tukey import compare_all_pairs
    from stats.groups.variances import bartlett, brown_forsythe, f_test, levene
    from stats.lines.passive_drain import fit_passive_drain
    from stats.lines.regression import fit_linear, fit_polynomial
    from stats.lines.stiffness import fit_gain_line, fit_stiffness, force_points
    from stats.planning.power import (
        power_anova,
        power_by_day,
        power_equivalence,
        power_equivalence_by_day,
        power_t,
        power_welch,
        sample_size,
    )
    from stats.planning.power_percent import power_percent_equivalence

__all__ = [
    "SharedError",
    "additive_residuals",
    "autocorrelation",
    "bartlett",
    "bayes_factor",
    "brown_forsythe",
    "compare_all_pairs",
    "compare_two",
    "describe",
    "describe_shared",
    "difference_with_shared",
    "dunnett",
    "equivalence",
    "f_test",
    "find_jumps",
    "fit_gain_line",
    "fit_linear",
    "fit_passive_drain",
    "fit_polynomial",
    "fit_stiffness",
    "force_points",
    "holm",
    "levene",
    "normal_quantiles",
    "one_way_anova",
    "percent_savings",
    "power_anova",
    "power_by_day",
    "power_equivalence",
    "power_equivalence_by_day",
    "power_percent_equivalence",
    "power_t",
    "power_welch",
    "residuals_of_groups",
    "rmse_over_iqr",
    "sample_size",
    "welch_anova",
]

_MODULE_OF = {
    "find_jumps": "apexes.detectors",
    "bayes_factor": "compare.effect_size",
    "equivalence": "compare.equivalence",
    "percent_savings": "compare.savings",
    "SharedError": "compare.shared_error",
    "describe_shared": "compare.shared_error",
    "difference_with_shared": "compare.shared_error",
    "describe": "compare.summary",
    "compare_two": "compare.two_sample",
    "autocorrelation": "compare.summary",
    "one_way_anova": "groups.anova",
    "dunnett": "groups.dunnett",
    "holm": "groups.multiple",
    "normal_quantiles": "groups.residuals",
    "additive_residuals": "groups.residuals",
    "residuals_of_groups": "groups.residuals",
    "compare_all_pairs": "groups.tukey",
    "bartlett": "groups.variances",
    "brown_forsythe": "groups.variances",
    "f_test": "groups.variances",
    "levene": "groups.variances",
    "welch_anova": "groups.anova",
    "fit_gain_line": "lines.stiffness",
    "fit_passive_drain": "lines.passive_drain",
    "fit_polynomial": "lines.regression",
    "fit_linear": "lines.regression",
    "rmse_over_iqr": "groups.residuals",
    "fit_stiffness": "lines.stiffness",
    "force_points": "lines.stiffness",
    "power_anova": "planning.power",
    "power_equivalence": "planning.power",
    "power_t": "planning.power",
    "power_welch": "planning.power",
    "power_by_day": "planning.power",
    "power_equivalence_by_day": "planning.power",
    "power_percent_equivalence": "planning.power_percent",
    "sample_size": "planning.power",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'stats' has no attribute {name!r}")
    found = getattr(import_module(f"stats.{_MODULE_OF[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
