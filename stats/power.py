"""How likely an experiment finds what is there, and how many values it needs: t-tests, ANOVA, equivalence.

Nothing is approximated by the normal distribution: Student's t, F and both one-sided tests through their noncentral
distributions, Welch's t by integration over the ratio of the two estimated variances, on which its degrees of freedom
depend. Differences and standard deviations have the unit of the values. Values are independent: where days are compared
within, `sd` is the scatter within days; where conditions have days of their own, count days, not values.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import special

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.checks import as_count, as_level, as_number, as_values
from stats.noncentral import f_tails, t_tails
from stats.owens_q import NODES, TINY, WEIGHTS, within_both
from stats.results import Result
from stats.wording import number_text

LARGEST_N = 1_000_000


@dataclass(frozen=True, slots=True)
class Power(Result):
    """The chance that a planned test rejects, for the effect and the scatter assumed."""

    test: str
    """The test in words, with its assumptions."""
    group_ns: tuple[int, ...]
    """Number of values of each group."""
    alpha: float
    """Level of the test."""
    power: float | Undefined
    """Chance of rejecting, 0 to 1."""

    def sentence(self) -> str:
        """Return the plan in words: sizes, test, level, chance."""
        sizes = ", ".join(map(str, self.group_ns))
        if isinstance(self.power, Undefined):
            return f"No power for {self.test} with n = {sizes}: {self.power.reason}."
        return (
            f"With n = {sizes} {self.test} at alpha = {self.alpha:g} has a chance of "
            f"{number_text(100.0 * self.power, 3)} % to reject."
        )


def power_t(difference: float, sd: float, n_a: int, n_b: int, alpha: float = 0.05, sides: int = 2) -> Power:
    """Return the power of Student's t for a true difference at one standard deviation; `sides` is 1 (upward) or 2."""
    difference, sd, alpha = (
        as_number("difference", difference),
        as_number("sd", sd, above=0.0),
        as_level("alpha", alpha),
    )
    sizes, sides = _sizes(n_a, n_b), _sides(sides)
    test = f"Student's t-test for a difference of {difference:g} at sd {sd:g} ({_sided(sides)})"
    df = sum(sizes) - 2
    if df < 1 or min(sizes) < 1:
        return Power(test, sizes, alpha, Undefined("there are too few values for a pooled variance"))
    ncp = difference / (sd * math.sqrt(1.0 / sizes[0] + 1.0 / sizes[1]))
    critical = -float(special.stdtrit(df, alpha / sides))
    power = t_tails(critical, df, ncp)[1]
    return Power(test, sizes, alpha, min(1.0, power + (t_tails(critical, df, -ncp)[1] if sides == 2 else 0.0)))


def power_welch(
    difference: float, sd_a: float, sd_b: float, n_a: int, n_b: int, alpha: float = 0.05, sides: int = 2
) -> Power:
    """Return the power of Welch's t for a true difference at two standard deviations.

    Given the share B of group a in the two sums of squares (in units of their variances; a beta variable) the degrees
    of freedom are known and t is a multiple of a noncentral t with n_a + n_b - 2 of them; B is integrated over.
    """
    difference, alpha = as_number("difference", difference), as_level("alpha", alpha)
    sds = as_number("sd of a", sd_a, above=0.0), as_number("sd of b", sd_b, above=0.0)
    sizes, sides = _sizes(n_a, n_b), _sides(sides)
    test = f"Welch's t-test for a difference of {difference:g} at sd {sds[0]:g} and {sds[1]:g} ({_sided(sides)})"
    if min(sizes) < 2:
        return Power(test, sizes, alpha, Undefined("each group needs at least 2 values for its variance"))
    df_a, df_b = sizes[0] - 1.0, sizes[1] - 1.0
    df = df_a + df_b
    true_a, true_b = sds[0] ** 2 / sizes[0], sds[1] ** 2 / sizes[1]
    ncp = difference / math.sqrt(true_a + true_b)
    total = 0.0
    for share, weight in zip(*_share_nodes(df_a, df_b), strict=True):
        part_a, part_b = share * true_a * df / df_a, (1.0 - share) * true_b * df / df_b
        both = part_a + part_b
        welch_df = 1.0 / ((part_a / both) ** 2 / df_a + (part_b / both) ** 2 / df_b)
        critical = -float(special.stdtrit(welch_df, alpha / sides)) * math.sqrt(both / (true_a + true_b))
        total += weight * (t_tails(critical, df, ncp)[1] + (t_tails(critical, df, -ncp)[1] if sides == 2 else 0.0))
    return Power(test, sizes, alpha, min(1.0, total))


