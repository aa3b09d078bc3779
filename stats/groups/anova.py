"""One-way analysis of variance (thesis 5.2.1: joules a jump over the active-damping gain), and Welch's.

The first takes all groups to scatter alike; Welch's does not, and stands beside it in reports.

Each mean counts with its weight w = n / s^2, W the sum of the weights. With k groups,

    A = sum over pairs of w_i w_j (m_i - m_j)^2 / (W (k - 1)),    L = sum of (1 - w_i / W)^2 / (n_i - 1),
    F = A / (1 + 2 (k - 2) L / (k^2 - 1)),    df_between = k - 1,    df_within = (k^2 - 1) / (3 L).

A single group without scatter has an infinite weight, and all of this has a limit: only pairs with that group are left
in A, each with the other's weight, and its share w_i / W is 1. Two such groups have none: where they differ F is
infinite, where they agree df_within depends on how their variances vanish.

The share of variance is lambda / (lambda + n), lambda the sum of n_i (mu_i - mu)^2 / sigma_i^2 about the mean mu with
those weights and n the number of values: that of the first where all groups scatter alike. Welch's F follows the
noncentral F of this lambda nearly (Levy 1978, "Some empirical power results associated with Welch's robust analysis of
variance technique"), so that both estimates and the interval are those of the first with Welch's F in the place of
F: eta squared and omega squared as effectsize's `F_to_eta2` and `F_to_omega2` have them for n - k degrees of freedom.
(For `oneway.test` effectsize puts Welch's df_within there, which is fewer: its omega squared is 0.19 on average where
the share is 0.14, for 3 groups of 25 that scatter alike, and does not come nearer with n.)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from numpy.typing import ArrayLike

from data_schema.reasons import Reason
from data_schema.rounding import alpha_of_level, interval_text, p_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_level
from stats.compare.effect_size import eta_squared_ci
from stats.compare.summary import Group, Groups, read_groups
from stats.exact.numbers import Interval, exact_root, finite, to_120_bits
from stats.exact.tails import f_upper
from stats.results import Result, missing_text, plural, share_text


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
    """P(F >= f); 0.0 below 1e-308, where `log10_p` goes on."""
    log10_p: float | Undefined
    """Logarithm of p, right at any size."""
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

    @property
    def eta_squared_ci(self) -> tuple[float, float] | Undefined:
        """Interval of the population's share, from the noncentral F; `eta_squared` itself may lie outside."""
        return eta_squared_ci(self.f, self.df_between, self.df_within, self.level)

    @property
    def omega_squared_ci(self) -> tuple[float, float] | Undefined:
        """The same interval: both estimate one share."""
        return self.eta_squared_ci

    def sentence(self, what: str = "the groups") -> str:
        """Return the result in words: F, both degrees of freedom, p, both shares of variance with interval, n."""
        n = sum(self.group_ns)
        if isinstance(self.f, Undefined):
            return f"No one-way ANOVA over {what} ({plural(len(self.groups), 'group')}, n = {n}): {self.f.reason}."
        return (
            f"One-way ANOVA over {what}: {statistic_text('F', self.f, (self.df_between, self.df_within))}, "
            f"{p_text(self.p, alpha_of_level(self.level))}, eta squared {share_text(self.eta_squared)}, "
            f"omega squared {share_text(self.omega_squared)} ({interval_text(self.eta_squared_ci, self.level)}) "
            f"({plural(len(self.groups), 'group')}, n = {n}{missing_text(self.missing)})."
        )


