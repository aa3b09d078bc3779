"""One-way analysis of variance (thesis 5.2.1: joules a jump over the active-damping gain), and Welch's.

The first takes all groups to scatter alike; Welch's does not, and stands beside it in reports.

Each mean counts with its weight w = n / s^2, W the sum of the weights. With k groups,

    A = sum over pairs of w_i w_j (m_i - m_j)^2 / (W (k - 1)),    L = sum of (1 - w_i / W)^2 / (n_i - 1),
    F = A / (1 + 2 (k - 2) L / (k^2 - 1)),    df_between = k - 1,    df_within = (k^2 - 1) / (3 L).

A single group without scatter has an infinite weight, and all of this has a limit: only pairs with that group are left
in A, each with the other's weight, and its share w_i / W is 1. Two such groups have none: where they differ F is
infinite, where they agree df_within depends on how their variances vanish.

Eta squared of Welch's F is that of the classic F with Welch's F in its place, and n - k degrees of freedom.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

from data_schema.reasons import Reason
from data_schema.rounding import alpha_of_level, p_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, Samples, as_level
from stats.results import Result, missing_text, plural, share_text
from stats.scatter import Groups, Value, finite, read_groups
from stats.tails import f_upper


@dataclass(frozen=True, slots=True)
class _MeansCompared(Result):
    """Whether the means of several groups differ."""

    method: ClassVar[str]
    groups: tuple[str, ...]
    """Names of the k groups that hold values, as given; shape (k,)."""
    group_ns: tuple[int, ...]
    """Their sizes, shape (k,)."""
    f: Value
    """Dimensionless: (SS_between / df_between) / (SS_within / df_within), or Welch's F (Welch 1951)."""
    df_between: int
    """Number of groups minus 1."""
    df_within: Value
    """Number of values minus number of groups, or after Welch (1951), not whole in general."""
    p: Value
    """P(F >= f)."""
    eta_squared: Value
    """Share of variance between the groups, 0 to 1; too large on average where n is small.

    Of all values, or by Welch's F of each value in SDs of its own group.
    """
    omega_squared: Value
    """The same share with its bias taken off, by Welch's F nearly; 0 where F is below 1, as no share is negative."""
    empty_groups: tuple[str, ...]
    """Names of groups without a value."""
    level: float
    """Level of the intervals."""
    missing: int
    """How many values were left out as NaN."""

    def _limit(self) -> str:
        """Return what the sentence says of a limit that was taken."""
        return ""

    def sentence(self, what: str = "the groups") -> str:
        """Return the result in words: F, both degrees of freedom, p, both shares of variance, n."""
        test, sizes = (
            f"{self.method} ANOVA over {what}",
            f"{plural(len(self.groups), 'group')}, n = {sum(self.group_ns)}",
        )
        if isinstance(self.f, Undefined):
            return f"No {test} ({sizes}): {self.f.reason}."
        return (
            f"{test[0].upper()}{test[1:]}: {statistic_text('F', self.f, (self.df_between, self.df_within))}, "
            f"{p_text(self.p, alpha_of_level(self.level))}, eta squared {share_text(self.eta_squared)}, "
            f"omega squared {share_text(self.omega_squared)} ({sizes}{missing_text(self.missing)}{self._limit()})."
        )


@dataclass(frozen=True, slots=True)
class Anova(_MeansCompared):
    """Whether the means of several groups differ by more than their scatter explains."""

    method: ClassVar[str] = "one-way"
    df_within: int
    """Number of values minus number of groups."""
    ss_between: Value
    """Sum of squares between the groups, in the values' unit squared."""
    ss_within: Value
    """Sum of squares within the groups, in the values' unit squared."""
    residual_sd: Value
    """Standard deviation within the groups, in the values' unit."""
    group_means: tuple[float, ...]
    """Means of `groups`, in the values' unit; shape (k,)."""


@dataclass(frozen=True, slots=True)
class WelchAnova(_MeansCompared):
    """Whether the means of several groups differ, each group with a scatter of its own."""

    method: ClassVar[str] = "Welch"
    constant_group: str
    """Name of the one group without scatter, for which the limit was taken; empty where all groups scatter."""

    def _limit(self) -> str:
        return f"; limit for {self.constant_group!r}, which has no scatter" if self.constant_group else ""


