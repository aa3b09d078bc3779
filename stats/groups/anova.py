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
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from numpy.typing import ArrayLike

from data_schema.reasons import Reason
from data_schema.rounding import alpha_of_level, p_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_level
from stats.results import Result, missing_text, plural, share_text
from stats.scatter import Group, Groups, finite, read_groups
from stats.tails import f_upper


@dataclass(frozen=True, slots=True)
class Anova(Result):
    """Whether the means of several groups differ by more than their scatter explains."""

    groups: tuple[str, ...]
    """Names of the groups that hold values, as given; shape (k,)."""
    group_ns: tuple[int, ...]
    """Their sizes, shape (k,)."""
    f: float | Undefined
    """(SS_between / df_between) / (SS_within / df_within), dimensionless."""
    df_between: int
    """Number of groups minus 1."""
    df_within: int
    """Number of values minus number of groups."""
    p: float | Undefined
    """P(F >= f)."""
    eta_squared: float | Undefined
    """Share of the total sum of squares that lies between the groups, 0 to 1; too large on average where n is small."""
    omega_squared: float | Undefined
    """The same share with its bias taken off; 0 where F is below 1, as no share is negative."""
    ss_between: float | Undefined
    """Sum of squares between the groups, in the values' unit squared."""
    ss_within: float | Undefined
    """Sum of squares within the groups, in the values' unit squared."""
    residual_sd: float | Undefined
    """Standard deviation within the groups, in the values' unit."""
    group_means: tuple[float, ...]
    """Means of `groups`, in the values' unit; shape (k,)."""
    empty_groups: tuple[str, ...]
    """Names of groups without a value."""
    level: float
    """Level of the intervals."""
    missing: int
    """How many values were left out as NaN."""

    def sentence(self, what: str = "the groups") -> str:
        """Return the result in words: F, both degrees of freedom, p, both shares of variance with interval, n."""
        n = sum(self.group_ns)
        if isinstance(self.f, Undefined):
            return f"No one-way ANOVA over {what} ({plural(len(self.groups), 'group')}, n = {n}): {self.f.reason}."
        return (
            f"One-way ANOVA over {what}: {statistic_text('F', self.f, (self.df_between, self.df_within))}, "
            f"{p_text(self.p, alpha_of_level(self.level))}, eta squared {share_text(self.eta_squared)}, "
            f"omega squared {share_text(self.omega_squared)} "
            f"({plural(len(self.groups), 'group')}, n = {n}{missing_text(self.missing)})."
        )


def one_way_anova(
    groups: Mapping[str, ArrayLike] | Sequence[ArrayLike], *, level: float = 0.95, missing: Missing = "refuse"
) -> Anova:
    """Analyse groups of values, each of shape (n_i,), all in one unit.

    A group without a value leaves the question open: there is no F, only what the other groups are.
    Raises `InputRefused`, naming the group, for infinite values, and for NaN unless `missing` is "drop".

    >>> found = one_way_anova({"0": [42.1, 39.8, 44.0], "50": [36.9, 38.2, 35.1]})
    >>> round(found.f, 2), found.df_between, found.df_within
    (12.0, 1, 4)
    """
    level = as_level("level", level)
    read = read_groups(groups, missing)
    reason = _why_no_test(read)
    result = _described(read, level, Undefined(Reason.NOT_COMPUTED) if reason is None else reason)
    if len(read.filled) < 2:
        return result
    between, within = read.squares_between, read.squares_within
    result = replace(
        result,
        eta_squared=between / (between + within) if between + within > 0.0 else Undefined(Reason.ALL_EQUAL),
        ss_between=read.in_squared_unit(between),
        ss_within=read.in_squared_unit(within),
    )
    if result.df_within > 0:
        sd = read.scale.length(math.sqrt(within / result.df_within), "the residual standard deviation")
        result = replace(result, residual_sd=sd)
    if reason is not None:
        return result
    f = (between / result.df_between) / (within / result.df_within)
    surplus = result.df_between * (f - 1.0)
    return replace(
        result,
        f=finite(f, "F"),
        p=f_upper(f, result.df_between, result.df_within),
        omega_squared=max(0.0, surplus / (surplus + sum(result.group_ns))),
    )


def _why_no_test(read: Groups) -> Undefined | None:
    if len(read.filled) < 2:
        return Undefined(Reason.NO_GROUPS)
    if read.empty:
        return Undefined(Reason.GROUP_EMPTY_LEAVE_OUT, group=f"group {read.empty[0]!r}")
    if read.df_within < 1:
        return Undefined(Reason.NO_GROUP_OF_TWO_TO_SCATTER)
    return Undefined(Reason.NO_GROUP_SCATTERS) if read.squares_within == 0.0 else None


