"""The effect over all groups: mean saving, its test, whether groups saved the same, and equivalence of heights."""

import math
from collections.abc import Mapping

from labbook.analysis.comparison.deciding import contrast_of
from labbook.analysis.comparison.order import ADJUSTED
from labbook.analysis.comparison.pairing import group_label
from labbook.scripts.facts import Facts, conditions_in, keys_of
from labbook.scripts.script import Asked, Script
from labbook.scripts.tables import reading_of, rows_of
from stats.days.overall import overall_savings

_STEPS = {
    "savings": "overall.overall_savings",
    "t": "overall.overall_t",
    "p": "overall.overall_p",
    "spread": "overall.spread",
    "heterogeneity_p": "overall.heterogeneity_p",
}
_WITHIN = {
    "estimate": "overall.overall_change",
    "t_low": "overall.overall_t_low",
    "p_low": "overall.overall_p_low",
    "t_high": "overall.overall_t_high",
    "p_high": "overall.overall_p_high",
    "p": "overall.overall_p_of_both",
}


def script(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of a number of the mean saving over groups."""
    settings = facts.planned.settings
    about = {"LEVEL": 1.0 - settings.outside, "ONE_SIDED_OVERALL": settings.one_sided}
    return _script(asked, facts, _STEPS.get(asked.name), about)


def script_of_equivalence(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of a number of the equivalence test over groups."""
    bounds = facts.planned.settings.apex_bounds
    if bounds is None:
        return None
    about = {
        "LEVEL": 1.0 - 2.0 * facts.planned.settings.alpha,
        "LOWEST_CHANGE": -math.inf if bounds.low is None else bounds.low,
        "HIGHEST_CHANGE": math.inf if bounds.high is None else bounds.high,
    }
    return _script(asked, facts, _WITHIN.get(asked.name), about)


def _script(asked: Asked, facts: Facts, step: str | None, about: Mapping[str, object]) -> Script | None:
    if step is None:
        return None
    pooled, adjusted = facts.pooled(asked.outcome), asked.variant == ADJUSTED
    compared = facts.pooled(asked.outcome, ADJUSTED) if adjusted else pooled
    contrasts = {group_label(pair.group): contrast_of(pair) for pair in compared}
    claimed = overall_savings(contrasts).scope.groups
    groups = {group_label(pair.group): keys_of(pair) for pair in pooled}
    settings = {
        **facts.settings,
        **about,
        "CLAIMED": {name: pair for name, pair in groups.items() if name in claimed},
        "GROUPS": groups,
    }
    wanted = [pair for pair in pooled if adjusted or group_label(pair.group) in claimed]
    rows = rows_of(facts, conditions_in(wanted), asked.outcome)
    steps = [reading_of(asked.outcome), *(["position.at_mean_position"] if adjusted else []), step]
    return Script(rows, steps, settings)
