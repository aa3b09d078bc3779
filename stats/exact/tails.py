"""Tail areas of t, F, chi-squared and the normal distribution to the last digit, and as log10 down to 1e-10000.

scipy's tails are 0 below 1e-308 and lose digits on the way there (12 to 13 are right at 1e-200). Here they come from an
incomplete beta function of 45 digits (`exact.incomplete_beta`), so that a double is right to its last digit. Arguments
may be fractions: a statistic is not rounded before its p is taken.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from stats.exact.incomplete_beta import BITS, incomplete_beta, raw

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
