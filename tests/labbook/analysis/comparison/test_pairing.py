"""The families of comparisons of the thesis (5.2.1) come of any study with a control."""

from __future__ import annotations

import itertools

from labbook.analysis.comparison.pairing import BETWEEN, pairs_between
from labbook.analysis.outcomes.conditions import ConditionSummary, ConditionValues
from reports.numbers import Number

NONE = Number(0.0, "J")
GAINS = ("0", "50", "100", "150", "200", "250")


def conditions() -> list[ConditionValues]:
    return [
        ConditionValues(
            f"{foot} {stiffness} {gain}",
            gain == "0",
            {"foot": foot, "k_gain": stiffness, "b_ad_gain": gain},
            (),
            ConditionSummary(NONE, NONE, ()),
        )
        for foot, stiffness, gain in itertools.product(("large", "small"), ("300", "400"), GAINS)
    ]


def test_feet_are_compared_at_every_level_of_active_damping_as_well_as_pooled() -> None:
    found = [pair for pair in pairs_between(conditions(), "b_ad_gain") if pair.family == BETWEEN.format(factor="foot")]
    sides = [
        (pair.group["k_gain"], tuple(side.levels["b_ad_gain"] for side in pair.a), tuple(side.key for side in pair.b))
        for pair in found
    ]
    wanted = [GAINS[1:], *((gain,) for gain in GAINS)]
    assert sides == [
        (stiffness, gains, tuple(f"small {stiffness} {gain}" for gain in gains))
        for stiffness in ("300", "400")
        for gains in wanted
    ]
    assert [pair.level for pair in found[:3]] == ["small, treated", "small, control", "small, b_ad_gain 50"]


def test_one_treated_level_is_compared_once() -> None:
    few = [item for item in conditions() if item.levels["b_ad_gain"] in ("0", "50")]
    found = [pair for pair in pairs_between(few, "b_ad_gain") if pair.family == BETWEEN.format(factor="foot")]
    assert len(found) == 4  # treated and control, at two stiffnesses


def test_a_pair_between_levels_names_what_its_difference_is_of() -> None:
    """The reference is the level that was run first, whatever labbook.toml has first."""
    for turned in (conditions(), list(reversed(conditions()))):
        pairs = [pair for pair in pairs_between(turned, "b_ad_gain") if pair.family == BETWEEN.format(factor="foot")]
        assert pairs
        for pair in pairs:
            assert pair.between is not None
            assert {one.levels["foot"] for one in pair.a} == {pair.between.against}
            assert {one.levels["foot"] for one in pair.b} == {pair.between.level}
            at_one_level = pair.between.side not in ("treated", "control")
            assert pair.between.at == (pair.a[0].levels["b_ad_gain"] if at_one_level else "")
    assert {pair.between.against for pair in pairs if pair.between} != {conditions()[0].levels["foot"]}
