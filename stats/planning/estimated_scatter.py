"""Means over what estimated variances may turn out: over their pooled scale, and over the share a group has in them.

The sums of squares of two groups, in units of their variances, are chi^2 with n - 1 degrees of freedom each. Their sum
and the share of one of them in it are independent: the sum is that of U^2 = chi^2_df / df with both groups' degrees of
freedom, the share is a beta variable. Densities are those at their middle times what differs from it, so that no
digits are lost however many values there are.

So Welch's t-test before its data is a mean over all ratios that two estimated variances may have. Given the share of
group a in the two sums of squares (in units of their variances; a beta variable) the degrees of freedom are known, and
t is a multiple of a noncentral t.

Integrals are taken by Gauss and Kronrod's rules of 10 and 21 nodes, many at once, halving panels until the digits
stand. The rule's numbers and the estimate of its error are those of QUADPACK's QK21 (Piessens and others 1983).

Chances that t-tests of known critical values reject are those of two one-sided ones (Owen's Q), and of either side of
one. With U = sqrt(chi^2_nu / nu), a standard error estimated with nu degrees of freedom in units of the true one, they
are means of normal probabilities over U. Each is right to 1e-10 of itself, down to 1e-290.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import special

from stats.exact.numbers import Number, exact_root, to_double
from stats.exact.tails import df_of_arrays, t_upper_quantiles

Floats: TypeAlias = NDArray[np.float64]
Rows: TypeAlias = NDArray[np.intp]
Integrand: TypeAlias = Callable[[Floats, Rows], Floats]
"""From points (panels, nodes) and the integral that each panel (panels,) belongs to, to values (panels, nodes)."""


class Panels(NamedTuple):
    """Where integrals are taken: ends and the number of its integral for each panel, all (panels,)."""

    left: Floats
    right: Floats
    rows: Rows


def _both_sides(half: list[float], sign: float) -> Floats:
    """Return a symmetric rule's numbers from those at and below its middle, which is the last of them."""
    return np.array([*half, *(sign * number for number in half[-2::-1])])


_HALF = [
    -0.995657163025808080735527280689003,
    -0.973906528517171720077964012084452,
    -0.930157491355708226001207180059508,
    -0.865063366688984510732096688423493,
    -0.780817726586416897063717578345042,
    -0.679409568299024406234327365114874,
    -0.562757134668604683339000099272694,
    -0.433395394129247190799265943165784,
    -0.294392862701460198131126603103866,
    -0.14887433898163121088482600112972,
    0.0,
]
_KRONROD = [
    0.011694638867371874278064396062192,
    0.03255816230796472747881897245939,
    0.05475589657435199603138130024458,
    0.07503967481091995276704314091619,
    0.093125454583697605535065465083366,
    0.109387158802297641899210590325805,
    0.123491976262065851077958109585166,
    0.134709217311473325928054001771707,
    0.142775938577060080797094273138717,
    0.147739104901338491374841515972068,
    0.149445554002916905664936468389821,
]
NODES, _WEIGHTS = _both_sides(_HALF, -1.0), _both_sides(_KRONROD, 1.0)
_GAUSS_WEIGHTS = np.polynomial.legendre.leggauss(10)[1]
_MOST_HALVINGS, _MOST_OPEN = 60, 64
_NOISE = 50.0 * float(np.finfo(np.float64).eps)


def panels_between(edges: Floats) -> Panels:
    """Return the panels between neighbours of `edges` (integrals, edges), which need no order; empty ones are left."""
    edges = np.sort(edges, axis=1)
    left, right = edges[:, :-1], edges[:, 1:]
    wide = right > left
    return Panels(left[wide], right[wide], np.nonzero(wide)[0])


def integrals(integrand: Integrand, panels: Panels, count: int, tolerance: float, floor: float = 0.0) -> Floats:
    """Return `count` integrals of a function that is not negative.

    The estimated error of each panel is below `tolerance` of its integral, or below `floor`. Edges of panels belong
    where the integrand has a kink or a step: there is no other loss of order.
    """
    totals = np.zeros(count)
    left, right, rows = panels
    for _ in range(_MOST_HALVINGS):
        half = (right - left) / 2.0
        middle = left + half
        values = integrand(middle[:, None] + half[:, None] * NODES, rows)
        found = half * _weighted(values, _WEIGHTS)
        coarse = half * _weighted(values[:, 1::2], _GAUSS_WEIGHTS)
        mean = _weighted(values, _WEIGHTS) / 2.0
        spread = half * _weighted(np.abs(values - mean[:, None]), _WEIGHTS)
        error = np.abs(found - coarse)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            error = np.where(spread > 0.0, spread * np.minimum(1.0, (200.0 * error / spread) ** 1.5), 0.0)
        so_far = totals + np.bincount(rows, found, count)
        open_ = error > np.maximum(np.maximum(tolerance * so_far[rows], floor), _NOISE * found)
        if not open_.any() or np.count_nonzero(open_) > _MOST_OPEN * (count + 1):
            return so_far
        done = ~open_
        totals += np.bincount(rows[done], found[done], count)
        left, middle, right, rows = left[open_], middle[open_], right[open_], rows[open_]
        left, right, rows = np.concatenate([left, middle]), np.concatenate([middle, right]), np.tile(rows, 2)
    return totals + np.bincount(rows, np.tile(found[open_] / 2.0, 2), count)


