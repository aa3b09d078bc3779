"""Series grown on a tape against functions whose values are known to many digits."""

from fractions import Fraction

import mpmath
import pytest

from benchmarks.reference_simulator.power_series import FixedPoint, SeriesTape, derivative_at, value_at

DIGITS = 40


@pytest.fixture(name="number")
def fixture_number() -> FixedPoint:
    return FixedPoint.for_digits(DIGITS)


def close(number: FixedPoint, value: int, expected: mpmath.mpf) -> bool:
    with mpmath.workdps(DIGITS + 20):
        return bool(abs(mpmath.mpf(value) / number.one - expected) < mpmath.mpf(10) ** -DIGITS)


@pytest.mark.parametrize("order", [24, 40])
def test_an_oscillator_turns_as_sine_and_cosine_do(number: FixedPoint, order: int) -> None:
    """x'' = -x from (1, 0), as far as the order carries: a higher one further."""
    tape = SeriesTape(number.bits, order)
    place, speed = tape.state(number.one), tape.state(0)
    tape.follow(place, speed)
    tape.follow(speed, tape.combine([(-number.one, place)]))
    step = number.of(Fraction(1, 8))
    reach = tape.run(step)
    assert (reach == 1) is (order == 40)
    moment = int(reach * 2**40) << (number.bits - 40)
    with mpmath.workdps(DIGITS + 20):
        angle = mpmath.mpf(moment) / number.one / 8
        assert close(number, value_at(place, moment, number.bits), mpmath.cos(angle))
        assert close(number, value_at(speed, moment, number.bits), -mpmath.sin(angle))


def test_products_quotients_and_roots_hold_along_the_step(number: FixedPoint) -> None:
    """With y' = 1 from 2: sqrt(y) / y^2 at y = 2.1, and its derivative."""
    tape = SeriesTape(number.bits, 40)
    y = tape.state(2 * number.one)
    tape.follow(y, tape.constant(number.one))
    quotient = tape.divide(tape.square_root(y), tape.multiply(y, y))
    step = number.of(Fraction(1, 10))
    tape.run(step)
    with mpmath.workdps(DIGITS + 20):
        end = mpmath.mpf("2.1")
        assert close(number, value_at(quotient, number.one, number.bits), end ** mpmath.mpf("-1.5"))
        slope = mpmath.mpf("-0.15") * end ** mpmath.mpf("-2.5")
        assert close(number, derivative_at(quotient, number.one, number.bits), slope)


def test_a_step_beyond_the_radius_of_convergence_is_cut_short(number: FixedPoint) -> None:
    """y' = y^2 from 1 has its pole at 1: the series hold over less than that, and there they are right."""
    tape = SeriesTape(number.bits, 40)
    y = tape.state(number.one)
    tape.follow(y, tape.multiply(y, y))
    reach = tape.run(2 * number.one)
    assert 0 < reach < 0.5
    moment = int(reach * 2**40) << (number.bits - 40)
    with mpmath.workdps(DIGITS + 20):
        assert close(number, value_at(y, moment, number.bits), 1 / (1 - 2 * mpmath.mpf(moment) / number.one))


def test_numbers_go_to_fixed_point_and_back(number: FixedPoint) -> None:
    assert str(number.decimal(number.of(Fraction("0.175")), 30)) == "0.175000000000000000000000000000"
    third = number.divide(number.one, 3 * number.one)
    assert abs(number.multiply(third, 3 * number.one) - number.one) <= 3
    assert close(number, number.evaluate(mpmath.tan, Fraction("1.0472")), mpmath.mpf(0)) is False
