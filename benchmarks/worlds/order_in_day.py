"""Campaigns whose values drift over the day, by the order of their runs: controls first, at random, or as planned.

A warned reader goes by the estimate adjusted for position, others by that of the first page.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from benchmarks.worlds.conditions import condition
from benchmarks.worlds.world import Campaign, World, holds_truth
from data_schema.vocabulary import PlanMethod, Undefined
from labbook.analysis.comparison.deciding import contrast_of
from labbook.analysis.comparison.order import OVER_GROUPS, adjusted_for_position, favoured_by_order
from labbook.analysis.comparison.pairing import POOLED, Pair, group_label, pairs_pooled
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.plan.drawing import PlanFactor, draw_plan
from stats.days.decision import Estimate
from stats.days.overall import overall_savings

Days = Sequence[Sequence[tuple[str, bool]]]
"""The runs of each day in their order: group, and whether treated."""

CONTROL_J, RUN_SD_J, DAY_SD_J = 40.0, 2.0, 2.0
FIVE_DAYS = ((4, 11), (3, 11), (3, 11), (4, 12), (2, 5))
TWO_DAYS = ((8, 20), (8, 20))


def _controls_first(days: Sequence[tuple[int, int]], groups: int = 1) -> Callable[[np.random.Generator], Days]:
    order = [
        [
            (str(group), treated)
            for treated, n in ((False, control), (True, treated_n))
            for group in range(groups)
            for _run in range(n)
        ]
        for control, treated_n in days
    ]
    return lambda _rng: order


def _at_random(days: Sequence[tuple[int, int]], groups: int = 1) -> Callable[[np.random.Generator], Days]:
    order = _controls_first(days, groups)

    def drawn(rng: np.random.Generator) -> Days:
        return [[day[place] for place in rng.permutation(len(day))] for day in order(rng)]

    return drawn


def _planned(rng: np.random.Generator) -> Days:
    """A plan of one group: five days of 4 control and 8 treated runs."""
    factor = PlanFactor("b_ad", ("0", "100", "200"), control="0")
    plan = draw_plan([factor], 20, 12, PlanMethod.RANDOMISED, int(rng.integers(2**62)))
    return [[("0", dict(run.condition or ())["b_ad"] != "0") for run in day] for day in plan.days]


def _conditions(days: Days, saved_percent: float, drift_sd: float, rng: np.random.Generator) -> list[ConditionValues]:
    """Return the runs of days, whose joules grow by `drift_sd` standard deviations of runs from first to last."""
    runs: dict[tuple[str, bool], list[tuple[float, str, int]]] = {}
    for day, of_day in enumerate(days):
        of_the_day = rng.normal(0.0, DAY_SD_J)
        for place, (group, treated) in enumerate(of_day):
            mean = CONTROL_J * (1.0 - saved_percent / 100.0 * treated) + of_the_day
            drift = drift_sd * RUN_SD_J * place / (len(of_day) - 1)
            value = float(rng.normal(mean + drift, RUN_SD_J))
            runs.setdefault((group, treated), []).append((value, f"day {day}", place + 1))
    found = []
    for (group, treated), own in runs.items():
        values, labels, positions = zip(*own, strict=True)
        levels = {"group": group, "treated": str(treated)}
        found.append(condition(levels, values, labels, is_control=not treated, positions=positions))
    return found


def _estimate(pairs: Sequence[Pair]) -> Estimate:
    contrasts = {group_label(pair.group): contrast_of(pair) for pair in pairs}
    if len(contrasts) == 1:
        return next(iter(contrasts.values())).savings()
    return overall_savings(contrasts).estimate


def _campaign(
    order: Callable[[np.random.Generator], Days], saved_percent: float, drift_sd: float
) -> Callable[[np.random.Generator], Campaign]:
    def simulate(rng: np.random.Generator) -> Campaign:
        pairs = pairs_pooled(_conditions(order(rng), saved_percent, drift_sd, rng), "treated")
        assert all(pair.family == POOLED for pair in pairs)
        favoured = favoured_by_order(pairs, over_groups=True)
        warns = bool(favoured) if len(pairs) == 1 else OVER_GROUPS in favoured
        adjusted = adjusted_for_position(pairs)
        found = _estimate(adjusted if warns and not isinstance(adjusted, Undefined) else pairs)
        return Campaign(holds_truth(found.ci, saved_percent), holds_truth(found.ci, 0.0) is False, bool(favoured))

    return simulate


def _world(
    name: str, order: Callable[[np.random.Generator], Days], saved_percent: float, drift_sd: float, *, needed: bool
) -> World:
    drift = f"drift of {drift_sd:g} SD a day, {name}"
    return World(drift, f"{saved_percent:g} %", needed, _campaign(order, saved_percent, drift_sd))


WORLDS = (
    _world("controls first, 5 days", _controls_first(FIVE_DAYS), 0.0, 0.5, needed=True),
    _world("controls first, 5 days", _controls_first(FIVE_DAYS), 5.0, 1.0, needed=True),
    _world("controls first, 2 days", _controls_first(TWO_DAYS), 0.0, 1.0, needed=True),
    _world("controls first, 4 groups on 5 days", _controls_first(((1, 5),) * 5, 4), 5.0, 1.0, needed=True),
    _world("random order, 5 days", _at_random(FIVE_DAYS), 5.0, 1.0, needed=False),
    _world("random order, 2 days", _at_random(TWO_DAYS), 0.0, 1.0, needed=False),
    _world("random order, 4 groups on 5 days", _at_random(((1, 5),) * 5, 4), 5.0, 1.0, needed=False),
    _world("planned order, 5 days", _planned, 0.0, 1.0, needed=False),
)
