"""What a design of conditions and days cannot tell, and that it is said."""

from __future__ import annotations

import numpy as np
import pytest

from data_schema.errors import InputRefused, UnknownName
from data_schema.vocabulary import Undefined
from stats.blocked import blocked_by_day
from stats.two_sample import compare_two


def test_one_day_a_condition_has_no_p():
    found = blocked_by_day([1.0, 1.1, 0.9, 2.0, 2.2, 2.1], list("aaabbb"), ["mon"] * 3 + ["tue"] * 3)
    contrast = found.contrasts[0]
    assert contrast.difference == pytest.approx(1.1)
    for undefined in (contrast.p, contrast.se, contrast.interval, found.p, found.f, found.day_variance):
        assert isinstance(undefined, Undefined)
        assert "day" in undefined.reason
    assert isinstance(found.exact, Undefined)
    assert "measure the conditions on shared days" in found.sentence("J")
    assert "cannot be told from a difference between days" in found.sentence("J")


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
    assert "one run" in one_a_day.notes[0]
    assert isinstance(one_a_day.run_variance, Undefined)
    single = blocked_by_day(values, condition, day, list(range(8)))
    assert "one value" in single.notes[0]
    plain = blocked_by_day(values, condition, day)
    assert one_a_day.p == single.p == plain.p
    days = blocked_by_day(values, condition, range(8))
    assert "values are compared as they are" in days.notes[0]
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
    with pytest.raises(InputRefused, match="2 values and 1 labels of day"):
        blocked_by_day([1.0, 2.0], ["a", "b"], [1])
    with pytest.raises(InputRefused, match="NaN"):
        blocked_by_day([1.0, float("nan")], ["a", "b"], [1, 1])
    with pytest.raises(InputRefused, match="no values"):
        blocked_by_day([], [], [])
