"""Arrays in, numbers out: statistics of runs, and jumps and apexes of height logs. No database, no files.

The functions that users call are here by name (`stats.compare_two(a, b)`); each is loaded when it is first asked for.
They return frozen results, whose fields may be undefined with a reason; `joules_per_jump`, a formula, returns a number.
"""

from __future__ import annotations

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stats.anova import one_way_anova
    from stats.apexes import find_jumps
    from stats.autocorrelation import autocorrelation
    from stats.bayes_factor import bayes_factor
    from stats.blocked import blocked_by_day
    from stats.dunnett import dunnett
    from stats.energy import energy_budget, joules_per_jump
    from stats.equivalence import equivalence
    from stats.gain_line import fit_gain_line
    from stats.multiple import holm
    from stats.normal_quantiles import normal_quantiles
    from stats.packing import fraction_from_height, fraction_from_mass, fraction_from_water, unbounded_fraction
    from stats.passive_drain import fit_passive_drain
    from stats.polynomial import fit_polynomial
    from stats.power import power_anova, power_equivalence, power_t, power_welch
    from stats.power_percent import power_percent_equivalence
    from stats.regression import fit_linear
    from stats.resampling import bootstrap_difference, permutation_test
    from stats.residuals import additive_residuals, residuals_of_groups
    from stats.rmse import rmse_over_iqr
    from stats.sample_size import sample_size
    from stats.savings import percent_savings
    from stats.shared_error import SharedError, describe_shared
    from stats.shared_test import difference_with_shared
    from stats.stiffness import fit_stiffness, force_points
    from stats.summary import describe
    from stats.tukey import compare_all_pairs
    from stats.two_sample import compare_two
    from stats.variances import bartlett, brown_forsythe, f_test, levene
    from stats.welch_anova import welch_anova

__all__ = [
    "SharedError",
    "additive_residuals",
    "autocorrelation",
    "bartlett",
    "bayes_factor",
    "blocked_by_day",
    "bootstrap_difference",
    "brown_forsythe",
    "compare_all_pairs",
    "compare_two",
    "describe",
    "describe_shared",
    "difference_with_shared",
    "dunnett",
    "energy_budget",
    "equivalence",
    "f_test",
    "find_jumps",
    "fit_gain_line",
    "fit_linear",
    "fit_passive_drain",
    "fit_polynomial",
    "fit_stiffness",
    "force_points",
    "fraction_from_height",
    "fraction_from_mass",
    "fraction_from_water",
    "holm",
    "joules_per_jump",
    "levene",
    "normal_quantiles",
    "one_way_anova",
    "percent_savings",
    "permutation_test",
    "power_anova",
    "power_equivalence",
    "power_percent_equivalence",
    "power_t",
    "power_welch",
    "residuals_of_groups",
    "rmse_over_iqr",
    "sample_size",
    "unbounded_fraction",
    "welch_anova",
]

_MODULE_OF = {
    "one_way_anova": "anova",
    "find_jumps": "apexes",
    "autocorrelation": "autocorrelation",
    "bayes_factor": "bayes_factor",
    "blocked_by_day": "blocked",
    "dunnett": "dunnett",
    "energy_budget": "energy",
    "joules_per_jump": "energy",
    "equivalence": "equivalence",
    "holm": "multiple",
    "fraction_from_height": "packing",
    "fraction_from_mass": "packing",
    "fraction_from_water": "packing",
    "unbounded_fraction": "packing",
    "fit_passive_drain": "passive_drain",
    "fit_polynomial": "polynomial",
    "power_anova": "power",
    "power_equivalence": "power",
    "power_percent_equivalence": "power_percent",
    "power_t": "power",
    "power_welch": "power",
    "sample_size": "sample_size",
    "fit_linear": "regression",
    "bootstrap_difference": "resampling",
    "permutation_test": "resampling",
    "additive_residuals": "residuals",
    "normal_quantiles": "normal_quantiles",
    "residuals_of_groups": "residuals",
    "rmse_over_iqr": "rmse",
    "percent_savings": "savings",
    "SharedError": "shared_error",
    "describe_shared": "shared_error",
    "difference_with_shared": "shared_test",
    "fit_gain_line": "gain_line",
    "fit_stiffness": "stiffness",
    "force_points": "stiffness",
    "describe": "summary",
    "compare_all_pairs": "tukey",
    "compare_two": "two_sample",
    "bartlett": "variances",
    "brown_forsythe": "variances",
    "f_test": "variances",
    "levene": "variances",
    "welch_anova": "welch_anova",
}


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'stats' has no attribute {name!r}")
    found = getattr(import_module(f"stats.{_MODULE_OF[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})


class _Package(ModuleType):
    """Keeps a function under its name where importing its module, which is called the same, would put that."""

    def __setattr__(self, name: str, value: Any) -> None:
        super().__setattr__(name, getattr(value, name) if _MODULE_OF.get(name) == name else value)


sys.modules[__name__].__class__ = _Package
