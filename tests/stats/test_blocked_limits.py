"""What a design of conditions and days cannot tell, and that it is said."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest

from data_schema.errors import InputRefused, UnknownName
from data_schema.vocabulary import Undefined
from stats.checks import as_labels
from stats.compare.resampling import permutation_test
from stats.compare.two_sample import compare_two
from stats.days.blocked import blocked_by_day
from tests.helpers.wording import refuses, says


def test_one_day_a_condition_has_no_p():
    found = blocked_by_day([1.0, 1.1, 0.9, 2.0, 2.2, 2.1], list("aaabbb"), ["mon"] * 3 + ["tue"] * 3)
    contrast = found.contrasts[0]
    assert contrast.difference == pytest.approx(1.1)
    for undefined in (contrast.p, contrast.se, contrast.interval, found.p, found.f, found.day_variance):
        assert isinstance(undefined, Undefined)
        assert "day" in undefined.reason
    assert isinstance(found.exact, Undefined)
    says(found.sentence("J"), "conditions on shared")
    says(found.sentence("J"), "difference between days")


def test_conditions_on_their_own_days_say_what_counts_as_an_observation():
    """Where REML puts the days' variance at 0, all 8 values count: no day is one observation then."""
    condition, day = list("aabbbbcc"), list("11112233")
    alike = blocked_by_day([1, 3, 2, 4, 2.5, 3.5, 1.5, 4.5], condition, day)
    assert (alike.day_variance, alike.mixed.contrasts[1].df) == (0.0, pytest.approx(5.0))
    says(alike.confounding.text, "0", "count as independent")
    assert "one observation" not in alike.sentence()
    apart = blocked_by_day([1, 1.3, 2, 2.4, 3.5, 3.6, 6.5, 6.1], condition, day)
    assert apart.day_variance > 0.0
    says(apart.confounding.text, "count as independent")
    runs = blocked_by_day(
        [1, 1.1, 3, 3.2, 1.2, 1, 3.1, 3, 2, 2.1], list("aaaaaaaabb"), list("1111222233"), list("1122112211")
    )
    assert runs.day_variance == 0.0 < runs.run_variance
    says(runs.confounding.text, "0", "count as independent")


def test_one_day_compares_within_it_and_says_nothing_of_other_days():
    values, condition = [1.0, 1.1, 0.9, 2.0, 2.2, 2.1], list("aaabbb")
    found = blocked_by_day(values, condition, [1] * 6)
    student = compare_two(values[3:], values[:3], route="student")
    assert found.contrasts[0].p == pytest.approx(student.p, rel=1e-12)
    assert isinstance(found.conditions[0].se, Undefined)
    assert "one day only" in found.conditions[0].se.reason


def test_runs_that_cannot_be_told_apart_are_said_and_left_out():
    values, condition, day = [1.0, 1.2, 2.0, 2.3, 1.4, 1.1, 2.6, 2.2], list("aabbaabb"), [1] * 4 + [2] * 4
    one_a_day = blocked_by_day(values, condition, day, day)
    assert "one run" in one_a_day.notes[0].text
    assert isinstance(one_a_day.run_variance, Undefined)
    single = blocked_by_day(values, condition, day, list(range(8)))
    assert "one value" in single.notes[0].text
    plain = blocked_by_day(values, condition, day)
    assert one_a_day.p == single.p == plain.p
    days = blocked_by_day(values, condition, range(8))
    says(days.notes[0].text, "values are compared")
    student = compare_two([2.0, 2.3, 2.6, 2.2], [1.0, 1.2, 1.4, 1.1], route="student")
    assert days.p == pytest.approx(student.p, rel=1e-12)
    no_runs = blocked_by_day([1.0, 1.2, 2.0, 2.3], list("aabb"), [1] * 4, [1, 1, 2, 2])
    assert "runs" in no_runs.contrasts[0].p.reason
    assert isinstance(no_runs.f, Undefined)