def _share_nodes(df_a: float, df_b: float) -> tuple[list[float], list[float]]:
    """Return nodes and weights of the beta distribution of chi^2_a / (chi^2_a + chi^2_b), as squares of sines."""
    a, b = df_a / 2.0, df_b / 2.0
    low = math.asin(math.sqrt(float(special.betaincinv(a, b, TINY))))
    high = math.acos(math.sqrt(float(special.betaincinv(b, a, TINY))))
    half = (high - low) / 2.0
    angle = (low + high) / 2.0 + half * NODES
    log_density = (
        math.log(2.0)
        - float(special.betaln(a, b))
        + (df_a - 1.0) * np.log(np.sin(angle))
        + (df_b - 1.0) * np.log(np.cos(angle))
    )
    weights = half * WEIGHTS * np.exp(log_density)
    return [float(x) for x in np.sin(angle) ** 2], [float(x) for x in weights]


def power_anova(means: Sequence[float], sd: float, n: int, alpha: float = 0.05) -> Power:
    """Return the power of one-way ANOVA for true means of groups with `n` values each at one standard deviation."""
    alpha, sd = as_level("alpha", alpha), as_number("sd", sd, above=0.0)
    truth = as_values("means", list(means))
    if truth.size < 2:
        raise InputRefused(f"{truth.size} means were given: give the true means of at least 2 groups.")
    n, k = as_count("n", n), truth.size
    test = f"one-way ANOVA for means {', '.join(f'{mean:g}' for mean in truth)} at sd {sd:g}"
    sizes = (n,) * k
    if n < 2:
        return Power(test, sizes, alpha, Undefined("each group needs at least 2 values"))
    ncp = n * float(np.sum((truth - truth.mean()) ** 2)) / sd**2
    df_within = k * (n - 1)
    critical = float(special.fdtri(k - 1, df_within, 1.0 - alpha))
    return Power(test, sizes, alpha, f_tails(critical, k - 1, df_within, ncp)[1])


def power_equivalence(
    difference: float, sd: float, low: float, high: float, n_a: int, n_b: int, alpha: float = 0.05
) -> Power:
    """Return the power of two one-sided t-tests (TOST) to show that a true difference lies between low and high."""
    difference, sd, alpha = (
        as_number("difference", difference),
        as_number("sd", sd, above=0.0),
        as_level("alpha", alpha),
    )
    low, high = as_number("low", low), as_number("high", high)
    if low >= high:
        raise InputRefused(f"the bounds are {low!r} and {high!r}: give the lower one first.")
    if alpha >= 0.5:
        raise InputRefused(f"alpha is {alpha!r}: give a number below 0.5 for an equivalence test.")
    sizes = _sizes(n_a, n_b)
    test = f"an equivalence test between {low:g} and {high:g} for a difference of {difference:g} at sd {sd:g}"
    df = sum(sizes) - 2
    if df < 1 or min(sizes) < 1:
        return Power(test, sizes, alpha, Undefined("there are too few values for a pooled variance"))
    se = sd * math.sqrt(1.0 / sizes[0] + 1.0 / sizes[1])
    critical = -float(special.stdtrit(df, alpha))
    return Power(test, sizes, alpha, within_both((low - difference) / se, (high - difference) / se, critical, df))


def sample_size(plan: Callable[[int], Power], power: float = 0.8, largest: int = LARGEST_N) -> Power | Undefined:
    """Return the plan with the smallest n, up to `largest`, whose power is at least `power`.

    `plan` makes a plan of n values a group, as `lambda n: power_t(0.5, 1.0, n, n)`; its power must not fall with n.
    """
    target = as_level("power", power)

    def enough(n: int) -> bool:
        found = plan(n).power
        return not isinstance(found, Undefined) and found >= target

    n = 2
    while not enough(n):
        if n >= largest:
            return Undefined(f"{largest} values a group do not reach a power of {target:g}")
        n = min(2 * n, largest)
    below = 1 if n == 2 else n // 2
    while n - below > 1:
        middle = (n + below) // 2
        below, n = (below, middle) if enough(middle) else (middle, n)
    return plan(n)


def _sizes(n_a: int, n_b: int) -> tuple[int, int]:
    return as_count("n_a", n_a), as_count("n_b", n_b)


def _sides(sides: int) -> int:
    if sides not in (1, 2):
        raise InputRefused(f"sides is {sides!r}: give 1 or 2.")
    return sides


def _sided(sides: int) -> str:
    return "two-sided" if sides == 2 else "one-sided"