def _weighted(values: Floats, weights: Floats) -> Floats:
    # Not `@`: starting threads for so few numbers takes far longer than the sums.
    return np.asarray(np.einsum("ij,j->i", values, weights))


TOLERANCE = 1e-10
"""Of each panel of an integral, of the whole; what the rule leaves of a smooth one is far below it."""
_PANELS, _SHARP, _BESIDE = 4, 20.0, np.array([-5.0, 0.0, 5.0])
_REACH = 36.0
"""Logarithm below its largest value where an integrand does not count."""
_UNDERFLOW = 740.0
"""Logarithm below which nothing is a double."""
_SCAN, _ENOUGH, _MOST_SCANS = 13, 4, 12
_MANY_DF, _NEAR, _TERMS = 1000.0, 0.03, 9
_MANY, _TINY = 16.0, 1e-300
_STEPS = (-38.0, -16.0, -9.0, -4.0, 0.0, 4.0, 9.0, 16.0, 38.0)
_FACTORS = (0.2, 1.0, 5.0, 25.0, 125.0, 625.0)


def mean_over_scale(
    value: Integrand, df: float, turns: Floats, widths: Floats, last: Floats | None = None, floor: float = 0.0
) -> Floats:
    """Return the means (rows,) of a value of 0 to 1 that falls as U = sqrt(chi^2_df / df) grows, log-concave in U.

    It turns at `turns` over `widths`, both (rows, turns), and comes to 0 at `last` (rows,). Each mean is right to
    `TOLERANCE` of itself, down to 1e-290, or to `floor` in each panel.
    """
    count = turns.shape[0]
    low, high = _reach(value, df, count, last)
    low, high = np.exp(low), np.exp(high)
    sharp = np.where(widths < (high - low)[:, None] / _SHARP, widths, np.nan)
    beside = (turns[:, :, None] + sharp[:, :, None] * _BESIDE).reshape(count, -1)
    beside = np.clip(np.where(np.isnan(beside), low[:, None], beside), low[:, None], high[:, None])
    edges = np.concatenate([np.linspace(low, high, _PANELS + 1, axis=1), beside], axis=1)

    def integrand(u: Floats, rows: Rows) -> Floats:
        log_u = np.log(np.maximum(u, _TINY))
        return np.exp(log_scale_density(log_u, df) - log_u) * value(u, rows)

    return integrals(integrand, panels_between(edges), count, TOLERANCE, floor)


def _reach(value: Integrand, df: float, count: int, last: Floats | None) -> tuple[Floats, Floats]:
    """Return logarithms of U between which, and hardly farther, the value times the density counts."""
    high = np.full(count, _highest(df, _REACH))
    if last is not None:
        with np.errstate(divide="ignore"):
            high = np.minimum(high, np.log(last))
    low, farthest = (np.minimum(-math.sqrt(reach / df), high) - reach / df for reach in (_REACH, _UNDERFLOW))
    rows = np.arange(count)
    for _ in range(_MOST_SCANS):
        log_u = np.linspace(low, high, _SCAN, axis=1)
        with np.errstate(divide="ignore"):
            log_values = log_scale_density(log_u, df) + np.log(value(np.exp(log_u), rows))
        counts = log_values >= log_values.max(axis=1, keepdims=True) - _REACH
        first, final = counts.argmax(axis=1), _SCAN - 1 - counts[:, ::-1].argmax(axis=1)
        beyond = (first == 0) & (low > farthest)
        low = np.where(beyond, farthest, log_u[rows, np.maximum(first - 1, 0)])
        high = log_u[rows, np.minimum(final + 1, _SCAN - 1)]
        if not beyond.any() and (final - first >= _ENOUGH).all():
            break
    return low, high