def _described(read: Groups, level: float, none: Undefined) -> Anova:
    """Return what is known before any test, everything else undefined."""
    return Anova(
        groups=read.names,
        group_ns=read.sizes,
        f=none,
        df_between=max(len(read.filled) - 1, 0),
        df_within=read.df_within,
        p=none,
        eta_squared=none,
        omega_squared=none,
        ss_between=none,
        ss_within=none,
        residual_sd=none,
        group_means=read.means,
        empty_groups=read.empty,
        level=level,
        missing=read.missing,
    )


@dataclass(frozen=True, slots=True)
class WelchAnova(Result):
    """Whether the means of several groups differ, each group with a scatter of its own."""

    groups: tuple[str, ...]
    """Names of the k groups that hold values, as given; shape (k,)."""
    group_ns: tuple[int, ...]
    """Their sizes, shape (k,)."""
    f: float | Undefined
    """Welch's F (Welch 1951)."""
    df_between: int
    """Number of groups minus 1."""
    df_within: float | Undefined
    """Denominator's degrees of freedom after Welch (1951), not whole in general."""
    p: float | Undefined
    """P(F >= f)."""
    eta_squared: float | Undefined
    """Share of variance between the groups, each value in SDs of its own group; too large on average where n is small.
    """
    omega_squared: float | Undefined
    """The same share with its bias taken off, nearly; 0 where F is below 1, as no share is negative."""
    constant_group: str
    """Name of the one group without scatter, for which the limit was taken; empty where all groups scatter."""
    empty_groups: tuple[str, ...]
    """Names of groups without a value."""
    level: float
    """Level of the intervals."""
    missing: int
    """How many values were left out as NaN."""

    def sentence(self, what: str = "the groups") -> str:
        """Return the result in words: F, both degrees of freedom, p, both shares of variance with interval, n."""
        n = sum(self.group_ns)
        if isinstance(self.f, Undefined):
            return f"No Welch ANOVA over {what} ({plural(len(self.groups), 'group')}, n = {n}): {self.f.reason}."
        limit = f"; limit for {self.constant_group!r}, which has no scatter" if self.constant_group else ""
        return (
            f"Welch ANOVA over {what}: {statistic_text('F', self.f, (self.df_between, self.df_within))}, "
            f"{p_text(self.p, alpha_of_level(self.level))}, eta squared {share_text(self.eta_squared)}, "
            f"omega squared {share_text(self.omega_squared)} "
            f"({plural(len(self.groups), 'group')}, n = {n}{missing_text(self.missing)}{limit})."
        )


def welch_anova(
    groups: Mapping[str, ArrayLike] | Sequence[ArrayLike], *, level: float = 0.95, missing: Missing = "refuse"
) -> WelchAnova:
    """Analyse groups of values, each of shape (n_i,), all in one unit, by Welch's F.

    Raises `InputRefused`, naming the group, for infinite values, and for NaN unless `missing` is "drop".
    """
    level = as_level("level", level)
    read = read_groups(groups, missing)
    reason = _why_no_welch(read.filled, read.empty)
    none = Undefined(Reason.NOT_COMPUTED) if reason is None else reason
    result = WelchAnova(
        groups=read.names,
        group_ns=read.sizes,
        f=none,
        df_between=max(len(read.filled) - 1, 0),
        df_within=none,
        p=none,
        eta_squared=none,
        omega_squared=none,
        constant_group=next((group.name for group in read.filled if group.n > 1 and group.constant), ""),
        empty_groups=read.empty,
        level=level,
        missing=read.missing,
    )
    if reason is not None:
        return result
    k, n = len(read.filled), sum(read.sizes)
    constant = next((group for group in read.filled if group.constant), None)
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
    df_within, above_chance = (k * k - 1) / (3.0 * doubt), (k - 1) * (f - 1.0)
    return replace(
        result,
        f=finite(f, "F"),
        df_within=df_within,
        p=f_upper(f, k - 1, df_within),
        eta_squared=(k - 1) * f / ((k - 1) * f + n - k),
        omega_squared=max(0.0, above_chance / (above_chance + n)),
    )


def _why_no_welch(groups: Sequence[Group], empty: Sequence[str]) -> Undefined | None:
    if len(groups) < 2:
        return Undefined(Reason.NO_GROUPS)
    if empty:
        return Undefined(Reason.GROUP_EMPTY_LEAVE_OUT, group=f"group {empty[0]!r}")
    single = next((group for group in groups if group.n < 2), None)
    if single is not None:
        return Undefined(Reason.SINGLE_NO_VARIANCE, group=f"group {single.name!r}")
    constant = [group for group in groups if group.constant]
    if len(constant) == len(groups):
        return Undefined(Reason.NO_GROUP_SCATTERS)
    if len(constant) > 1:
        return Undefined(Reason.TWO_WITHOUT_SCATTER, a=constant[0].name, b=constant[1].name)
    return None
