"""The regularised incomplete beta function with 45 digits, of exact arguments.

The leading factor x^a (1 - x)^b / B(a, b) is taken with 48 digits, the continued fraction (Didonato and Morris 1992,
equation 9) in whole numbers scaled by 2^160. Numbers come and go as mpmath holds them inside: its functions there save
half of the time.
"""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from typing import Any

BITS = 160
_ONE = 1 << BITS
_ENOUGH = 1 << (BITS - 64)
_MOST_STEPS = 200_000
_SMALL_SHARE, _FEW_TERMS = _ONE // 10, 30 * _ONE
_LAST_TERM = 1 << (BITS - 120)


def incomplete_beta(a: Fraction, b: Fraction, top: int, bottom: int) -> Any:
    """Return I_x(a, b), the regularised incomplete beta function at x = 1 / (1 + top / bottom), as mpmath's inside."""
    from mpmath import libmp

    x, rest = (bottom << BITS) // (top + bottom), (top << BITS) // (top + bottom)
    a_fixed, b_fixed = _fixed(a), _fixed(b)
    below_bulk = a_fixed - ((a_fixed + b_fixed) * x >> BITS)
    upper = True
    if rest < _SMALL_SHARE and ((a_fixed + b_fixed) * rest >> BITS) < _FEW_TERMS:  # 13 of 48 digits cancel at most
        factor = raw(_series(b_fixed, a_fixed, rest), b_fixed)
    elif below_bulk + _ONE >= x * 2:
        factor, upper = raw(_ONE, _continued_fraction(a_fixed, b_fixed, x, below_bulk)), False
    else:
        factor = raw(_ONE, _continued_fraction(b_fixed, a_fixed, rest, -below_bulk))
    area = libmp.mpf_mul(_leading(a, b, top, bottom), factor, BITS)
    return libmp.mpf_sub(libmp.fone, area, BITS) if upper else area


def _leading(a: Fraction, b: Fraction, top: int, bottom: int) -> Any:
    """Return x^a (1 - x)^b / B(a, b) at x = 1 / (1 + top / bottom)."""
    from mpmath import libmp

    log_odds = libmp.mpf_log(raw(top, bottom), BITS)
    log_share = libmp.mpf_log(raw(top + bottom, bottom), BITS)
    whole, part = raw(*(a + b).as_integer_ratio()), raw(*b.as_integer_ratio())
    exponent = libmp.mpf_sub(libmp.mpf_mul(part, log_odds), libmp.mpf_mul(whole, log_share), BITS)
    return libmp.mpf_exp(libmp.mpf_sub(exponent, _log_beta(a, b), BITS), BITS)


@lru_cache(maxsize=256)
def _log_beta(a: Fraction, b: Fraction) -> Any:
    """Return the logarithm of B(a, b) as mpmath holds numbers inside."""
    from mpmath import mp

    with mp.workprec(BITS):
        high, low = mp.make_mpf(raw(*a.as_integer_ratio())), mp.make_mpf(raw(*b.as_integer_ratio()))
        return (mp.loggamma(high) + mp.loggamma(low) - mp.loggamma(high + low))._mpf_


def raw(top: int, bottom: int) -> Any:
    """Return a fraction as mpmath holds numbers inside."""
    from mpmath import libmp

    return libmp.from_rational(top, bottom, BITS)


def _series(a: int, b: int, x: int) -> int:
    """Return the sum of (a + b)_n / (a + 1)_n x^n over all n, for small x (DLMF 8.17.7); all times 2^160."""
    top, bottom = a + b, a + _ONE
    term = total = _ONE
    while term > _LAST_TERM:
        term = term * top // bottom * x >> BITS
        total += term
        top, bottom = top + _ONE, bottom + _ONE
    return total


def _continued_fraction(a: int, b: int, x: int, below_bulk: int) -> int:
    """Return b0 + a1 / (b1 + a2 / (b2 + ...)) by the recurrence of its convergents; all times 2^160.

    `below_bulk` is a - (a + b) x, positive where x lies below the bulk of the distribution.
    """
    start, slope = below_bulk + _ONE, 2 * _ONE - x
    before_last, last, bottom_before, bottom = _ONE, a * start // (a + _ONE), 0, _ONE
    found = last
    middle, of_b, of_both = a - _ONE, b, a + b - _ONE
    for m in range(1, _MOST_STEPS):
        step = m << BITS
        above, middle = a + step, middle + 2 * _ONE
        of_b, of_both, start = of_b - _ONE, of_both + _ONE, start + slope
        share = m * of_b * x // middle
        partial = ((above - _ONE) * of_both // middle * share >> BITS) * x >> BITS
        whole = step + share + above * start // (middle + 2 * _ONE)
        before_last, last = last, (whole * last + partial * before_last) >> BITS
        bottom_before, bottom = bottom, (whole * bottom + partial * bottom_before) >> BITS
        before, found = found, (last << BITS) // bottom
        if abs(found - before) <= found * _ENOUGH >> BITS:
            return found
        excess = bottom.bit_length() - BITS - 64
        if excess > 64:
            before_last, last, bottom_before, bottom = (
                number >> excess for number in (before_last, last, bottom_before, bottom)
            )
    sizes = ", ".join(f"{number / _ONE:g}" for number in (a, b, x))
    raise ArithmeticError(f"the incomplete beta function did not converge for {sizes}")


def _fixed(value: Fraction) -> int:
    return (value.numerator << BITS) // value.denominator
