"""Two feet, two stiffnesses and six gains: interactions and trends of savings of known truth."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.worlds.conditions import condition
from benchmarks.worlds.world import Campaign, World
from data_schema.outcomes import Outcome
from data_schema.vocabulary import ContrastKind
from labbook.analysis.comparison.contrasts import contrast_result, contrasts_of
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.config.model import ContrastSettings

GAINS = ("0", "100", "200", "300", "400", "500")
VALUES = {gain: float(gain) for gain in GAINS[1:]}
INTERACTION = ContrastSettings(ContrastKind.INTERACTION, Outcome.JOULES, "foot", levels=("large", "small"))
TREND = ContrastSettings(ContrastKind.TREND, Outcome.JOULES)
LEVELS_OFF = ContrastSettings(ContrastKind.LEVELS_OFF, Outcome.JOULES, at=300.0)


def draw(
    rng: np.random.Generator,
    days: int,
    *,
    runs: int = 1,
    by_foot: float = 0.0,
    slope: float = 0.0,
    off: bool = False,
    unlike: bool = False,
) -> list[ConditionValues]:
    """Draw a campaign: every day holds every condition; days act on all, on feet and on gains.

    Percents saved: 8, `by_foot` more with the small foot, and `slope` more for each 100 of gain, up to 300 where it
    levels `off`. Cells are `unlike` where the small foot has three times the runs at gains above 200, and none at 500.
    """
    found = []
    of_day = rng.normal(0.0, 0.05, days)
    for foot in ("small", "large"):
        of_foot = rng.normal(0.0, 0.02, days)
        for stiffness in ("300", "400"):
            for gain in GAINS[:-1] if unlike and foot == "small" else GAINS:
                times = 3 * runs if unlike and foot == "small" and float(gain) > 200.0 else runs
                labels = [f"2026-03-{day + 1:02d}" for day in range(days) for _ in range(times)]
                hundreds = min(float(gain), 300.0 if off else 500.0) / 100.0
                saved = 0.0 if gain == "0" else 8.0 + by_foot * (foot == "small") + slope * hundreds
                level = 40.0 * (1.0 + 0.1 * (foot == "small")) * (1.0 - saved / 100.0)
                both = 1.0 + np.repeat(of_day + of_foot + rng.normal(0.0, 0.01, days), times)
                values = level * (both + rng.normal(0.0, 0.04 if gain == "0" else 0.03, days * times))
                levels = {"foot": foot, "k_gain": stiffness, "b_ad_gain": gain}
                found.append(condition(levels, values.tolist(), labels, is_control=gain == "0"))
    return found


def campaign(conditions: list[ConditionValues], asked: ContrastSettings, truth: float) -> Campaign:
    """Put a campaign through the contrast that was asked for, as a report does."""
    one, *_flat = contrasts_of(asked, conditions, "b_ad_gain", VALUES)
    found = contrast_result(one, "b_ad_gain", 0.05)
    low, high = found.estimate.ci_low, found.estimate.ci_high
    covers = low <= truth <= high if isinstance(low, float) and isinstance(high, float) else None
    return Campaign(covers, found.rejected is True, warns=False)


def _world(what: str, asked: ContrastSettings, truth: float, days: int, **how: Any) -> World:
    runs = 1 if days > 3 else 2
    return World(
        f"{what}, {days} days",
        f"{truth:g} points",
        False,
        lambda rng: campaign(draw(rng, days, runs=runs, **how), asked, truth),
    )


WORLDS = (
    _world("2 x 2 x 6: interaction with the foot", INTERACTION, 0.0, 5),
    _world("2 x 2 x 6: interaction with the foot", INTERACTION, 3.0, 5, by_foot=3.0),
    _world("2 x 2 x 6: interaction with the foot", INTERACTION, 3.0, 2, by_foot=3.0),
    _world("2 x 2 x 6, unlike cells: interaction with the foot", INTERACTION, 0.0, 5, slope=1.9, unlike=True),
    _world("2 x 2 x 6: trend for each 100 of gain", TREND, 0.0, 5),
    _world("2 x 2 x 6: trend for each 100 of gain", TREND, 1.9, 5, slope=1.9),
    _world("2 x 2 x 6: trend levels off at 300", LEVELS_OFF, 1.9, 5, slope=1.9, off=True),
)
