"""Tail areas of t, F, chi-squared and the normal distribution to 12 digits, as log10 where no double is as small.

Down to 1e-290 they are scipy's incomplete beta and gamma functions (measured: 2e-12 at most, 1e-15 as a rule). Below,
the leading factor x^a (1 - x)^b / (a B(a, b)) of the incomplete beta function is mpmath's and the rest a continued
fraction. `scipy.special` loads in a tenth of the time of `scipy.stats`. Arguments may be fractions.

A sum of independent estimated variances has (sum of v_i)^2 / sum of (v_i^2 / df_i) degrees of freedom (Welch 1938,
Satterthwaite 1946): those of the chi-squared whose multiple has the sum's mean and variance. One formula in three
arithmetics. Doubles square shares of the sum, so that nothing overflows once the sum is a double, and a share whose
square is no double adds nothing.

Of the noncentral t and F distributions both tails have some 13 digits. For t, (Z + delta) / S <= t just where
Z <= t S - delta, with S = sqrt(chi2(df) / df); so the lower tail is the mean of Phi(t S - delta). In u = ln S the
integrand is analytic and falls off fast, where equal steps converge geometrically. For F it is the mean of central
tails over a Poisson number of mean lambda / 2; all terms are positive.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy import special

from stats.exact.numbers import Floats, Number, root_between

_LEAST = 1e-290
"""Below it scipy's functions lose digits."""
_LEAST_DF, _MANY_DF, _MOST_DF = 1e-12, 1e6, 1e15  # beyond these the digits of the beta function run out
_NEAR = Fraction(1, 200)
_BITS = 160
_MOST_STEPS = 200_000
_USUAL_DF, _USUAL_TAIL, _USUAL_T = (0.5, 1e6), Fraction(1, 10**100), 1e150
"""Where scipy's quantile of t has 12 digits: beyond it is infinite, no number, or as good as any."""
_MIDDLE = Fraction(1, 100)
"""Chance of the middle below which the quantile is searched: a tail near a half has not its digits."""
_DIGITS_LOST = 1e-4
_LINEAR, _FLAT_DF = Fraction(1, 2**64), 1e-8
_FAR_TAIL = 1e-15


@dataclass(frozen=True, slots=True)
class Tail:
    """A probability and its decimal logarithm."""

    p: float
    """0 only below the smallest double."""
    log10_p: float
    """Right where `p` is 0, too."""


def t_two_sided(t: Number, df: Number) -> Tail:
    """Return P(|T| >= |t|) for Student's t with `df` degrees of freedom, which may be infinite."""
    if t == 0:
        return Tail(1.0, 0.0)
    if df == math.inf:
        return normal_two_sided(t)
    if df > _MANY_DF and Fraction(t) ** 2 < _NEAR * Fraction(df):
        return normal_two_sided(_as_normal(abs(float(t)), float(df)))
    if df > _MOST_DF:  # so far out that nothing else counts
        return _of_log(-0.5 * float(df) * _log(1 + Fraction(t) ** 2 / Fraction(df)))
    if df < _LEAST_DF:  # but for a term of df
        ratio = _log(abs(Fraction(t))) - 0.5 * math.log(df)
        return _of_log(-float(df) * (ratio + math.log(2.0) if ratio > 20.0 else math.asinh(math.exp(ratio))))
    exact_t, exact_df = Fraction(t), Fraction(df)
    return _beta_area(float(df) / 2.0, 0.5, exact_df / (exact_df + exact_t * exact_t))


def t_upper(t: Number, df: Number) -> Tail:
    """Return P(T >= t)."""
    both = t_two_sided(t, df)
    if t < 0:
        return _of_log(math.log1p(-both.p / 2.0))
    return Tail(both.p / 2.0, both.log10_p - math.log10(2.0))


def f_upper(f: Number, df_numerator: Number, df_denominator: Number) -> Tail:
    """Return P(F >= f)."""
    if f <= 0:
        return Tail(1.0, 0.0)
    above, below = Fraction(df_numerator), Fraction(df_denominator)
    return _beta_area(float(below) / 2.0, float(above) / 2.0, below / (below + Fraction(f) * above))


def f_two_sided(f: Number, df_numerator: Number, df_denominator: Number) -> Tail:
    """Return twice the smaller tail area of F, at most 1 (as R's `var.test`); `f` is positive."""
    upper, lower = f_upper(f, df_numerator, df_denominator), f_upper(1 / Fraction(f), df_denominator, df_numerator)
    smaller = min(upper, lower, key=lambda tail: tail.log10_p)
    if smaller.p >= 0.5:
        return Tail(1.0, 0.0)
    return Tail(2.0 * smaller.p, smaller.log10_p + math.log10(2.0))


