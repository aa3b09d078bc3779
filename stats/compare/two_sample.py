"""Two groups compared by Welch's t, or by name as in thesis 5.2.1: an F-test, then Student's or Welch's t.

Choosing the t-test by an F-test inflates its error rate where n differs between the groups (0.11 instead of 0.05
at n = 5 and 20 with an SD ratio of 2), and the F-test itself rejects normal-looking but heavy-tailed data far too
often; Brown and Forsythe's test and Welch's t hold their level and are therefore never left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from numpy.typing import ArrayLike

from data_schema.errors import unknown_name
from data_schema.reasons import Reason
from data_schema.rounding import error_of, interval_text, number_text, p_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_level, as_pair, as_sample
from stats.compare.effect_size import hedges_factor, hedges_g_ci
from stats.compare.summary import AS_A_AND_B, Names, empty, pair_of_names, student, welch
from stats.exact.numbers import Moments, exact_root, finite, moments
from stats.exact.tails import complement_level
from stats.groups.variances import brown_forsythe_of, variance_ratio
from stats.results import Result, missing_text, with_unit

Route = Literal["f_then_t", "welch", "student"]
ROUTES: tuple[Route, ...] = ("f_then_t", "welch", "student")
"""How the t-test is chosen: by the F-test at alpha (the thesis's route), or fixed beforehand."""

_Interval = tuple[float, float]


@dataclass(frozen=True, slots=True)
class TwoSample(Result):
    """Group a against group b; means and differences in the unit of the values."""

    n_a: int
    """Number of values of group a."""
    n_b: int
    """Number of values of group b."""
    mean_a: float | Undefined
    """Mean of group a, in the unit of the values."""
    mean_b: float | Undefined
    """Mean of group b, in the unit of the values."""
    route: Route
    """How the test was chosen."""
    alpha: float
    """Level of the F-test; intervals have level 1 - alpha."""
    f: float | Undefined
    """var(a) / var(b), dimensionless (thesis 5.2.1)."""
    f_p: float | Undefined
    """Two-sided p of the F-test for equal variances."""
    f_log10_p: float | Undefined
    """Its decimal logarithm."""
    equal_variances: bool | Undefined
    """Whether `f_p` is at least alpha."""
    brown_forsythe_p: float | Undefined
    """p of Brown and Forsythe's test (absolute deviations from the medians), which holds its level."""
    brown_forsythe_log10_p: float | Undefined
    """Its decimal logarithm."""
    test: str
    """The t-test used: "Student" or "Welch"."""
    t: float | Undefined
    """Difference over its standard error by the test used."""
    df: float | Undefined
    """Degrees of freedom of the test used."""
    p: float | Undefined
    """Two-sided."""
    log10_p: float | Undefined
    """Decimal logarithm of p, right where p is too small for a double."""
    difference: float | Undefined
    """mean(a) - mean(b), in the unit of the values; exists where the test does not."""
    difference_ci: _Interval | Undefined
    """Student's interval of the difference by the test used."""
    welch_t: float | Undefined
    """Welch's t, whatever the test used."""
    welch_df: float | Undefined
    """Welch and Satterthwaite's degrees of freedom."""
    welch_p: float | Undefined
    """Two-sided p of Welch's t."""
    welch_log10_p: float | Undefined
    """Its decimal logarithm."""
    welch_ci: _Interval | Undefined
    """Interval of the difference by Welch's standard error."""
    hedges_g: float | Undefined
    """Signed difference in pooled standard deviations, with the exact small-sample factor."""
    pooled_t: float | Undefined
    """Student's t, whatever the test: the statistic whose noncentral distribution bounds Hedges's g."""
    missing_a: int = 0
    """Values of group a left out because they were NaN."""
    missing_b: int = 0
    """Values of group b left out because they were NaN."""
    names: Names = AS_A_AND_B
    """What groups a and b are called in reasons and in the sentence."""

    @property
    def hedges_g_ci(self) -> _Interval | Undefined:
        """Interval of Hedges's g by the noncentral t distribution, level 1 - alpha; computed when asked for."""
        if isinstance(self.hedges_g, Undefined):
            return self.hedges_g
        if isinstance(self.pooled_t, Undefined):
            return self.pooled_t
        return hedges_g_ci(
            self.pooled_t, self.n_a + self.n_b - 2, self.n_a, self.n_b, float(complement_level(self.alpha))
        )

    def sentence(self, a: str | None = None, b: str | None = None, unit: str = "") -> str:
        """Return the comparison in words: means, difference with interval, test, p, n; Welch's t always."""
        a, b = self.names[0] if a is None else a, self.names[1] if b is None else b
        if isinstance(self.difference, Undefined):
            return f"{a} (n = {self.n_a}) and {b} (n = {self.n_b}) cannot be compared: {self.difference.reason}."
        error = error_of(self.difference_ci)
        smaller = min((size for size in (error, abs(self.difference)) if size > 0.0), default=0.0)
        mean_a, mean_b = (number_text(mean, error=smaller) for mean in (self.mean_a, self.mean_b))
        lost = ""
        if self.difference and self.mean_a == self.mean_b:
            lost = "; the means differ beyond the digits of a double"
        elif mean_a == mean_b and self.mean_a != self.mean_b:  # in the last digits only
            mean_a, mean_b = f"{self.mean_a!r}", f"{self.mean_b!r}"
        text = (
            f"{a} (mean {mean_a}{with_unit(unit)}, n = {self.n_a}) minus "
            f"{b} (mean {mean_b}{with_unit(unit)}, n = {self.n_b}) is "
            f"{number_text(self.difference, error=error)}{with_unit(unit)} "
            f"({interval_text(self.difference_ci, 1.0 - self.alpha, unit)}{lost})"
        )
        if isinstance(self.t, Undefined):
            return f"{text}; no test, because {self.t.reason}."
        p = p_text(self.p, self.alpha)
        text += f", {self.test}'s {statistic_text('t', self.t, (self.df,))}, {p}"
        if self.test != "Welch" and not isinstance(self.welch_t, Undefined):
            welch_p = p_text(self.welch_p, self.alpha)
            text += f" (Welch's {statistic_text('t', self.welch_t, (self.welch_df,))}, {welch_p})"
        g = number_text(self.hedges_g, error=error_of(self.hedges_g_ci))
        effect = f"Hedges's g {g} ({interval_text(self.hedges_g_ci, 1.0 - self.alpha)})"
        return f"{text}, {effect}{missing_text(self.missing_a, self.missing_b)}."


def compare_two(
    a: ArrayLike,
    b: ArrayLike,
    route: Route = "welch",
    alpha: float = 0.05,
    missing: Missing = "refuse",
    *,
    names: Names = AS_A_AND_B,
) -> TwoSample:
    """Compare two independent groups, shapes (n_a,) and (n_b,), by a two-sided t-test: Welch's, or as `route` says.

    Every field stands for itself: two constant groups still have a difference, but no t and no p. Raises `UnknownName`
    for another route and `InputRefused` for infinite values, and for NaN unless `missing` is "drop". `names` are what
    the groups are called in the sentence, and where something is undefined or refused.

    >>> found = compare_two([42.1, 39.8, 44.0, 41.2], [36.9, 38.2, 35.1, 37.7])
    >>> found.test, round(found.t, 2), round(found.p, 4)
    ('Welch', 4.32, 0.0058)
    """
    if route not in ROUTES:
        raise unknown_name("route", route, ROUTES)
    alpha, names = as_level("alpha", alpha), pair_of_names(names)
    first, second = (as_sample(f"group {name}", x, missing) for name, x in zip(names, (a, b), strict=True))
    of_a, of_b = moments(first.values, first.rest), moments(second.values, second.rest)

    ratio, of_ratio = variance_ratio(of_a, of_b, names)
    equal: bool | Undefined = of_ratio if isinstance(of_ratio, Undefined) else of_ratio.p >= alpha
    difference = _difference(of_a, of_b, names)
    spreads = brown_forsythe_of(as_pair(names, first, second))
    by_welch, by_student = (test(of_a, of_b, complement_level(alpha), names) for test in (welch, student))
    use_student = route == "student" or (route == "f_then_t" and equal is True)
    chosen = by_student if use_student else by_welch
    return TwoSample(
        n_a=of_a.n,
        n_b=of_b.n,
        mean_a=of_a.mean if of_a.n else empty(of_a, names),
        mean_b=of_b.mean if of_b.n else Undefined(Reason.GROUP_EMPTY, group=f"group {names[1]}"),
        route=route,
        alpha=alpha,
        f=ratio if isinstance(ratio, Undefined) else finite(ratio, "the ratio"),
        f_p=of_ratio if isinstance(of_ratio, Undefined) else of_ratio.p,
        f_log10_p=of_ratio if isinstance(of_ratio, Undefined) else of_ratio.log10_p,
        equal_variances=equal,
        brown_forsythe_p=spreads.p,
        brown_forsythe_log10_p=spreads.log10_p,
        test="Student" if use_student else "Welch",
        t=chosen.t,
        df=chosen.df,
        p=chosen.p,
        log10_p=chosen.log10_p,
        difference=difference,
        difference_ci=chosen.ci,
        welch_t=by_welch.t,
        welch_df=by_welch.df,
        welch_p=by_welch.p,
        welch_log10_p=by_welch.log10_p,
        welch_ci=by_welch.ci,
        hedges_g=_hedges_g(of_a, of_b, names),
        pooled_t=by_student.t,
        missing_a=first.missing,
        missing_b=second.missing,
        names=names,
    )


def _difference(a: Moments, b: Moments, names: Names) -> float | Undefined:
    if a.n == 0 or b.n == 0:
        return empty(a, names)
    return finite(a.exact_mean - b.exact_mean, "the difference")


def _hedges_g(a: Moments, b: Moments, names: Names) -> float | Undefined:
    if a.n == 0 or b.n == 0:
        return empty(a, names)
    df = a.n + b.n - 2
    if df < 2:
        return Undefined(Reason.TOO_FEW_FOR_G)
    sum_squares = a.exact_sum_squares + b.exact_sum_squares
    if sum_squares == 0:
        return Undefined(Reason.GROUPS_WITHOUT_SCATTER)
    g = Fraction(hedges_factor(df)) * (a.exact_mean - b.exact_mean) / exact_root(sum_squares / df)
    return finite(g, "Hedges's g")
