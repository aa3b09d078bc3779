"""Arrays in, numbers out: statistics of runs, and jumps and apexes of height logs. No database, no files.

The functions that users call are here by name (`stats.compare_two(a, b)`); each is loaded when it is first asked for.
They return frozen results, whose fields may be undefined with a reason.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stats.apexes.detectors import find_jumps, jump_at
    from stats.compare.agreement import cohen_kappa, limits_of_agreement, rmse_over_iqr
    from stats.compare.shared_error import SharedError, describe_shared
    from stats.compare.summary import autocorrelation, describe
    from stats.compare.two_sample import compare_two
    from stats.days.contrasts import linear_contrast
    from stats.days.decision import contrast_by_day
    from stats.groups.anova import one_way_anova, welch_anova
    from stats.groups.multiple import holm
    from stats.groups.tukey import compare_all_pairs
    from stats.groups.variances import brown_forsythe
    from stats.lines.passive_drain import fit_passive_drain
    from stats.lines.regression import fit_linear, slope_through_origin
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

_MODULE_OF = {
    "find_jumps": "apexes.detectors",
    "jump_at": "apexes.detectors",
    "cohen_kappa": "compare.agreement",
    "limits_of_agreement": "compare.agreement",
    "SharedError": "compare.shared_error",
    "describe_shared": "compare.shared_error",
    "autocorrelation": "compare.summary",
    "describe": "compare.summary",
    "compare_two": "compare.two_sample",
    "linear_contrast": "days.contrasts",
    "contrast_by_day": "days.decision",
    "one_way_anova": "groups.anova",
    "welch_anova": "groups.anova",
    "holm": "groups.multiple",
    "rmse_over_iqr": "compare.agreement",
    "compare_all_pairs": "groups.tukey",
    "brown_forsythe": "groups.variances",
    "fit_passive_drain": "lines.passive_drain",
    "fit_linear": "lines.regression",
    "slope_through_origin": "lines.regression",
    "fit_gain_line": "lines.stiffness",
    "fit_stiffness": "lines.stiffness",
    "force_points": "lines.stiffness",
    "power_anova": "planning.power",
    "power_by_day": "planning.power",
    "power_equivalence": "planning.power",
    "power_equivalence_by_day": "planning.power",
    "power_t": "planning.power",
    "power_welch": "planning.power",
    "sample_size": "planning.power",
}
__all__ = [
    "SharedError",
    "autocorrelation",
    "brown_forsythe",
    "cohen_kappa",
    "compare_all_pairs",
    "compare_two",
    "contrast_by_day",
    "describe",
    "describe_shared",
    "find_jumps",
    "fit_gain_line",
    "fit_linear",
    "fit_passive_drain",
    "fit_stiffness",
    "force_points",
    "holm",
    "jump_at",
    "limits_of_agreement",
    "linear_contrast",
    "one_way_anova",
    "power_anova",
    "power_by_day",
    "power_equivalence",
    "power_equivalence_by_day",
    "power_t",
    "power_welch",
    "rmse_over_iqr",
    "sample_size",
    "slope_through_origin",
    "welch_anova",
]


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'stats' has no attribute {name!r}")
    found = getattr(import_module(f"stats.{_MODULE_OF[name]}"), name)
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
