"""One-way analysis of variance (thesis 5.2.1: joules a jump over the active-damping gain).

It takes all groups to scatter alike; `stats.groups.welch_anova` does not, and stands beside it in reports.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from numpy.typing import ArrayLike

from data_schema.rounding import alpha_beside, interval_text, p_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_level
from stats.compare.effect_size import eta_squared_ci
from stats.exact.error_free import exact_root
from stats.exact.finite import finite
from stats.exact.tails import f_upper
from stats.groups.groups import Groups, read_groups
from stats.results import Result
from stats.wording import counted, missing_text, share_text


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
            return f"No one-way ANOVA over {what} ({counted(len(self.groups), 'group')}, n = {n}): {self.f.reason}."
        return (
            f"One-way ANOVA over {what}: {statistic_text('F', self.f, (self.df_between, self.df_within))}, "
            f"{p_text(self.p, alpha_beside(self.level))}, eta squared {share_text(self.eta_squared)}, "
            f"omega squared {share_text(self.omega_squared)} ({interval_text(self.eta_squared_ci, self.level)}) "
            f"({counted(len(self.groups), 'group')}, n = {n}{missing_text(self.missing)})."
        )


def one_way_anova(
    groups: Mapping[str, ArrayLike] | Sequence[ArrayLike], *, level: float = 0.95, missing: Missing = "refuse"
) -> Anova:
    """Analyse groups of values, each of shape (n_i,), all in one unit.

    A group without a value leaves the question open: there is no F, only what the other groups are. F and p are those
    of exact arithmetic on the given values, rounded once, whatever the values have in common.
    Raises `InputRefused`, naming the group, for infinite values, and for NaN unless `missing` is "drop".
    """
    level = as_level("level", level)
    read = read_groups(groups, missing)
    reason = _why_no_test(read)
    result = _described(read, level, Undefined(reason or "it has not been computed"))
    if len(read.filled) < 2:
        return result
    between, within = _between(read), read.squares_within
    total = between + within
    result = replace(
        result,
        eta_squared=float(between / total) if total > 0 else Undefined("all values are equal"),
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


def _why_no_test(read: Groups) -> str | None:
    if len(read.filled) < 2:
        return "at least 2 groups with values are needed"
    if read.empty:
        return f"group {read.empty[0]!r} is empty, and F of the others would answer another question: leave it out"
    if read.df_within < 1:
        return "no group has more than one value, so that nothing measures the scatter"
    return "no group has any scatter" if read.squares_within == 0 else None


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