def chi2_upper(x: Number, df: int) -> Tail:
    """Return P(X >= x) for chi-squared."""
    p = float(special.chdtrc(df, float(x)))
    if p > _LEAST:
        return _of_log(math.log1p(-float(special.chdtr(df, float(x))))) if p > 0.5 else Tail(p, math.log10(p))
    from mpmath import mp

    with mp.workprec(_BITS):
        half = mp.mpf(Fraction(x).numerator) / Fraction(x).denominator / 2
        return _of_log(float(mp.log(mp.gammainc(mp.mpf(df) / 2, half, mp.inf, regularized=True))))


def normal_two_sided(z: Number) -> Tail:
    """Return P(|Z| >= |z|)."""
    far = abs(float(z))
    p = math.erfc(far / math.sqrt(2.0))
    if p > _LEAST:
        return Tail(p, math.log10(p) if p < 0.5 else math.log1p(-math.erf(far / math.sqrt(2.0))) / _LN_10)
    return _of_log(float(special.log_ndtr(-far)) + math.log(2.0))


_LN_10 = math.log(10.0)


def _of_log(log_p: float) -> Tail:
    return Tail(math.exp(log_p), min(log_p / _LN_10, 0.0) or 0.0)


def _as_normal(t: float, df: float) -> float:
    """Return the normal value with the tail of t, for t^2 / df below 0.005 (Hill 1970, algorithm 395, two terms)."""
    ratio = t / df * t
    z = t * math.sqrt((1.0 - 0.5 / df) * (math.log1p(ratio) / ratio if ratio > 1e-17 else 1.0))
    return z * (1.0 + ((z / (df - 0.5)) ** 2 + 3.0 / (df - 0.5) / (df - 0.5)) / 48.0)


def _log(number: Fraction) -> float:
    return math.log(number.numerator) - math.log(number.denominator)


def _beta_area(a: float, b: float, x: Fraction) -> Tail:
    """Return the regularised incomplete beta function I_x(a, b)."""
    found = _scipys_area(a, b, x)
    if found.p < 0.5 or x < _LEAST:
        return found
    return Tail(found.p, math.log1p(-_scipys_area(b, a, 1 - x).p) / _LN_10 or 0.0)


def _scipys_area(a: float, b: float, x: Fraction) -> Tail:
    """Return I_x(a, b), whose logarithm has its digits where it is below a half."""
    p = float(special.betainc(a, b, float(x)) if 2 * x < 1 else special.betaincc(b, a, float(1 - x)))
    return _far_area(a, b, x) if p < _LEAST or x < _LEAST else Tail(p, math.log10(p))


def _far_area(a: float, b: float, x: Fraction) -> Tail:
    """Return I_x(a, b) for x far below the bulk, by Lentz's evaluation of its continued fraction (DLMF 8.17.22)."""
    from mpmath import mp

    share, fraction, c, d = float(x), 1.0, 1.0, 0.0
    for step in range(1, _MOST_STEPS):
        m = step // 2
        if step % 2:
            part = -(a + m) * (a + b + m) * share / ((a + 2 * m) * (a + 2 * m + 1))
        else:
            part = m * (b - m) * share / ((a + 2 * m - 1) * (a + 2 * m))
        d = 1.0 / (1.0 + part * d)
        c = 1.0 + part / c
        fraction *= c * d
        if abs(c * d - 1.0) < 1e-15:
            break
    with mp.workprec(_BITS):
        low, high = mp.mpf(a), mp.mpf(b)
        log_odds = mp.log(mp.mpf(x.numerator) / x.denominator) * low
        log_rest = mp.log(mp.mpf((1 - x).numerator) / (1 - x).denominator) * high
        log_beta = mp.loggamma(low) + mp.loggamma(high) - mp.loggamma(low + high)
        return _of_log(float(log_odds + log_rest - log_beta - mp.log(low)) - math.log(fraction))


def complement_level(alpha: float) -> Number:
    """Return 1 - alpha: as the double that is shown, or where that loses digits of alpha as a fraction."""
    return 1.0 - alpha if alpha > _DIGITS_LOST else 1 - Fraction(alpha)


@lru_cache(maxsize=4096)
def t_quantile(level: Number, df: float) -> float:
    """Return the half width of a two-sided interval of the given level in standard errors (df may be infinite).

    Infinite where it is too large for a double.
    """
    return t_upper_quantile((1 - Fraction(level)) / 2, df)


