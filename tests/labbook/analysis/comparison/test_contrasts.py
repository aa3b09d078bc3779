"""Contrasts of condition means: which runs enter with which weights, and what comes of a campaign of known truth."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from benchmarks.stats_evidence.worlds.conditions import condition
from data_schema.outcomes import Outcome
from data_schema.vocabulary import ContrastKind
from labbook.analysis.comparison.contrasts import MeansContrast, contrast_result, contrasts_of
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.config.model import ContrastSettings, Side

GAINS = ("0", "50", "100", "200")
VALUES = {gain: float(gain) for gain in GAINS[1:]}
DAYS = [f"2026-03-{day:02d}" for day in range(1, 6)]
SAVED = {"large": 5.0, "small": 9.0}


def joules(foot: str, stiffness: str, gain: str) -> float:
    """The small foot saves 4 points more, and each 100 of gain 2 more; controls differ by 3 J."""
    saved = 0.0 if gain == "0" else SAVED[foot] + float(gain) / 50.0
    return (43.0 if foot == "large" else 40.0) * (1.0 - saved / 100.0)


def conditions(without: tuple[tuple[str, str, str], ...] = ()) -> list[ConditionValues]:
    rng = np.random.default_rng(11)
    return [
        condition(
            {"foot": foot, "k_gain": stiffness, "b_ad_gain": gain},
            (joules(foot, stiffness, gain) + rng.normal(0.0, 1e-6, len(DAYS))).tolist(),
            DAYS,
            is_control=gain == "0",
        )
        for foot, stiffness, gain in itertools.product(("large", "small"), ("300", "400"), GAINS)
        if (foot, stiffness, gain) not in without
    ]


def asked(settings: ContrastSettings, of: list[ConditionValues] | None = None) -> list[MeansContrast]:
    return contrasts_of(settings, conditions() if of is None else of, "b_ad_gain", VALUES)


@pytest.mark.parametrize(
    ("settings", "truth", "unit"),
    [
        (ContrastSettings(ContrastKind.DIFFERENCE, Outcome.JOULES, "foot", Side.CONTROL), -3.0, "J"),
        (ContrastSettings(ContrastKind.INTERACTION, Outcome.JOULES, "foot"), 4.0, "%"),
        (ContrastSettings(ContrastKind.INTERACTION, Outcome.JOULES, "foot", levels=("small", "large")), -4.0, "%"),
        (ContrastSettings(ContrastKind.INTERACTION, Outcome.JOULES, "k_gain"), 0.0, "%"),
        (ContrastSettings(ContrastKind.POOLED, Outcome.JOULES), 7.0 + 350.0 / 150.0, "%"),
        (ContrastSettings(ContrastKind.TREND, Outcome.JOULES), 2.0, "%"),
        (ContrastSettings(ContrastKind.TREND, Outcome.JOULES, levels=("100", "200")), 2.0, "%"),
        (ContrastSettings(ContrastKind.LEVELS_OFF, Outcome.JOULES, at=100.0), 0.0, "%"),
    ],
)
def test_the_truth_is_found(settings: ContrastSettings, truth: float, unit: str) -> None:
    (one,) = asked(settings)
    found = contrast_result(one, 0.05).estimate
    assert found.value == pytest.approx(truth, abs=1e-4)
    assert found.unit == unit


def test_a_trend_is_for_a_power_of_ten_within_its_range() -> None:
    (one,) = asked(ContrastSettings(ContrastKind.TREND, Outcome.JOULES, levels=("50", "100")))
    assert one.per == 10.0
    assert contrast_result(one, 0.05).estimate.value == pytest.approx(0.2, abs=1e-4)


def test_only_groups_that_hold_both_levels_enter_and_none_enters_where_none_does() -> None:
    small = tuple(("small", "400", gain) for gain in GAINS)
    (one,) = asked(ContrastSettings(ContrastKind.INTERACTION, Outcome.JOULES, "foot"), conditions(small))
    assert {pair.group["k_gain"] for _weight, pair in one.terms} == {"300"}
    one_foot = [each for each in conditions() if each.levels["foot"] == "large"]
    assert asked(ContrastSettings(ContrastKind.INTERACTION, Outcome.JOULES, "foot"), one_foot) == []
    assert asked(ContrastSettings(ContrastKind.LEVELS_OFF, Outcome.JOULES, at=50.0)) == []


def test_of_heights_differences_stand_in_place_of_savings() -> None:
    (one,) = asked(ContrastSettings(ContrastKind.TREND, Outcome.APEX))
    assert contrast_result(one, 0.05).estimate.unit == "m"
