from fractions import Fraction

import pytest
import scipy.stats
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused, UnknownName
from data_schema.vocabulary import Undefined
from stats.compare.two_sample import compare_two
from tests.helpers.wording import refuses, says

A = [42.1, 39.8, 44.0, 41.2, 40.5, 43.3]
B = [36.9, 38.2, 35.1, 37.7, 36.0]
SAMPLE = st.lists(st.integers(-800, 800), min_size=3, max_size=12).filter(lambda values: len(set(values)) > 1)


def test_the_published_route_takes_welch_when_the_f_test_rejects():
    wide = [0.0, 30.0, -25.0, 40.0, -35.0, 10.0]
    alike, unlike = compare_two(A, B, "f_then_t"), compare_two(wide, B, "f_then_t")
    assert (alike.equal_variances, alike.test) == (True, "Student")
    assert (unlike.equal_variances, unlike.test) == (False, "Welch")
    assert unlike.p == unlike.welch_p


@pytest.mark.parametrize(
    ("alpha", "test", "df"),
    [(0.05, "Welch", 500.0 / 82.0), (0.035, "Welch", 500.0 / 82.0), (0.025, "Student", 10.0), (0.01, "Student", 10.0)],
)
def test_the_f_test_is_judged_at_the_alpha_that_was_asked_for(alpha, test, df):
    """Variances of 3.5 and 31.5 with n = 6: F(5, 5) = 9 has p = 0.031."""
    narrow, wide = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [3.0, 6.0, 9.0, 12.0, 15.0, 18.0]
    found = compare_two(narrow, wide, "f_then_t", alpha)
    assert found.f == pytest.approx(1.0 / 9.0)
    assert found.f_p == pytest.approx(2.0 * scipy.stats.f.sf(9.0, 5, 5))
    assert 0.025 < found.f_p < 0.035
    assert (found.test, found.df) == (test, pytest.approx(df))
    assert found.equal_variances == (test == "Student")


@given(SAMPLE, SAMPLE)
def test_swapping_the_groups_turns_the_signs(a, b):
    one, other = compare_two(a, b), compare_two(b, a)
    assert one.difference == pytest.approx(-other.difference, abs=1e-12)
    assert one.f == pytest.approx(1.0 / other.f)
    assert one.f_p == pytest.approx(other.f_p)
    assert one.t == pytest.approx(-other.t, abs=1e-12)
    assert one.p == pytest.approx(other.p)
    assert one.hedges_g == pytest.approx(-other.hedges_g, abs=1e-12)
    assert one.difference_ci == pytest.approx(tuple(-end for end in reversed(other.difference_ci)), abs=1e-9)


def test_one_constant_group_still_has_a_welch_test():
    found = compare_two([1.0, 2.0, 3.0], [5.0] * 4)
    assert isinstance(found.f, Undefined)
    assert isinstance(found.equal_variances, Undefined)
    assert found.test == "Welch"
    assert found.df == pytest.approx(2.0)
    assert compare_two([5.0] * 4, [1.0, 2.0, 3.0]).f == 0.0


def test_groups_too_small_for_a_variance():
    found = compare_two([1.0], [2.0, 3.0, 4.0])
    assert found.difference == -2.0
    assert isinstance(found.welch_t, Undefined)
    assert compare_two([1.0], [2.0, 3.0, 4.0], route="student").df == 2.0
    empty = compare_two([], [1.0, 2.0])
    assert isinstance(empty.difference, Undefined)
    says(empty.sentence("CE", "AD"), "group a is")


def test_equal_deviations_have_no_brown_forsythe_test():
    assert isinstance(compare_two([0.1, 0.4, 0.1, 0.4], [0.2, 0.3, 0.2]).brown_forsythe_p, float)
    assert isinstance(compare_two([0.1, 0.4], [0.7, 0.9, 0.7, 0.9]).brown_forsythe_p, Undefined)


def test_wrong_input_is_refused():
    with refuses(InputRefused, "1", "2 values"):
        compare_two([1.0, 2.0], [1.0, float("inf")])
    with refuses(UnknownName, "'welch'"):
        compare_two(A, B, route="welsh")


def test_a_difference_beyond_the_digits_of_the_means_says_so():
    far = compare_two([10**19 + 3, 10**19 + 4], [10**19, 10**19 + Fraction(1, 2)], "student")
    says(far.sentence(), "3.2", "95 %", "0.8", "5.7", "means differ beyond")
    close = compare_two([1e15, 1e15 + 1.0], [1e15 + 0.25, 1e15 + 0.5]).sentence()
    assert "beyond" not in close
    says(close, "1000000000000000.5", "n = 2", "minus b (mean", "1000000000000000.4")
    assert "beyond" not in compare_two([1.0, 2.0], [2.0, 1.0]).sentence()


def test_welchs_test_leads_whatever_the_variances():
    narrow, wide = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [3.0, 6.0, 9.0, 12.0, 15.0, 18.0]
    for found in (compare_two(A, B), compare_two(narrow, wide)):
        assert (found.route, found.test, found.t, found.df) == ("welch", "Welch", found.welch_t, found.welch_df)
        assert "Student" not in found.sentence()


def test_the_sentence_has_everything():
    text = compare_two(A, B, "f_then_t").sentence("CE", "AD", "J")
    for part in ("n = 6", "n = 5", "J", "95 % CI", "Student's t(9)", "Welch's t(", "p "):
        assert part in text