@pytest.mark.parametrize(
    ("values", "condition", "day"),
    [
        ([0.1] * 12, list("abc") * 4, [1] * 6 + [2] * 6),
        ([0.1, 0.3, 0.1, 0.3, 0.2, 0.4, 0.2, 0.4], list("abab") * 2, [1] * 4 + [2] * 4),
        ([0.1, 0.2], list("ab"), [1, 2]),
        ([0.5], ["a"], [1]),
    ],
)
def test_no_scatter_no_test(values, condition, day):
    found = blocked_by_day(values, condition, day)
    assert isinstance(found.p, Undefined)
    assert all(isinstance(contrast.p, Undefined) for contrast in found.contrasts)
    assert "No test" in found.sentence()
    for contrast in found.contrasts:
        chosen = [[v for v, c in zip(values, condition, strict=True) if c == of] for of in (contrast.condition, "a")]
        assert contrast.difference == pytest.approx(np.mean(chosen[0]) - np.mean(chosen[1]), abs=1e-15)


def test_labels_control_and_refusals():
    found = blocked_by_day([1.0, 2.0, 3.0, 4.5, 5.0, 6.5] * 2, [10, 9, 100] * 4, [1] * 6 + [2] * 6, control="100")
    assert [each.condition for each in found.conditions] == ["100", "9", "10"]
    with pytest.raises(UnknownName, match="condition"):
        blocked_by_day([1.0, 2.0], ["a", "b"], [1, 1], control="c")
    with refuses(InputRefused, "2 values", "1 label"):
        blocked_by_day([1.0, 2.0], ["a", "b"], [1])
    with pytest.raises(InputRefused, match="NaN"):
        blocked_by_day([1.0, float("nan")], ["a", "b"], [1, 1])
    with pytest.raises(InputRefused, match="no values"):
        blocked_by_day([], [], [])


def test_equal_numbers_are_one_label_whatever_their_type():
    values = [1.0, 2.5, 2.0, 4.5, 1.2, 2.4, 2.3, 4.0]
    condition = [0, 50, 0.0, 50.0, Decimal("-0.0"), Fraction(50), np.float32(0), np.int8(50)]
    day, run = [1, 1, 1.0, 1, 2, 2.0, Decimal(2), np.uint8(2)], [1, 1, 1.0, True + 1, 1, 1, 2.0, 2]
    found = blocked_by_day(values, condition, day, run, control=50.0)
    plain = blocked_by_day(values, [0, 50] * 4, [1] * 4 + [2] * 4, [1, 1, 1, 2, 1, 1, 2, 2], control=50)
    assert found == plain
    assert [each.condition for each in found.conditions] == ["50", "0"]
    assert as_labels("day", [0.5, Fraction(1, 2), Decimal("0.50"), 1e22, 10**22], "refuse").tolist() == [
        *["0.5"] * 3,
        *[str(10**22)] * 2,
    ]
    apart = as_labels("day", [Decimal("0.10"), Decimal("0.1"), 0.1, True, "01", np.float32(0.1), 2.5], "refuse")
    assert apart.tolist() == ["0.1", "0.1", "0.1", "True", "01", "0.1", "2.5"]
    by_type, by_one = (permutation_test(values[:4], values[4:], [1, 1, 2, 2], b) for b in ([1.0, 2.0] * 2, [1, 2] * 2))
    assert by_type == by_one
    assert by_type.n_days == 2


TABLE = np.array([["a", "b"], ["a", "b"]])


@pytest.mark.parametrize(
    "table", [TABLE, TABLE.tolist(), pd.DataFrame(TABLE), "abab"], ids=["array", "list", "frame", "text"]
)
@pytest.mark.parametrize("place", range(3))
def test_labels_are_a_plain_list(table, place):
    labels = [list("abab"), [1, 1, 2, 2], [1, 1, 1, 2]]
    labels[place] = table
    name = ("condition", "day", "run")[place]
    with refuses(InputRefused, name, "dimensions where one"):
        blocked_by_day([1.0, 2.0, 3.0, 5.0], *labels)
    with refuses(InputRefused, "day_b", "dimensions"):
        permutation_test([1.0, 2.0, 3.0, 5.0], [1.0, 2.0, 4.0, 9.0], labels[0 if place else 1], table)


def test_one_of_a_thing_is_said_as_one():
    told = permutation_test([1.0, 2.0, 4.0], [3.0, 5.0, 9.0], [1] * 3, [1] * 3).sentence()
    says(told, "within", "1 day")
    with refuses(InputRefused, "1 value", "2 labels"):
        blocked_by_day([1.0], ["a", "b"], [1])
    with refuses(InputRefused, "2 values", "1 label"):
        permutation_test([1.0, 2.0], [1.0, 2.0], [1], [1, 1])