def log_scale_density(log_u: Floats, df: float) -> Floats:
    """Return the logarithm of the density of ln U, U = sqrt(chi^2_df / df)."""
    twice = 2.0 * log_u
    beyond = np.expm1(twice) - twice
    if df > _MANY_DF:  # with fewer what is lost does not count
        near = np.abs(twice) < _NEAR
        small = np.where(near, twice, 0.0)
        series = np.zeros_like(small)
        for k in range(_TERMS, 1, -1):  # exp(x) - 1 - x = x^2 / 2 (1 + x / 3 (1 + x / 4 (1 + ...)))
            series = small / k * (1.0 + series) if k > 2 else small * small / 2.0 * (1.0 + series)
        beyond = np.where(near, series, beyond)
    return 0.5 * math.log(df / math.pi) - stirling_rest(df / 2.0) - df / 2.0 * beyond


def _highest(df: float, reach: float) -> float:
    """Return a logarithm of U where its density is `reach` below its middle's, in logarithms, or a little more."""
    far = 2.0 * reach / df
    # exp(x) - 1 - x is at least x^2 / 2, and beyond 2 at least exp(x) / 2.
    return min(math.sqrt(2.0 * far), max(2.0, math.log(2.0 * far))) / 2.0


def stirling_rest(x: float) -> float:
    """Return ln Gamma(x) - (x - 1/2) ln x + x - ln(2 pi) / 2."""
    below = 0.0
    while x < _MANY:
        below += (x + 0.5) * math.log1p(1.0 / x) - 1.0
        x += 1.0
    square = x * x
    series = (
        1.0 / 12.0 - (1.0 / 360.0 - (1.0 / 1260.0 - (1.0 / 1680.0 - 1.0 / 1188.0 / square) / square) / square) / square
    )
    return below + series / x


def mean_over_share(
    value: Callable[[Floats, Floats], Floats], df_a: float, df_b: float, turn: float, floor: float = 0.0
) -> float:
    """Return the mean of a value over the share of a in both sums of squares.

    `value` goes from the shares of a and of b, both (points,), to values of 0 to 1 (points,). It changes where the
    square root of their ratio is about `turn`. Right to `TOLERANCE` of itself or to `floor` in each panel.
    """

    def weighted(angle: Floats) -> Floats:
        sine, cosine = np.sin(angle), np.cos(angle)
        return np.exp(_log_share_density(sine, cosine, df_a, df_b)) * value(sine * sine, cosine * cosine)

    edges = _angles(df_a, df_b, turn)
    middles = (edges[:-1] + edges[1:]) / 2.0
    # A panel counts where its ends or its middle do.
    found = weighted(np.concatenate([edges[1:-1], middles]))
    at = np.concatenate([[0.0], found[: edges.size - 2], [0.0]])
    size = np.maximum(np.maximum(at[:-1], at[1:]), found[edges.size - 2 :]) * np.diff(edges)
    counts = size > math.exp(-_REACH) * size.max()
    if not counts.any():
        return 0.0
    panels = Panels(*(part[counts] for part in panels_between(edges[None, :])))

    def integrand(angle: Floats, _rows: Rows) -> Floats:
        return weighted(angle.ravel()).reshape(angle.shape)

    return float(integrals(integrand, panels, 1, TOLERANCE, floor)[0])


def _angles(df_a: float, df_b: float, turn: float) -> Floats:
    """Return edges from 0 to pi / 2 in the angle whose squared sine is a's share.

    The density has its middle at the angle of the degrees of freedom and a width of 1 / sqrt(2 df); what depends on
    the ratio of two variances is spread around the angle of `turn` as multiples of its distance from the nearer end.
    """
    right = math.pi / 2.0
    middle, width = math.atan2(math.sqrt(df_a), math.sqrt(df_b)), 1.0 / math.sqrt(2.0 * (df_a + df_b))
    edges = {0.0, right / 2.0, right, *(middle + width * steps for steps in _STEPS)}
    if turn <= 1.0:
        edges.update(math.atan(turn) * factor for factor in _FACTORS)
    else:
        edges.update(right - math.atan(1.0 / turn) * factor for factor in _FACTORS)
    return np.array(sorted(edge for edge in edges if 0.0 <= edge <= right))


def _log_share_density(sine: Floats, cosine: Floats, df_a: float, df_b: float) -> Floats:
    """Return the logarithm of the density of the angle whose squared sine is a's share."""
    if df_a > df_b:
        return _log_share_density(cosine, sine, df_b, df_a)
    a, b = df_a / 2.0, df_b / 2.0
    log_odds = 2.0 * np.log(sine / cosine) - math.log(a / b)
    with np.errstate(over="ignore"):
        beside = a * log_odds - (a + b) * np.log1p(a / (a + b) * np.expm1(log_odds))
    at_middle = (
        0.5 * math.log(a * b / (a + b) / (2.0 * math.pi)) + stirling_rest(a + b) - stirling_rest(a) - stirling_rest(b)
    )
    return at_middle + beside + math.log(2.0) - np.log(sine * cosine)