def one_way_anova(groups: Samples, *, level: float = 0.95, missing: Missing = "refuse") -> Anova:
    """Analyse groups of values, each of shape (n_i,), all in one unit.

    A group without a value leaves the question open: there is no F, only what the other groups are.
    Raises `InputRefused`, naming the group, for infinite values, and for NaN unless `missing` is "drop".

    >>> found = one_way_anova({"0": [42.1, 39.8, 44.0], "50": [36.9, 38.2, 35.1]})
    >>> round(found.f, 2), found.df_between, found.df_within
    (12.0, 1, 4)
    """
    read, about, parts = _read(groups, level, missing, welch=False)
    why, df = parts["f"], (len(read.filled) - 1, read.df_within)
    parts |= dict.fromkeys(("ss_between", "ss_within", "residual_sd"), why)
    if df[0] > 0:
        between, within = read.squares_between, read.squares_within
        parts["eta_squared"] = between / (between + within) if between + within > 0.0 else Undefined(Reason.ALL_EQUAL)
        parts["ss_between"], parts["ss_within"] = read.in_squared_unit(between), read.in_squared_unit(within)
        if df[1] > 0:
            parts["residual_sd"] = read.scale.length(math.sqrt(within / df[1]), "the residual standard deviation")
        if why is None:
            f = (between / df[0]) / (within / df[1])
            parts |= _test(f, df[0], df[1], sum(read.sizes))
    return Anova(**about, **parts, df_within=df[1], group_means=read.means)


def welch_anova(groups: Samples, *, level: float = 0.95, missing: Missing = "refuse") -> WelchAnova:
    """Analyse groups of values, each of shape (n_i,), all in one unit, by Welch's F.

    Raises `InputRefused`, naming the group, for infinite values, and for NaN unless `missing` is "drop".
    """
    read, about, parts = _read(groups, level, missing, welch=True)
    constant = next((group for group in read.filled if group.n > 1 and group.constant), None)
    parts["df_within"] = parts["f"]
    if parts["f"] is None:
        k, n = len(read.filled), sum(read.sizes)
        weights = [0.0 if group.constant else 1.0 / group.mean_variance for group in read.filled]
        total = math.fsum(weights)
        if constant is None:
            centre = math.fsum(w * group.mean for w, group in zip(weights, read.filled, strict=True)) / total
            shares = [weight / total for weight in weights]
        else:  # the limit of a weight without end
            centre, shares = constant.mean, [float(group.constant) for group in read.filled]
        distances = math.fsum(w * (group.mean - centre) ** 2 for w, group in zip(weights, read.filled, strict=True))
        doubt = math.fsum((1.0 - share) ** 2 / (group.n - 1) for share, group in zip(shares, read.filled, strict=True))
        f = distances / (k - 1) / (1.0 + 2.0 * (k - 2) * doubt / (k * k - 1))
        df_within = (k * k - 1) / (3.0 * doubt)
        parts |= _test(f, k - 1, df_within, n)
        parts |= {"df_within": df_within, "eta_squared": (k - 1) * f / ((k - 1) * f + n - k)}
    return WelchAnova(**about, **parts, constant_group="" if constant is None else constant.name)


def _read(
    groups: Samples, level: float, missing: Missing, *, welch: bool
) -> tuple[Groups, dict[str, Any], dict[str, Any]]:
    """Return the groups, what both results say of them, and the parts of the test: why it is undefined, else None."""
    level, read = as_level("level", level), read_groups(groups, missing)
    about = {
        "groups": read.names,
        "group_ns": read.sizes,
        "df_between": max(len(read.filled) - 1, 0),
        "empty_groups": read.empty,
        "level": level,
        "missing": read.missing,
    }
    return read, about, dict.fromkeys(("f", "p", "eta_squared", "omega_squared"), _why_no_f(read, welch=welch))


def _test(f: float, df_between: int, df_within: float, n: int) -> dict[str, Any]:
    """Return the test by the names of its fields."""
    surplus = df_between * (f - 1.0)
    omega_squared = max(0.0, surplus / (surplus + n))
    return {"f": finite(f, "F"), "p": f_upper(f, df_between, df_within), "omega_squared": omega_squared}


def _why_no_f(read: Groups, *, welch: bool) -> Undefined | None:
    if len(read.filled) < 2:
        return Undefined(Reason.NO_GROUPS)
    if read.empty:
        return Undefined(Reason.GROUP_EMPTY_LEAVE_OUT, group=f"group {read.empty[0]!r}")
    single = next((group for group in read.filled if group.n < 2), None)
    if welch and single is not None:
        return Undefined(Reason.SINGLE_NO_VARIANCE, group=f"group {single.name!r}")
    if read.df_within < 1:
        return Undefined(Reason.NO_GROUP_OF_TWO_TO_SCATTER)
    constant = [group.name for group in read.filled if group.constant]
    if len(constant) == len(read.filled):
        return Undefined(Reason.NO_GROUP_SCATTERS)
    return Undefined(Reason.TWO_WITHOUT_SCATTER, a=constant[0], b=constant[1]) if welch and constant[1:] else None
