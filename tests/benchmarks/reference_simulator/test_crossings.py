"""The first rise of a guard through zero: found exactly, never missed, never found twice."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.reference_simulator.power_series import FixedPoint, first_rise

NUMBER = FixedPoint.for_digits(30)
TOLERANCE = 2**50  # of bits far below the thirtieth digit


def polynomial(roots: list[Fraction], leading: int) -> list[int]:
    """The coefficients of leading * product of (t - root), lowest first."""
    exact = [Fraction(leading)]
    for root in roots:
        shifted = [Fraction(0), *exact]
        exact = [high - root * low for high, low in zip(shifted, [*exact, Fraction(0)], strict=True)]
    return [NUMBER.of(value) for value in exact] + [0] * 8


def rise(coefficients: list[int], reach: Fraction = Fraction(1)) -> int | None:
    return first_rise(coefficients, NUMBER.of(reach), NUMBER.bits)


@given(
    st.lists(st.integers(-40, 1060).filter(lambda n: n != 0 and n != 1000), min_size=1, max_size=6, unique=True),
    st.sampled_from([-3, 2]),
)
def test_the_first_of_any_simple_roots_at_which_the_guard_rises(places: list[int], leading: int) -> None:
    """Against the sign of the exact polynomial between its roots."""
    roots = sorted(Fraction(place, 1000) for place in places)
    found = rise(polynomial(roots, leading))

    def positive_just_after(moment: Fraction) -> bool:
        falling = sum(root > moment for root in roots)
        return (leading > 0) == (falling % 2 == 0)

    rises = [root for root in roots if 0 < root < 1 and positive_just_after(root)]
    if positive_just_after(Fraction(0)):
        assert found == 0
    elif rises:
        assert found is not None
        assert abs(found - NUMBER.of(rises[0])) < TOLERANCE
    else:
        assert found is None


def test_a_guard_that_starts_at_zero_and_falls_is_found_where_it_comes_back() -> None:
    """An intrusion that begins and ends within a step: velocity 0, negative, 0."""
    velocity = polynomial([Fraction(0), Fraction(0), Fraction(1, 10**6)], 5)
    found = rise(velocity)
    assert found is not None
    assert abs(found - NUMBER.of(Fraction(1, 10**6))) < TOLERANCE


def test_a_guard_that_starts_at_zero_and_rises_fires_at_once() -> None:
    assert rise(polynomial([Fraction(0)], 1)) == 0


def test_a_rise_and_fall_inside_the_step_is_not_missed() -> None:
    """Both ends are negative: a sign test at the ends would see nothing."""
    found = rise(polynomial([Fraction(5000, 10000), Fraction(5001, 10000)], -1))
    assert found is not None
    assert abs(found - NUMBER.one // 2) < TOLERANCE


def test_nothing_is_found_beyond_the_reach_of_the_series() -> None:
    assert rise(polynomial([Fraction(1, 2)], 1), Fraction(2, 5)) is None


def test_a_tangency_is_refused() -> None:
    with pytest.raises(ArithmeticError, match="without crossing"):
        rise(polynomial([Fraction(1, 3), Fraction(1, 3)], -1))
