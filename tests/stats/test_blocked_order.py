"""Conditions told in an order of the caller's: every number is that of the same design with names in that order."""

from __future__ import annotations

from typing import Any

import pytest

from data_schema.errors import InputRefused
from stats.days.blocked import blocked_by_day
from stats.days.blocked_result import BlockedByDay, ExactTest
from tests.helpers.wording import says

NAMES = ["gain 1", "gain 2", "gain 9", "gain 10", "gain 10, old"]
DAYS = {"a": 0.0, "b": 1.4, "c": -1.1, "d": 2.6}
"""What days add to all their values."""
SHARED = dict.fromkeys(NAMES, "abc")
PARTLY = dict(zip(NAMES, ("ab", "bc", "cd", "ad", "abd"), strict=True))
APART = dict(zip(NAMES, ("ab", "ab", "cd", "cd", "ab"), strict=True))


def by_day(days_of: dict[str, str], names: list[Any], **how: Any) -> BlockedByDay:
    """Conditions called `names`; those further on were measured more often, so that nothing is balanced."""
    rows = [
        (place + 0.3 * turn + DAYS[day] + 0.05 * (place * turn) ** 2, name, day)
        for place, (name, days) in enumerate(zip(names, days_of.values(), strict=True))
        for day in days
        for turn in range(2 + (place > 1) + (day == "a"))
    ]
    values, conditions, days = zip(*rows, strict=True)
    return blocked_by_day(values, conditions, days, **how)


def test_the_order_that_words_have_anyhow_changes_no_bit() -> None:
    for days_of in (SHARED, PARTLY, APART):
        assert by_day(days_of, NAMES, order=sorted(NAMES)) == by_day(days_of, NAMES)
    assert by_day(SHARED, [10, 9, 2, 1, 100], order=[1, 2, 9.0, "10", 100]) == by_day(SHARED, [10, 9, 2, 1, 100])


@pytest.mark.parametrize("days_of", [SHARED, PARTLY, APART])
def test_all_is_told_in_the_order_given(days_of: dict[str, str]) -> None:
    found, numbered = by_day(days_of, NAMES, order=NAMES), by_day(days_of, [*range(5)])
    assert found != by_day(days_of, NAMES)
    assert [one.condition for one in found.conditions] == NAMES
    assert [(one.condition, one.control) for one in found.contrasts] == [(name, NAMES[0]) for name in NAMES[1:]]
    assert [one.estimate for one in found.conditions] == [one.estimate for one in numbered.conditions]
    assert [(one.t, one.p) for one in found.contrasts] == [(one.t, one.p) for one in numbered.contrasts]
    assert (found.mixed.p, found.mixed.lmertest_df_within, found.mixed.lmertest_p) == (
        numbered.mixed.p,
        numbered.mixed.lmertest_df_within,
        numbered.mixed.lmertest_p,
    )
    assert isinstance(found.exact, ExactTest) == isinstance(numbered.exact, ExactTest) == (days_of is not APART)
    if isinstance(found.exact, ExactTest) and isinstance(numbered.exact, ExactTest):
        assert [one.condition for one in found.exact.contrasts] == NAMES[1:]
        assert [one.p for one in found.exact.contrasts] == [one.p for one in numbered.exact.contrasts]


def test_conditions_without_shared_days_are_listed_in_the_order_given() -> None:
    says(by_day(APART, NAMES).confounding.text, "no day joins", "10", "2", "9")
    told = by_day(APART, NAMES, order=NAMES).confounding.text
    says(told, "no day joins", "2", "10", "9")
    turned = by_day(APART, NAMES, order=NAMES[::-1]).confounding.text
    says(turned, "no day joins", "10", "2", "9")


def test_lmertests_test_goes_by_the_order() -> None:
    one, other = by_day(PARTLY, NAMES, order=NAMES), by_day(PARTLY, NAMES, order=NAMES[::-1])
    assert one.mixed.lmertest_df_within != pytest.approx(other.mixed.lmertest_df_within, rel=1e-3)
    assert (one.mixed.f, one.mixed.df_within) == pytest.approx((other.mixed.f, other.mixed.df_within), rel=1e-10)


def test_a_control_stands_before_the_order() -> None:
    found = by_day(SHARED, NAMES, order=NAMES, control="gain 9")
    assert [one.condition for one in found.conditions] == ["gain 9", "gain 1", "gain 2", "gain 10", "gain 10, old"]
    assert {one.control for one in found.contrasts} == {"gain 9"}


@pytest.mark.parametrize(
    ("order", "fault"),
    [
        (NAMES[:-1], "it lacks 'gain 10, old'; give"),
        ([*NAMES, "gain 3"], "no value has 'gain 3'; give"),
        ([*NAMES, NAMES[0]], "it repeats 'gain 1'; give"),
        ([*NAMES[1:], float("nan")], "it lacks 'gain 1' and no value has None; give"),
        ("gain 1", "it lacks 'gain 2', 'gain 9', 'gain 10', 'gain 10, old'; give"),
    ],
)
def test_an_order_of_other_conditions_is_refused(order: Any, fault: str) -> None:
    with pytest.raises(InputRefused) as refused:
        by_day(SHARED, NAMES, order=order)
    told = str(refused.value).replace("'gain 10', 'gain 10, old', 'gain 2', 'gain 9'", "all others")
    expected = fault.replace("'gain 2', 'gain 9', 'gain 10', 'gain 10, old'", "all others")
    says(told, "order is not", expected, "every condition that")
