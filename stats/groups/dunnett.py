"""Dunnett's comparisons of several treatments with one control: adjusted p-values and simultaneous intervals.

One pooled standard deviation serves all comparisons, so all groups are taken to scatter alike. Sizes may differ.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from numpy.typing import ArrayLike

from data_schema.errors import InputRefused, unknown_name
from data_schema.rounding import alpha_beside, level_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_groups, as_level
from stats.exact.error_free import exact_root, shortened
from stats.exact.finite import finite
from stats.exact.over_scale import log_upper_of_any
from stats.groups.groups import Groups, read_groups
from stats.groups.many_to_one import largest_critical, largest_log_upper
from stats.results import Result
from stats.wording import missing_text, number_text, p_text, with_unit

Alternative = Literal["two_sided", "greater", "less"]
ALTERNATIVES: tuple[Alternative, ...] = ("two_sided", "greater", "less")
"""What the treatment's mean is suspected to be, against the control's."""

_SIGNED: Mapping[Alternative, Callable[[Fraction], Fraction]] = {
    "two_sided": abs,
    "greater": lambda t: t,
    "less": lambda t: -t,
}
"""What of t the largest of the family is taken of."""
_END = "an end of the interval"
_UNBOUNDED = Undefined("a one-sided comparison has no bound on this side")


@dataclass(frozen=True, slots=True)
class AgainstControl(Result):
    """One treatment against the control, mean(treatment) - mean(control) in the values' unit."""

    treatment: str
    """Its name, as given."""
    n: int
    """Number of its values."""
    difference: float | Undefined
    """Treatment minus control, in the values' unit."""
    ci_low: float | Undefined
    """Simultaneous: the intervals of all treatments cover together at the family's level; in the values' unit."""
    ci_high: float | Undefined
    """The other end, in the values' unit."""
    t: float | Undefined
    """difference over its standard error from the pooled scatter."""
    p: float | Undefined
    """Adjusted for all treatments; 0.0 below 1e-308, where `log10_p` goes on."""
    log10_p: float | Undefined
    """Decimal logarithm of p, right at any size."""


@dataclass(frozen=True, slots=True)
class Dunnett(Result):
    """All treatments against one control, in the order given."""

    control: str
    """Name of the control."""
    n_control: int
    """Number of its values."""
    comparisons: tuple[AgainstControl, ...]
    """One a treatment, in the order given; shape (k - 1,)."""
    df: int
    """Degrees of freedom of the pooled scatter."""
    critical: float | Undefined
    """The |t| (or t) that any treatment exceeds with chance 1 - level where none differs from the control."""
    alternative: Alternative
    """What was suspected of the treatments: a name of `ALTERNATIVES`."""
    level: float
    """Simultaneous level of the intervals."""
    missing: int
    """How many values were left out as NaN."""

    def rows(self) -> tuple[AgainstControl, ...]:
        """Return the comparisons, for `to_frame`."""
        return self.comparisons

    def sentence(self, unit: str = "") -> str:
        """Return the comparisons in words: differences with simultaneous intervals, t, adjusted p, n."""
        found = "; ".join(self.comparison_text(item, unit) for item in self.comparisons)
        return f"{self.head_text()}: {found or 'no treatment'}."

    def head_text(self) -> str:
        """Return what the sentence begins with: the control, its number of values, the level."""
        n = f"n = {self.n_control}{missing_text(self.missing)}"
        return f"Dunnett against {self.control} ({n}), {level_text(self.level)} simultaneous"

    def comparison_text(self, item: AgainstControl, unit: str = "") -> str:
        """Return one of the comparisons in words, as it stands in the sentence."""
        about = item.difference
        ends = (end for end in (item.ci_low, item.ci_high) if not isinstance(end, Undefined))
        within = 0.0 if isinstance(about, Undefined) else max((abs(end - about) for end in ends), default=0.0)
        text = f"{item.treatment} (n = {item.n}) {number_text(about, within=within)}{with_unit(unit)}"
        if isinstance(item.t, Undefined):
            return f"{text}, no test, because {item.t.reason}"
        low = "" if item.ci_low is _UNBOUNDED else f"from {number_text(item.ci_low, within=within)}{with_unit(unit)} "
        high = "" if item.ci_high is _UNBOUNDED else f"to {number_text(item.ci_high, within=within)}{with_unit(unit)}"
        p = p_text(item.p, item.log10_p, alpha_beside(self.level))
        return f"{text} (CI {(low + high).strip()}), t({self.df}) = {number_text(item.t)}, {p}"