def one_way_anova(
    groups: Mapping[str, ArrayLike] | Sequence[ArrayLike], *, level: float = 0.95, missing: Missing = "refuse"
) -> Anova:
    """Analyse groups of values, each of shape (n_i,), all in one unit.

    A group without a value leaves the question open: there is no F, only what the other groups are. F and p are those
    of exact arithmetic on the given values, rounded once, whatever the values have in common.
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
    between, within = _between(read), read.squares_within
    total = between + within
    result = replace(
        result,
        eta_squared=float(between / total) if total > 0 else Undefined(Reason.ALL_EQUAL),
        ss_between=read.in_squared_unit(between),
        ss_within=read.in_squared_unit(within),
    )
    if result.df_within > 0:
        sd = exact_root(within / result.df_within)
        result = replace(result, residual_sd=read.in_unit(sd, "the residual standard deviation"))
    if reason is not None:
        return result
    exact_f = (between / result.df_between) / (within / result.df_within)
    tail = f_upper(exact_f, result.df_between, result.df_within)
    surplus = result.df_between * (exact_f - 1)
    return replace(
        result,
        f=finite(exact_f, "F"),
        p=tail.p,
        log10_p=tail.log10_p,
        omega_squared=max(0.0, float(surplus / (surplus + sum(result.group_ns)))),
    )


def _between(read: Groups) -> Fraction:
    """Return the sum of squares between the groups, without error."""
    both = [(group.n, group.exact_mean) for group in read.filled]
    grand = sum((n * mean for n, mean in both), Fraction(0)) / sum(read.sizes)
    return sum((n * (mean - grand) ** 2 for n, mean in both), Fraction(0))


def _why_no_test(read: Groups) -> Undefined | None:
    if len(read.filled) < 2:
        return Undefined(Reason.NO_GROUPS)
    if read.empty:
        return Undefined(Reason.GROUP_EMPTY_LEAVE_OUT, group=f"group {read.empty[0]!r}")
    if read.df_within < 1:
        return Undefined(Reason.NO_GROUP_OF_TWO_TO_SCATTER)
    return Undefined(Reason.NO_GROUP_SCATTERS) if read.squares_within == 0 else None


def _described(read: Groups, level: float, none: Undefined) -> Anova:
    """Return what is known before any test, everything else undefined."""
    return Anova(
        groups=read.names,
        group_ns=read.sizes,
        f=none,
        df_between=max(len(read.filled) - 1, 0),
        df_within=read.df_within,
        p=none,
        log10_p=none,
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
    """P(F >= f); 0.0 below 1e-308, where `log10_p` goes on."""
    log10_p: float | Undefined
    """Decimal logarithm of p, right at any size."""
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

    @property
    def eta_squared_ci(self) -> Interval | Undefined:
        """Approximate interval of the population's share, from the noncentral F; `eta_squared` may lie outside."""
        if isinstance(self.df_within, Undefined):
            return self.df_within
        ends = eta_squared_ci(self.f, self.df_between, self.df_within, self.level)
        if isinstance(ends, Undefined):
            return ends
        low, high = (self._of_all_values(end, self.df_between + self.df_within + 1.0) for end in ends)
        return low, high

    @property
    def omega_squared_ci(self) -> Interval | Undefined:
        """The same interval: both estimate one share."""
        return self.eta_squared_ci

    def _of_all_values(self, share: float, counted_values: float) -> float:
        """Return lambda / (lambda + n) from the share with the fewer values that degrees of freedom count as n."""
        return share * counted_values / (share * counted_values + (1.0 - share) * sum(self.group_ns))

    def sentence(self, what: str = "the groups") -> str:
        """Return the result in words: F, both degrees of freedom, p, both shares of variance with interval, n."""
        n = sum(self.group_ns)
        if isinstance(self.f, Undefined):
            return f"No Welch ANOVA over {what} ({plural(len(self.groups), 'group')}, n = {n}): {self.f.reason}."
        limit = f"; limit for {self.constant_group!r}, which has no scatter" if self.constant_group else ""
        return (
            f"Welch ANOVA over {what}: {statistic_text('F', self.f, (self.df_between, self.df_within))}, "
            f"{p_text(self.p, alpha_of_level(self.level))}, eta squared {share_text(self.eta_squared)}, "
            f"omega squared {share_text(self.omega_squared)} ({interval_text(self.eta_squared_ci, self.level)}) "
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
        log10_p=none,
        eta_squared=none,
        omega_squared=none,
        constant_group=next((group.name for group in read.filled if group.n > 1 and group.constant), ""),
        empty_groups=read.empty,
        level=level,
        missing=read.missing,
    )
    if reason is not None:
        return result
    k = len(read.filled)
    weights = _weights(read.filled)
    shares = _shares(read.filled, weights)
    distances = _distances(read.filled, weights)
    doubt = sum(((1 - shares[group.name]) ** 2 / (group.n - 1) for group in read.filled), Fraction(0))
    f = distances / (k - 1) / (1 + 2 * (k - 2) * doubt / (k * k - 1))
    f, df_within = (to_120_bits(number) for number in (f, (k * k - 1) / (3 * doubt)))
    tail = f_upper(f, k - 1, df_within)
    n, above_chance = sum(read.sizes), (k - 1) * (f - 1)
    return replace(
        result,
        f=finite(f, "F"),
        df_within=float(df_within),
        p=tail.p,
        log10_p=tail.log10_p,
        eta_squared=float((k - 1) * f / ((k - 1) * f + n - k)),
        omega_squared=max(0.0, float(above_chance / (above_chance + n))),
    )


def _weights(groups: Sequence[Group]) -> dict[str, Fraction]:
    """Return w_i by name, those of groups that scatter."""
    return {group.name: to_120_bits(1 / group.exact_mean_variance) for group in groups if not group.constant}


def _shares(groups: Sequence[Group], weights: Mapping[str, Fraction]) -> dict[str, Fraction]:
    """Return w_i / W by name; where a group has no scatter that of the limit."""
    if len(weights) < len(groups):
        return {group.name: Fraction(group.constant) for group in groups}
    total = sum(weights.values(), Fraction(0))
    return {name: weight / total for name, weight in weights.items()}


def _distances(groups: Sequence[Group], weights: Mapping[str, Fraction]) -> Fraction:
    """Return the weighted sum of squares about the weighted mean, which in the limit is that of the constant group."""
    means = {group.name: group.exact_mean for group in groups}
    centre = next((means[group.name] for group in groups if group.constant), None)
    if centre is None:
        centre = sum((weight * means[name] for name, weight in weights.items()), Fraction(0)) / sum(weights.values())
    return sum((weight * (means[name] - centre) ** 2 for name, weight in weights.items()), Fraction(0))


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
