"""Contrasts of condition means: which runs enter with which weights, and what comes of a campaign of known truth."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from benchmarks.worlds.conditions import condition
from data_schema.outcomes import Outcome
from data_schema.vocabulary import ContrastKind, Undefined
from labbook.analysis.comparison.contrasts import AskedContrast, contrast_result, contrasts_of
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.config.model import ContrastSettings, Side

GAINS = ("0", "50", "100", "200")
VALUES = {gain: float(gain) for gain in GAINS[1:]}
DAYS = [f"2026-03-{day:02d}" for day in range(1, 6)]
SAVED = {"large": 5.0, "small": 9.0}


RNG = np.random.default_rng(11)


def made(levels: dict[str, str], saved_percent: float, control_j: float = 40.0, a_day: int = 1) -> ConditionValues:
    """A condition whose runs, on five days, cost so much and hardly scatter."""
    values = control_j * (1.0 - saved_percent / 100.0) + RNG.normal(0.0, 1e-6, a_day * len(DAYS))
    return condition(levels, values.tolist(), DAYS * a_day, is_control=levels["b_ad_gain"] == "0")


def conditions(without: tuple[tuple[str, str, str], ...] = ()) -> list[ConditionValues]:
    """The small foot saves 4 points more, and each 100 of gain 2 more; controls differ by 3 J."""
    return [
        made(
            {"foot": foot, "k_gain": stiffness, "b_ad_gain": gain},
            0.0 if gain == "0" else SAVED[foot] + float(gain) / 50.0,
            43.0 if foot == "large" else 40.0,
        )
        for foot, stiffness, gain in itertools.product(("large", "small"), ("300", "400"), GAINS)
        if (foot, stiffness, gain) not in without
    ]


def asked(settings: ContrastSettings, of: list[ConditionValues] | None = None) -> list[AskedContrast]:
    return contrasts_of(settings, conditions() if of is None else of, "b_ad_gain", VALUES)


@pytest.mark.parametrize(
    ("settings", "truth", "unit"),
    [
        (ContrastSettings(ContrastKind.DIFFERENCE, Outcome.JOULES, "foot", Side.CONTROL), -3.0, "J"),
        (ContrastSettings(ContrastKind.INTERACTION, Outcome.JOULES, "foot"), 4.0, "%"),
        (ContrastSettings(ContrastKind.INTERACTION, Outcome.JOULES, "foot", levels=("small", "large")), -4.0, "%"),
        (ContrastSettings(ContrastKind.INTERACTION, Outcome.JOULES, "k_gain"), 0.0, "%"),
        (ContrastSettings(ContrastKind.TREND, Outcome.JOULES), 2.0, "%"),
        (ContrastSettings(ContrastKind.TREND, Outcome.JOULES, levels=("100", "200")), 2.0, "%"),
    ],
)
def test_the_truth_is_found(settings: ContrastSettings, truth: float, unit: str) -> None:
    (one,) = asked(settings)
    found = contrast_result(one, "b_ad_gain", 0.05).estimate
    assert found.value == pytest.approx(truth, abs=1e-4)
    assert found.unit == unit


def test_a_trend_is_for_a_power_of_ten_within_its_range() -> None:
    (one,) = asked(ContrastSettings(ContrastKind.TREND, Outcome.JOULES, levels=("50", "100")))
    assert one.per == 10.0
    assert contrast_result(one, "b_ad_gain", 0.05).estimate.value == pytest.approx(0.2, abs=1e-4)


def test_only_groups_that_hold_both_levels_enter_and_none_enters_where_none_does() -> None:
    small = tuple(("small", "400", gain) for gain in GAINS)
    (one,) = asked(ContrastSettings(ContrastKind.INTERACTION, Outcome.JOULES, "foot"), conditions(small))
    assert {pair.group["k_gain"] for _weight, pair in one.terms} == {"300"}
    one_foot = [each for each in conditions() if each.levels["foot"] == "large"]
    (none,) = asked(ContrastSettings(ContrastKind.INTERACTION, Outcome.JOULES, "foot"), one_foot)
    assert (none.levels, none.terms) == ((), ())
    named = ContrastSettings(ContrastKind.INTERACTION, Outcome.JOULES, "foot", levels=("large", "small"))
    (missing,) = asked(named, one_foot)
    assert isinstance(contrast_result(missing, "b_ad_gain", 0.05).p.value, Undefined)
    off, flat = asked(ContrastSettings(ContrastKind.LEVELS_OFF, Outcome.JOULES, at=50.0))
    assert (off.terms, len(flat.terms)) == ((), 12)


def test_an_interaction_is_that_of_the_levels_that_both_hold_however_many_runs_each_has() -> None:
    """Both feet save 4 % at 50 and 12 % at 200; of one foot three runs are at 50, of the other at 200."""
    saved = {"0": 0.0, "50": 4.0, "200": 12.0}
    found = [
        made({"foot": foot, "b_ad_gain": gain}, saved[gain], a_day=times)
        for foot, runs in (("large", (1, 3, 1)), ("small", (1, 1, 3)))
        for gain, times in zip(saved, runs, strict=True)
    ]
    interaction = ContrastSettings(ContrastKind.INTERACTION, Outcome.JOULES, "foot")
    (one,) = asked(interaction, found)
    assert contrast_result(one, "b_ad_gain", 0.05).estimate.value == pytest.approx(0.0, abs=1e-4)
    (fewer,) = asked(interaction, found[:5])  # the small foot has no run at 200
    assert contrast_result(fewer, "b_ad_gain", 0.05).estimate.value == pytest.approx(0.0, abs=1e-4)
    assert {pair.level for _weight, pair in fewer.terms} == {"50"}


def test_a_saving_that_rises_straight_in_every_group_does_not_level_off() -> None:
    """Groups rise by 1 and by 5 points for each 100; one lacks the upper levels."""
    gains = ("0", "100", "200", "300", "400")
    found = [
        made({"foot": foot, "b_ad_gain": gain}, slope * float(gain) / 100.0)
        for foot, slope, own in (("large", 1.0, gains[:3]), ("small", 5.0, gains))
        for gain in own
    ]
    settings = ContrastSettings(ContrastKind.LEVELS_OFF, Outcome.JOULES, at=200.0)
    off, flat = contrasts_of(settings, found, "b_ad_gain", {gain: float(gain) for gain in gains[1:]})
    assert contrast_result(off, "b_ad_gain", 0.05).estimate.value == pytest.approx(0.0, abs=1e-3)
    assert contrast_result(flat, "b_ad_gain", 0.05).estimate.value == pytest.approx(5.0, abs=1e-3)
    assert flat.levels == ("200", "300", "400")


def test_of_heights_differences_stand_in_place_of_savings() -> None:
    (one,) = asked(ContrastSettings(ContrastKind.TREND, Outcome.APEX))
    assert contrast_result(one, "b_ad_gain", 0.05).estimate.unit == "m"
