"""Tail areas of t, F, chi-squared and the normal distribution to the last digit, and as log10 down to 1e-10000.

scipy's tails are 0 below 1e-308 and lose digits on the way there (12 to 13 are right at 1e-200). Here they come from an
incomplete beta function of 45 digits, so that a double is right to its last digit. Arguments
may be fractions: a statistic is not rounded before its p is taken.

Of the incomplete beta function the leading factor x^a (1 - x)^b / B(a, b) is taken with 48 digits, the continued
fraction (Didonato and Morris 1992, equation 9) in whole numbers scaled by 2^160. Numbers come and go as mpmath holds
them inside: its functions there save half of the time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
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


_FAR = 1e13
_LITTLE = (0, 1, -8, 1)  # 2^-8 as mpmath holds numbers inside
_LEAST_DF, _MOST_DF = 1e-16, 1e15  # beyond these the digits of the beta function run out
_PLAIN = (1e-290, 0.5)  # between these the logarithm of the double is as good

Exact = float | Fraction


@dataclass(frozen=True, slots=True)
class Tail:
    """A probability and its decimal logarithm."""

    p: float
    """0 only below the smallest double."""
    log10_p: float
    """Right where `p` is 0, too."""


def t_two_sided(t: Exact, df: Exact) -> Tail:
    """Return P(|T| >= |t|) for Student's t with `df` degrees of freedom, which may be infinite."""
    if df == math.inf:
        return normal_two_sided(t)
    if t == 0:
        return Tail(1.0, 0.0)
    return _as_tail(_t_both(t, df))


def t_upper(t: Exact, df: Exact) -> Tail:
    """Return P(T >= t)."""
    if df == math.inf:
        return normal_upper(t)
    from mpmath import libmp

    half = libmp.mpf_shift(_t_both(t, df), -1) if t != 0 else raw(1, 2)
    return _as_tail(half if t >= 0 else libmp.mpf_sub(libmp.fone, half, BITS))


def t_log_ratio(t: Exact, df: Exact, p: Fraction) -> float:
    """Return ln(P(|T| >= |t|) / p), with all digits where the two are nearly equal; `df` may be infinite."""
    from mpmath import mp

    with mp.workprec(BITS):
        both = mp.make_mpf(_normal_both(t) if df == math.inf else _t_both(t, df))
        wanted = mp.make_mpf(raw(*p.as_integer_ratio()))
        near = wanted < 2 * both < 4 * wanted
        return float(mp.log1p((both - wanted) / wanted) if near else mp.log(both / wanted))


def f_upper(f: Exact, df_numerator: Exact, df_denominator: Exact) -> Tail:
    """Return P(F >= f)."""
    if f <= 0:
        return Tail(1.0, 0.0)
    return _as_tail(_f_upper(f, df_numerator, df_denominator))


def f_two_sided(f: Exact, df_numerator: Exact, df_denominator: Exact) -> Tail:
    """Return twice the smaller tail area of F, at most 1 (as R's `var.test`); `f` is positive."""
    from mpmath import libmp

    smaller = _f_upper(f, df_numerator, df_denominator)
    if libmp.mpf_gt(smaller, libmp.fhalf):
        smaller = libmp.mpf_sub(libmp.fone, smaller, BITS)
        if libmp.mpf_lt(smaller, _LITTLE):  # too little is left of its digits
            smaller = _f_upper(1 / Fraction(f), df_denominator, df_numerator)
    return _as_tail(libmp.mpf_shift(smaller, 1)) if libmp.mpf_lt(smaller, libmp.fhalf) else Tail(1.0, 0.0)


def chi2_upper(x: Exact, df: Exact) -> Tail:
    """Return P(X >= x) for chi-squared."""
    from mpmath import mp

    if x <= 0:
        return Tail(1.0, 0.0)
    with mp.workprec(BITS):
        return _as_tail(mp.gammainc(_number(df) / 2, _number(x) / 2, mp.inf, regularized=True)._mpf_)


def normal_upper(z: Exact) -> Tail:
    """Return P(Z >= z)."""
    from mpmath import mp

    with mp.workprec(BITS):
        return _as_tail((mp.erfc(_number(z) / mp.sqrt(2)) / 2)._mpf_)


def normal_two_sided(z: Exact) -> Tail:
    """Return P(|Z| >= |z|)."""
    return _as_tail(_normal_both(z))


def _normal_both(z: Exact) -> Any:
    from mpmath import mp

    with mp.workprec(BITS):
        return _erfc(abs(_number(z)) / mp.sqrt(2))._mpf_


def _erfc(x: Any) -> Any:
    from mpmath import mp

    if x < _FAR:
        return mp.erfc(x)
    return mp.exp(-x * x) / (x * mp.sqrt(mp.pi)) * (1 - 1 / (2 * x * x))  # mpmath's own ends at 1e154


def _as_tail(raw: Any) -> Tail:
    from mpmath import libmp, mp

    p = libmp.to_float(raw, rnd="n")
    if _PLAIN[0] < p < _PLAIN[1]:
        return Tail(p, math.log10(p))
    with mp.workprec(BITS):
        return Tail(p, min(0.0, float(mp.log10(mp.make_mpf(raw)))))


def _number(value: Exact) -> Any:
    from mpmath import mp

    return mp.make_mpf(raw(*Fraction(value).as_integer_ratio()))


def _t_both(t: Exact, df: Exact) -> Any:
    if not _LEAST_DF <= df <= _MOST_DF:
        return _t_both_at_ends(t, df)
    exact_df, exact_t = Fraction(df), Fraction(t)
    top, bottom = exact_t.numerator**2 * exact_df.denominator, exact_t.denominator**2 * exact_df.numerator
    return incomplete_beta(exact_df / 2, Fraction(1, 2), top, bottom)


def _t_both_at_ends(t: Exact, df: Exact) -> Any:
    """Return both tails of t with so many or few degrees of freedom that the next term of a series is below 1e-17.

    Many: those of a normal (Hill 1970, algorithm 395, the first of his terms). Few: P = exp(-df asinh(|t| / sqrt(df))).
    """
    from mpmath import mp

    with mp.workprec(BITS):
        number, square = _number(df), _number(t) ** 2
        if df < _LEAST_DF:
            return mp.exp(-number * mp.asinh(mp.sqrt(square / number)))._mpf_
        return _erfc(mp.sqrt((number - 0.5) * mp.log1p(square / number) / 2))._mpf_


def _f_upper(f: Exact, df_numerator: Exact, df_denominator: Exact) -> Any:
    above, below = Fraction(df_numerator), Fraction(df_denominator)
    odds = Fraction(f) * above / below
    return incomplete_beta(below / 2, above / 2, odds.numerator, odds.denominator)