@lru_cache(maxsize=4096)
def t_upper_quantile(tail: Number, df: float) -> float:
    """Return the t that Student's t exceeds with chance `tail`, between 0 and 1 (df may be infinite).

    Infinite where it is too large for a double.
    """
    exact = Fraction(tail)
    middle = 1 - 2 * exact
    if middle < 0:
        return -t_upper_quantile(1 - exact, df)
    if exact == 0 or df == 0.0:
        return math.inf
    if middle == 0:
        return 0.0
    if exact >= _USUAL_TAIL and middle >= _MIDDLE and df >= _USUAL_DF[0]:
        if df == math.inf:
            return _normal_quantile(float(exact))
        if df <= (_MOST_DF if exact >= _FAR_TAIL else _USUAL_DF[1]):
            t = float(_polished(np.array(df), float(exact)))
            if t <= _USUAL_T:
                return t
    if middle < _LINEAR and df > _FLAT_DF:  # the density is flat there
        return float(Fraction(t_upper_quantile((1 - _LINEAR) / 2, df)) * middle / _LINEAR)
    if middle < Fraction(1, 2):
        log_both = math.log1p(-float(middle))
    else:
        log_both = math.log(2 * exact.numerator) - math.log(exact.denominator)

    def beyond(log_t: float) -> float:
        return t_two_sided(math.exp(log_t), df).log10_p * _LN_10 / log_both - 1.0

    ends = math.log(sys.float_info.min), math.log(sys.float_info.max)
    last = beyond(ends[1])
    if last < 0.0:
        return math.inf
    return math.exp(root_between(beyond, (ends[0], beyond(ends[0])), (ends[1], last)))


def t_upper_quantiles(tail: Fraction, df: Floats) -> Floats:
    """Return `t_upper_quantile` of each number of degrees of freedom, any shape."""
    usual = (df >= _USUAL_DF[0]) & (df <= _MOST_DF) & (float(tail) >= _FAR_TAIL)
    if usual.all():
        return _polished(df, float(tail))
    found = np.array([t_upper_quantile(tail, each) for each in df[~usual].tolist()])
    quantiles = np.empty(df.shape)
    quantiles[usual], quantiles[~usual] = _polished(df[usual], float(tail)), found
    return quantiles


def _polished(df: Floats, tail: float) -> Floats:
    """Return scipy's quantile of t, taken to the last digits by one of Newton's steps."""
    t = -special.stdtrit(df, tail)
    with np.errstate(over="ignore"):
        log_density = (
            special.gammaln((df + 1.0) / 2.0)
            - special.gammaln(df / 2.0)
            - 0.5 * np.log(math.pi * df)
            - (df + 1.0) / 2.0 * np.log1p(t * t / df)
        )
    return np.asarray(t + (special.stdtr(df, -t) - tail) / np.exp(log_density))


def _normal_quantile(tail: float) -> float:
    """Return scipy's normal quantile, taken to the last digits by one of Newton's steps."""
    z = -float(special.ndtri(tail))
    return z + (float(special.ndtr(-z)) - tail) * math.sqrt(2.0 * math.pi) * math.exp(0.5 * z * z)


def exact_df(parts: Sequence[tuple[Fraction, int]]) -> Fraction:
    """Return those of (variance, degrees of freedom) of any sizes, not all variances 0, without any rounding."""
    total = sum((variance for variance, _df in parts), Fraction(0))
    doubt = sum((variance**2 / df for variance, df in parts), Fraction(0))
    return total**2 / doubt


def df_of_doubles(parts: Sequence[tuple[float, float]]) -> float:
    """Return those of (variance, degrees of freedom); infinite where all is known exactly."""
    total = math.fsum(variance for variance, _df in parts)
    doubt = math.fsum((variance / total) ** 2 / df for variance, df in parts) if total > 0.0 else 0.0
    return 1.0 / doubt if doubt > 0.0 else math.inf


def df_of_arrays(part_a: Floats, part_b: Floats, df_a: float, df_b: float) -> Floats:
    """Return those of many pairs of variances at once, of the shape of the parts; no pair is 0 twice."""
    both = part_a + part_b
    return np.asarray(1.0 / ((part_a / both) ** 2 / df_a + (part_b / both) ** 2 / df_b))


_REACH = 40.0  # logarithm below which a weight does not count
_NORMAL_REACH = 13.0
_MANY, _MOST = 1e6, 1e12
"""Noncentralities, per degree of freedom and at all, from which their mean is all that counts of their scatter."""