def dunnett(
    control: ArrayLike,
    treatments: Mapping[str, ArrayLike] | Sequence[ArrayLike],
    *,
    control_name: str = "the control",
    alternative: Alternative = "two_sided",
    level: float = 0.95,
    missing: Missing = "refuse",
) -> Dunnett:
    """Compare treatments with a control, samples of shape (n_i,), all in one unit.

    The same input gives the same digits at every call. Raises `InputRefused`, naming the group, for infinite values,
    and for NaN unless `missing` is "drop"; `UnknownName` for another alternative.
    """
    if alternative not in ALTERNATIVES:
        raise unknown_name("alternative", alternative, ALTERNATIVES)
    level = as_level("level", level)
    treatments = as_groups(treatments)
    if control_name in treatments:
        raise InputRefused(f"A treatment is called {control_name!r} as the control is: give one of them another name.")
    read = read_groups({control_name: control, **treatments}, missing)
    family = _Family(read, control_name, alternative, level)
    return Dunnett(
        control=control_name,
        n_control=family.n_control,
        comparisons=tuple(family.compare(name) for name in treatments),
        df=family.df,
        critical=family.critical,
        alternative=alternative,
        level=level,
        missing=read.missing,
    )


class _Family:
    """What all comparisons share: the pooled scatter, the sizes, the critical value."""

    def __init__(self, read: Groups, control: str, alternative: Alternative, level: float) -> None:
        self.read = read
        self.by_name = {group.name: group for group in read.filled}
        self.control = self.by_name.get(control)
        self.n_control = self.control.n if self.control else 0
        self.treated_ns = tuple(group.n for group in read.filled if group.name != control)
        self.alternative = alternative
        self.df = read.df_within
        self.squares = read.squares_within
        reason = self._why_no_test()
        self.critical: float | Undefined = Undefined(reason) if reason else self._critical(1.0 - level)

    def compare(self, name: str) -> AgainstControl:
        group = self.by_name.get(name)
        if group is None or self.control is None:
            none = Undefined(f"group {name!r} is empty" if group is None else "the control is empty")
            return AgainstControl(name, group.n if group else 0, none, none, none, none, none, none)
        difference = group.exact_mean - self.control.exact_mean
        shown = self.read.in_unit(difference)
        if isinstance(self.critical, Undefined):
            none = self.critical
            return AgainstControl(name, group.n, shown, none, none, none, none, none)
        se = exact_root(self.squares / self.df * (Fraction(1, group.n) + Fraction(1, self.n_control)))
        half, t = Fraction(self.critical) * se, shortened(difference / se)
        low, high = (self.read.in_unit(end, _END) for end in (difference - half, difference + half))
        log_p = log_upper_of_any(self._log_upper, _SIGNED[self.alternative](t), self.df)
        return AgainstControl(
            treatment=name,
            n=group.n,
            difference=shown,
            ci_low=_UNBOUNDED if self.alternative == "less" else low,
            ci_high=_UNBOUNDED if self.alternative == "greater" else high,
            t=finite(t, "t"),
            p=math.exp(log_p),
            log10_p=log_p / math.log(10.0),
        )

    def _log_upper(self, c: float) -> float:
        two_sided = self.alternative == "two_sided"
        return largest_log_upper(c, self.n_control, self.treated_ns, self.df, two_sided=two_sided)

    def _critical(self, tail: float) -> float:
        two_sided = self.alternative == "two_sided"
        return largest_critical(tail, self.n_control, self.treated_ns, self.df, two_sided=two_sided)

    def _why_no_test(self) -> str | None:
        if self.read.empty:
            return f"group {self.read.empty[0]!r} is empty, and the family without it would be another: leave it out"
        if not self.treated_ns:
            return "there is no treatment"
        if self.df < 1:
            return "no group has more than one value, so that nothing measures the scatter"
        return "no group has any scatter" if self.squares == 0 else None
