"""Several groups: what has no test says why, and limits and sentences."""

from __future__ import annotations

import math
from typing import Any

import pytest

import stats
from data_schema.errors import InputRefused, UnknownName
from data_schema.vocabulary import Undefined
from stats.groups.tukey import VARIANCES, Variances
from tests.helpers.wording import says

GROUPS = {"0": [42.1, 39.8, 44.0], "50": [36.9, 38.2, 35.1, 37.7], "100": [37.0, 39.5]}
CONSTANT = {"a": [0.1] * 3, "b": [0.1] * 7, "c": [0.1] * 5}


@pytest.mark.parametrize(
    ("analyse", "route", "variances"),
    [(stats.one_way_anova, "student", "equal"), (stats.welch_anova, "welch", "unequal")],
)
def test_two_groups_are_a_t_test(analyse: Any, route: Any, variances: Variances) -> None:
    a, b = GROUPS["0"], GROUPS["50"]
    found, test = analyse({"a": a, "b": b}), stats.compare_two(a, b, route)
    assert (found.f, found.df_within, found.p) == pytest.approx((test.t**2, test.df, test.p))  # type: ignore[operator]
    (pair,) = stats.compare_all_pairs({"a": a, "b": b}, variances=variances).pairs
    assert (pair.p, pair.df, pair.difference) == pytest.approx((test.p, test.df, test.difference), rel=1e-12)
    assert pair.difference_ci == pytest.approx(test.difference_ci, rel=1e-11)


@pytest.mark.parametrize(
    ("groups", "reason"),
    [
        (CONSTANT, "no group has any scatter"),
        ({"a": [], "b": [1.0, 2.0], "c": [1.0, 3.0]}, "'a' is empty"),  # others report F of the rest
        ({"b": [1.0, 2.0]}, "at least 2 groups"),
    ],
)
def test_what_has_no_analysis_of_variance_says_why(groups: dict[str, list[float]], reason: str) -> None:
    for found in (stats.one_way_anova(groups), stats.welch_anova(groups)):
        assert isinstance(found.f, Undefined)
        assert reason in found.f.reason
        assert reason in found.sentence()
        assert found.p == found.omega_squared == found.f
    for few, why in (
        ({"a": [1.0], "b": [1.0, 2.0]}, "'a' has a single value"),
        ({"a": [1.0, 1.0], "b": [1.0, 1.0], "c": [1.0, 2.0]}, "with two such F has no limit"),
    ):
        assert why in stats.welch_anova(few).f.reason  # type: ignore[union-attr]


def test_groups_without_scatter_have_a_share_but_no_f() -> None:
    apart = stats.one_way_anova({"a": [1.0, 1.0], "b": [2.0, 2.0]})
    assert isinstance(apart.p, Undefined)
    assert apart.eta_squared == 1.0
    equal = stats.one_way_anova({"a": [0.1, 0.3], "b": [0.1, 0.3, 0.1, 0.3]})
    assert (equal.f, equal.p) == pytest.approx((0.0, 1.0), abs=1e-15)
    assert stats.one_way_anova({"a": [1.0, 3.0], "b": [2.0, 2.5]}).omega_squared == 0.0


@pytest.mark.parametrize("constant", ["0", "50", "100"])
def test_one_group_without_scatter_has_a_limit(constant: str) -> None:
    """scipy and statsmodels give nan, pingouin raises ValueError."""
    groups = {**GROUPS, constant: [38.0, 38.0, 38.0]}
    found, near = stats.welch_anova(groups), stats.welch_anova({**groups, constant: [38.0 - 1e-7, 38.0, 38.0 + 1e-7]})
    assert (found.f, found.df_within, found.p) == pytest.approx((near.f, near.df_within, near.p), rel=1e-8)
    assert found.constant_group == constant
    says(found.sentence(), "limit", constant)


@pytest.mark.parametrize("variances", VARIANCES)
def test_the_interval_of_a_pair_leaves_0_out_just_where_p_is_below_alpha(variances: Variances) -> None:
    found = stats.compare_all_pairs(GROUPS, variances=variances, level=0.9)
    for pair in found.pairs:
        assert isinstance(pair.difference_ci, tuple)
        assert isinstance(pair.p, float)
        assert (pair.difference_ci[0] > 0.0 or pair.difference_ci[1] < 0.0) == (pair.p < 0.1)
    assert [(pair.a, pair.b) for pair in found.pairs] == [("0", "50"), ("0", "100"), ("50", "100")]
    assert found.method == ("Tukey-Kramer" if variances == "equal" else "Games-Howell")
    says(found.sentence("J"), found.method, "9")


def test_pairs_without_a_test_say_why() -> None:
    for route in ("welch", "student", "f_then_t"):  # scipy gives p = 4.6e-6 for two groups of 0.04 alone
        assert isinstance(stats.compare_two([0.04] * 10, [0.04] * 30, route).p, Undefined)  # type: ignore[arg-type]
    for variances in VARIANCES:
        none = stats.compare_all_pairs(CONSTANT, variances=variances).pairs
        assert all(isinstance(pair.p, Undefined) and pair.difference == 0.0 for pair in none)
    empty = stats.compare_all_pairs({**GROUPS, "150": []}).pairs
    assert all(isinstance(pair.p, Undefined) and "'150' is empty" in pair.p.reason for pair in empty)
    single = stats.compare_all_pairs({"a": [1.0], "b": [1.0, 2.0, 4.0]}, variances="unequal").pairs[0]
    assert isinstance(single.p, Undefined)
    assert "single value" in single.p.reason
    assert stats.compare_all_pairs({"a": [1.0], "b": [1.0, 2.0, 4.0]}).pairs[0].df == 2.0
    assert "No pairs" in stats.compare_all_pairs({"a": [1.0]}).sentence()


def test_equal_variances_of_what_has_none() -> None:
    for groups, reason in (
        ({"a": [1.0, 2.0]}, "2 groups"),
        ({"a": [1.0], "b": [1.0, 2.0]}, "'a'"),
        ({"a": [], "b": [1.0, 2.0]}, "'a'"),
        ({"a": [0.1] * 4, "b": [0.2] * 4}, ""),
    ):
        found = stats.brown_forsythe(groups)
        assert isinstance(found.p, Undefined)
        assert reason in found.p.reason
    # distances that are equal but for rounding
    assert isinstance(stats.brown_forsythe([[0.1, 0.4, 0.1, 0.4], [0.2, 0.6, 0.2, 0.6]]).p, Undefined)
    assert isinstance(stats.brown_forsythe([[0.1, 0.4, 0.1, 0.4], [0.2, 0.3, 0.2]]).p, float)


def test_wrong_input_is_refused() -> None:
    for function in (stats.one_way_anova, stats.welch_anova, stats.compare_all_pairs, stats.brown_forsythe):
        with pytest.raises(InputRefused, match="group 'b'"):
            function({"a": [1.0, 2.0], "b": [1.0, math.inf]})  # type: ignore[operator]
        dropped = function({"a": [1.0, 2.0, math.nan], "b": [1.0, 4.0]}, missing="drop")  # type: ignore[operator]
        assert dropped.missing == 1
    with pytest.raises(UnknownName, match="equal"):
        stats.compare_all_pairs(GROUPS, variances="equl")  # type: ignore[arg-type]
    with pytest.raises(InputRefused, match="level"):
        stats.welch_anova(GROUPS, level=95.0)