def over_standard_error(difference: Number, sds: tuple[float, float], sizes: tuple[int, int]) -> float:
    """Return a difference in its standard errors; infinite where no double is as large."""
    squared = Fraction(sds[0]) ** 2 / sizes[0] + Fraction(sds[1]) ** 2 / sizes[1]
    return to_double(Fraction(difference) / exact_root(squared))


def mean_over_criticals(
    value: Callable[[Floats], Floats], sds: tuple[float, float], sizes: tuple[int, int], tail: Fraction
) -> float:
    """Return the mean of what `value` makes of critical values, over the share of group a in both sums of squares.

    A critical value is Welch's one-sided at `tail`, for a t that is divided by the true standard error times a
    chi / sqrt(df) with n_a + n_b - 2 degrees of freedom. Right to 1e-10 of itself where `value` is.
    """
    df_a, df_b = sizes[0] - 1.0, sizes[1] - 1.0
    df = df_a + df_b
    exponent = math.frexp(max(sds))[1]  # only the proportion of the variances counts
    true_a, true_b = (math.ldexp(sd, -exponent) ** 2 / size for sd, size in zip(sds, sizes, strict=True))

    def of_shares(share_a: Floats, share_b: Floats) -> Floats:
        part_a, part_b = share_a * true_a * df / df_a, share_b * true_b * df / df_b
        both = part_a + part_b
        quantiles = t_upper_quantiles(tail, df_of_arrays(part_a, part_b, df_a, df_b))
        return value(quantiles * np.sqrt(both / (true_a + true_b)))

    turn = math.sqrt(true_b / df_b) / math.sqrt(true_a / df_a) if true_a > 0.0 else math.inf
    return mean_over_share(of_shares, df_a, df_b, turn)


_FAR = 1e150
"""Standard errors that count as infinitely many."""
_NARROW = 0.5
_FEW_NODES, _FEW_WEIGHTS = (np.asarray(part) for part in np.polynomial.legendre.leggauss(6))


def within_both(low: float, high: float, critical: Floats, df: float) -> Floats:
    """Return P(low + critical U <= Z <= high - critical U), Owen's Q function, for each of some critical values."""
    low, high, critical = _doubles(low), _doubles(high), np.clip(critical, 1.0 / _FAR, _FAR)
    if not low < high:
        return np.zeros_like(critical)
    last = np.maximum((high - low) / 2.0 / critical, 1.0 / _FAR**2)
    turns = np.stack([-low / critical, high / critical], axis=1)

    def inside(u: Floats, rows: Rows) -> Floats:
        half = critical[rows, None] * u
        return normal_between(low + half, high - half)

    return mean_over_scale(inside, df, turns, 1.0 / critical[:, None], last)


def normal_between(low: Floats, high: Floats) -> Floats:
    """Return P(low <= Z <= high), right to the last digits of itself also far out and where the ends are close."""
    upper = low > 0.0  # the lower tail keeps its digits
    low, high = np.where(upper, -high, low), np.where(upper, -low, high)
    inside = np.maximum(special.ndtr(high) - special.ndtr(low), 0.0)
    half = (high - low) / 2.0
    middle = low + half
    narrow = (half > 0.0) & (half * (1.0 + np.abs(middle)) < _NARROW / 2.0)
    if narrow.any():
        half, middle = half[narrow], middle[narrow]
        at = middle[..., None] + half[..., None] * _FEW_NODES
        inside[narrow] = half * np.einsum("ij,j->i", np.exp(-at * at / 2.0), _FEW_WEIGHTS) / math.sqrt(2.0 * math.pi)
    return np.asarray(inside)


def beyond_either(distance: float, critical: Floats, df: float, sides: int) -> Floats:
    """Return P(Z + distance > critical U), and for two sides P(Z + distance < -critical U) with it, one each."""
    if sides == 2:
        distance = abs(distance)
    distance, critical = _doubles(distance), np.clip(critical, 1.0 / _FAR, _FAR)

    def beyond(u: Floats, rows: Rows) -> Floats:
        edge = critical[rows, None] * u
        upper = special.ndtr(distance - edge)
        return np.asarray(upper + special.ndtr(-distance - edge) if sides == 2 else upper)

    return mean_over_scale(beyond, df, (distance / critical)[:, None], 1.0 / critical[:, None])


def _doubles(distance: float) -> float:
    """Return a number of standard errors that can be calculated with."""
    return min(max(distance, -_FAR), _FAR)