def t_tails(t: float, df: float, delta: float) -> tuple[float, float]:
    """Return P(T <= t) and P(T >= t) for noncentrality `delta`."""
    if t * t > 400.0 * df:
        return _steep_t_tails(t, df, delta)
    u, weights = _log_scale(df, abs(t))
    argument = t * np.exp(u) - delta
    return float(weights @ special.ndtr(argument)), float(weights @ special.ndtr(-argument))


def _log_scale(df: float, t: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return nodes in ln S and their weights, close enough for the normal's edge to be smooth between them."""
    low = -max(9.0 * math.sqrt(2.0 / df), (_REACH + df / 2.0) / df if df < 60.0 else 0.0)
    high = min(9.0 / math.sqrt(2.0 * df), 0.5 * math.log(1.0 + 2.0 * _REACH / df) + 1.0)
    steepness = math.sqrt(2.0 * df + (t * math.exp(high / 3.0)) ** 2)
    u = np.linspace(low, high, int((high - low) * max(steepness / 0.5, 9.0)) + 60)
    log_density = df * (u - np.expm1(2.0 * u) / 2.0)
    weights = np.exp(log_density - log_density.max())
    return u, weights / weights.sum()


def _steep_t_tails(t: float, df: float, delta: float) -> tuple[float, float]:
    """Return the tails where t is so large that S, not Z, decides: the mean over Z of the tails of S.

    Below Z = -delta (for positive t) the ratio is negative whatever S is; Gauss's nodes begin there.
    """
    if t < 0.0:
        lower, upper = _steep_t_tails(-t, df, -delta)
        return upper, lower
    start = min(max(-_NORMAL_REACH, -delta), _NORMAL_REACH)
    nodes, widths = _gauss_nodes()
    half = (_NORMAL_REACH - start) / 2.0
    z = start + half * (nodes + 1.0)
    weights = half * widths * np.exp(-z * z / 2.0) / math.sqrt(2.0 * math.pi)
    with np.errstate(over="ignore"):
        argument = df / 2.0 * (np.maximum(z + delta, 0.0) / t) ** 2
    lower = float(weights @ special.gammaincc(df / 2.0, argument)) + float(special.ndtr(start))
    return lower, float(weights @ special.gammainc(df / 2.0, argument))


@lru_cache(maxsize=1)
def _gauss_nodes() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    nodes, widths = np.polynomial.legendre.leggauss(200)
    return nodes, widths


def f_tails(f: float, df_between: float, df_within: float, noncentrality: float) -> tuple[float, float]:
    """Return P(F <= f) and P(F >= f)."""
    if noncentrality > _MANY * df_within and (noncentrality > _MOST or df_between * f > _MANY * df_within):
        return _f_tails_of_many(f, df_between, df_within, noncentrality)
    a, b = df_between / 2.0, df_within / 2.0
    x, y = df_between * f / (df_between * f + df_within), df_within / (df_between * f + df_within)
    mean = noncentrality / 2.0
    spread = 12.0 * math.sqrt(mean) + 40.0
    first, last = max(0.0, float(np.floor(mean - spread))), float(np.ceil(mean + spread))
    step = max(1.0, float(np.floor(math.sqrt(mean) / 20.0)))
    counts = np.arange(first, last + 1.0, step)
    log_weight = special.xlogy(counts, mean) - mean - special.gammaln(counts + 1.0)
    weights = np.exp(log_weight - log_weight.max())
    weights /= weights.sum()
    return float(weights @ special.betainc(a + counts, b, x)), float(weights @ special.betainc(b, a + counts, y))


def _f_tails_of_many(f: float, df_between: float, df_within: float, noncentrality: float) -> tuple[float, float]:
    """Return the tails where chi^2(df_between, noncentrality) is its mean but for what its inverse is to first order.

    Sums over Poisson's numbers lose more digits there than they have.
    """
    scale = noncentrality / df_between / f if f > 0.0 else math.inf
    x = scale * df_within
    if x > _MOST:
        return 0.0, 1.0
    half = df_within / 2.0
    log_density = special.xlogy(half - 1.0, x / 2.0) - x / 2.0 - math.lgamma(half) - math.log(2.0)
    moved = x * math.exp(log_density) * (df_between + df_within - 2.0 - x) / noncentrality
    lower, upper = float(special.gammaincc(half, x / 2.0)) - moved, float(special.gammainc(half, x / 2.0)) + moved
    return min(max(lower, 0.0), 1.0), min(max(upper, 0.0), 1.0)
