"""Two groups compared by Welch's t, or by name as in thesis 5.2.1: an F-test, then Student's or Welch's t.

Choosing the t-test by an F-test inflates its error rate where n differs between the groups (0.11 instead of 0.05
at n = 5 and 20 with an SD ratio of 2); Welch's t holds its level and is the default.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from numpy.typing import ArrayLike
from scipy import special

from data_schema.errors import InputRefused, unknown_name
from data_schema.reasons import Reason
from data_schema.rounding import error_of, interval_text, number_text, p_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_level
from stats.compare.summary import AS_A_AND_B, Names, TTest, student, welch
from stats.groups.variances import variance_ratio
from stats.results import Result, missing_text, with_unit
from stats.scatter import Interval, Value, finite, read_groups

Route = Literal["f_then_t", "welch", "student"]
ROUTES: tuple[Route, ...] = ("f_then_t", "welch", "student")
"""How the t-test is chosen: by the F-test at alpha (the thesis's route), or fixed beforehand."""


@dataclass(frozen=True, slots=True)
class TwoSample(Result):
    """Group a against group b; means and differences in the unit of the values."""

    n_a: int
    """Number of values of group a."""
    n_b: int
    """Number of values of group b."""
    mean_a: Value
    """Mean of group a, in the unit of the values."""
    mean_b: Value
    """Mean of group b, in the unit of the values."""
    route: Route
    """How the test was chosen."""
    alpha: float
    """Level of the F-test; intervals have level 1 - alpha."""
    f: Value
    """var(a) / var(b), dimensionless (thesis 5.2.1)."""
    f_p: Value
    """Two-sided p of the F-test for equal variances."""
    test: str
    """The t-test used: "Student" or "Welch"."""
    t: Value
    """Difference over its standard error by the test used."""
    df: Value
    """Degrees of freedom of the test used."""
    p: Value
    """Two-sided."""
    difference: Value
    """mean(a) - mean(b), in the unit of the values; exists where the test does not."""
    difference_ci: Interval | Undefined
    """Student's interval of the difference by the test used."""
    hedges_g: Value
    """Signed difference in pooled standard deviations, with the exact small-sample factor."""
    missing: int
    """Values left out because they were NaN."""
    names: Names
    """What groups a and b are called in reasons and in the sentence."""

    def sentence(self, a: str | None = None, b: str | None = None, unit: str = "") -> str:
        """Return the comparison in words: means, difference with interval, test, p, n."""
        a, b = self.names[0] if a is None else a, self.names[1] if b is None else b
        if isinstance(self.difference, Undefined):
            return f"{a} (n = {self.n_a}) and {b} (n = {self.n_b}) cannot be compared: {self.difference.reason}."
        error = error_of(self.difference_ci)
        smaller = min((size for size in (error, abs(self.difference)) if size > 0.0), default=0.0)
        mean_a, mean_b = (number_text(mean, error=smaller) for mean in (self.mean_a, self.mean_b))
        text = (
            f"{a} (mean {mean_a}{with_unit(unit)}, n = {self.n_a}) minus "
            f"{b} (mean {mean_b}{with_unit(unit)}, n = {self.n_b}) is "
            f"{number_text(self.difference, error=error)}{with_unit(unit)} "
            f"({interval_text(self.difference_ci, 1.0 - self.alpha, unit)})"
        )
        if isinstance(self.t, Undefined):
            return f"{text}; no test, because {self.t.reason}."
        p = p_text(self.p, self.alpha)
        test = f"{self.test}'s {statistic_text('t', self.t, (self.df,))}, {p}"
        return f"{text}, {test}, Hedges's g {number_text(self.hedges_g)}{missing_text(self.missing)}."


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
    if len(names) != 2 or names[0] == names[1]:
        raise InputRefused(f"the groups are called {names!r}: give two names that differ, as ('control', 'treated').")
    alpha = as_level("alpha", alpha)
    read = read_groups({names[0]: a, names[1]: b}, missing)
    by_name = {group.name: group for group in read.filled}
    n_a, n_b = (by_name[name].n if name in by_name else 0 for name in names)
    means = dict(zip(read.names, read.means, strict=True))
    f: Value
    f_p: Value
    difference: Value
    g: Value
    if read.empty:
        none = Undefined(Reason.GROUP_EMPTY, group=f"group {read.empty[0]}")
        test, use_student = TTest(none, none, none, none, none), route == "student"
        f = f_p = difference = g = none
    else:
        (of_a, of_b), scale = read.filled, read.scale
        f, f_p = variance_ratio(of_a, of_b)
        use_student = route == "student" or (route == "f_then_t" and isinstance(f_p, float) and f_p >= alpha)
        by_student = student(of_a, of_b, scale, 1.0 - alpha)
        test = by_student if use_student else welch(of_a, of_b, scale, 1.0 - alpha)
        difference, g = scale.length(of_a.mean - of_b.mean), _hedges_g(by_student.t, n_a, n_b)
    return TwoSample(
        n_a=n_a,
        n_b=n_b,
        mean_a=means.get(names[0], Undefined(Reason.GROUP_EMPTY, group=f"group {names[0]}")),
        mean_b=means.get(names[1], Undefined(Reason.GROUP_EMPTY, group=f"group {names[1]}")),
        route=route,
        alpha=alpha,
        f=f,
        f_p=f_p,
        test="Student" if use_student else "Welch",
        t=test.t,
        df=test.df,
        p=test.p,
        difference=difference,
        difference_ci=test.ci,
        hedges_g=g,
        missing=read.missing,
        names=names,
    )


def _hedges_g(pooled_t: Value, n_a: int, n_b: int) -> Value:
    """Return Hedges's g (1981) from Student's t, with the exact factor that frees Cohen's d of its bias."""
    df = n_a + n_b - 2
    if df < 2:
        return Undefined(Reason.TOO_FEW_FOR_G)
    if isinstance(pooled_t, Undefined):
        return pooled_t
    factor = float(special.poch((df - 1) / 2.0, 0.5)) / math.sqrt(df / 2.0)
    return finite(factor * pooled_t * math.sqrt(1.0 / n_a + 1.0 / n_b), "Hedges's g")
