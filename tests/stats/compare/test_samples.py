"""One sample and two: by hand, which t-test is taken, what is undefined and why, and what the sentence says."""

from __future__ import annotations

import math

import pytest

from data_schema.errors import InputRefused, UnknownName
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.compare.summary import describe
from stats.compare.two_sample import compare_two
from tests.helpers.wording import refuses, says

A, B = [42.1, 39.8, 44.0, 41.2, 40.7, 43.3], [36.9, 38.2, 35.1, 37.7, 39.9]
NARROW, WIDE = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [3.0, 6.0, 9.0, 12.0, 15.0, 18.0]


@pytest.mark.parametrize(("alpha", "test"), [(0.05, "Welch"), (0.02, "Student")])
def test_the_thesiss_route_takes_the_test_that_f_chooses(alpha: float, test: str) -> None:
    """Variances of 3.5 and 31.5 with n = 6: F(5, 5) = 9 has p = 0.031."""
    found = compare_two(NARROW, WIDE, "f_then_t", alpha)
    assert found.f == pytest.approx(1.0 / 9.0)
    assert found.test == test
    for default in (compare_two(A, B), compare_two(NARROW, WIDE)):
        assert (default.route, default.test) == ("welch", "Welch")


def test_one_constant_group_still_has_a_welch_test() -> None:
    found = compare_two([1.0, 2.0, 3.0], [5.0] * 4, names=("gain 400", "gain 0"))
    assert isinstance(found.f, Undefined)
    says(found.f.reason, "gain 0")
    assert found.df == pytest.approx(2.0)
    assert compare_two([5.0] * 4, [1.0, 2.0, 3.0]).f == 0.0


def test_groups_too_small_for_a_variance_have_a_difference() -> None:
    found = compare_two([1.0], [2.0, 3.0, 4.0])
    assert found.difference == -2.0
    assert isinstance(found.t, Undefined)
    assert compare_two([1.0], [2.0, 3.0, 4.0], route="student").df == 2.0
    assert isinstance(compare_two([1.0], [2.0]).hedges_g, Undefined)
    empty = compare_two([], [1.0, 2.0], names=("CE", "AD"))
    assert isinstance(empty.difference, Undefined)
    says(empty.sentence(), "group CE is")


def test_wrong_input_is_refused() -> None:
    with refuses(InputRefused, "'b'", "2 values"):
        compare_two([1.0, 2.0], [1.0, math.inf])
    with refuses(UnknownName, "'welch'"):
        compare_two(A, B, route="welsh")  # type: ignore[arg-type]
    with refuses(InputRefused, "groups are called", "'x'"):
        compare_two(A, B, names=("x", "x"))


def test_missing_values_are_refused_or_left_out_and_counted() -> None:
    with refuses(InputRefused, "'a'", "7 values"):
        compare_two([*A, math.nan], B)
    found = compare_two([*A, math.nan], [None, *B], missing="drop")
    assert found.missing == 2
    assert (found.t, found.p) == (compare_two(A, B).t, compare_two(A, B).p)
    says(found.sentence(), "2 missing")


def test_what_does_not_exist_is_undefined_field_by_field():
    one, none = describe([5.0]), describe([])
    assert one.mean == 5.0
    assert isinstance(one.sd, Undefined)
    assert isinstance(one.ci_low, Undefined)
    assert isinstance(none.mean, Undefined)
    assert none.n == 0

    found = describe([0.1] * 7)
    assert (found.mean, found.sd, found.se) == (0.1, 0.0, 0.0)
    assert found.ci_low == found.ci_high == Undefined(Reason.NO_SCATTER)
