"""Dunnett's comparisons of several treatments with one control: adjusted p-values and simultaneous intervals.

One pooled standard deviation serves all comparisons, so all groups are taken to scatter alike. Sizes may differ.

The upper tail is that of the largest of several t-statistics that share a control and a standard deviation. With the
control's mean known (y, a standard normal) and the standard deviation known (s) the comparisons are independent. With
lambda_i = sqrt(n_i / (n_i + n_control)) and r_i^2 = 1 - lambda_i^2 the largest |T| exceeds c with the chance 1 -
product over i of (1 - t_i), t_i = Phi(-(c s - lambda_i y) / r_i) + Phi(-(c s + lambda_i y) / r_i); for the largest T
the first term alone. Where a treatment is much larger than the control t_i is nearly a step, r_i wide: y is cut into
stretches, short ones where a t_i rises and long ones elsewhere, and Gauss's rule serves each. The same digits at every
call, and tails as small as they are.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import ClassVar, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import special

from data_schema.errors import InputRefused, unknown_name
from data_schema.reasons import Reason
from data_schema.rounding import alpha_beside, level_text, number_text, p_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_groups, as_level
from stats.compare.summary import Groups, read_groups
from stats.exact.family_tails import Floats, KnownScale, critical_values, log_mean_over_scale, log_sum, log_upper_of_any
from stats.exact.numbers import exact_root, finite, shortened
from stats.results import Result, missing_text, with_unit

_REACH = 9.5
"""Standard deviations beyond which a normal adds nothing to 16 digits."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(20)
_LOG_ROOT_2PI = 0.5 * math.log(2.0 * math.pi)


@dataclass(frozen=True)
class LargestAgainstControl(KnownScale):
    """The largest T, or |T|, of treatments against one control, the standard deviation being known."""

    n_control: int
    n_treated: tuple[tuple[int, int], ...]
    """Sizes of the treatments, each with how many have it; rising."""
    two_sided: bool
    fall: ClassVar[float] = 0.5

    def log_chance(self, w: Floats) -> Floats:
        """Return log g at each w of shape (m,), integrated over the control's mean."""
        y, log_widths = self._nodes(w)
        log_tails = []
        for n, _times in self.n_treated:
            slope, root = _slope_and_root(n, self.n_control)
            log_tail = special.log_ndtr((slope * y - w[:, None]) / root)
            if self.two_sided:
                log_tail = np.logaddexp(log_tail, special.log_ndtr((-slope * y - w[:, None]) / root))
            log_tails.append(np.minimum(log_tail, 0.0))
        times = [count for _n, count in self.n_treated]
        with np.errstate(divide="ignore"):
            none = sum(count * np.log1p(-np.exp(tail)) for count, tail in zip(times, log_tails, strict=True))
            any_of_them = np.log(-np.expm1(none))
        # Where all are too small for a double, the chance of any is their sum.
        rare = log_sum(
            np.stack([tail + math.log(count) for count, tail in zip(times, log_tails, strict=True)], axis=-1)
        )
        any_of_them = np.where(rare < -600.0, rare, any_of_them)
        # The integrand of both sides is even in y: half of it is integrated.
        whole = math.log(2.0) if self.two_sided else 0.0
        return np.minimum(log_sum(any_of_them - 0.5 * y * y + log_widths) + whole - _LOG_ROOT_2PI, 0.0)

    def log_bound(self, w: Floats) -> Floats:
        """Return the logarithm of all treatments' chances together, at most 0."""
        sides = math.log(2.0) if self.two_sided else 0.0
        return np.asarray(np.minimum(special.log_ndtr(-w) + sides + self.slack, 0.0))

    @property
    def slack(self) -> float:
        """The chances of all treatments together are at least the largest's, one treatment's at most."""
        return math.log(sum(count for _n, count in self.n_treated))

    def _nodes(self, w: Floats) -> tuple[Floats, Floats]:
        """Return the places y for each w and the logarithms of their weights, both of shape (m, places)."""
        edges = self._edges(w)
        half = np.diff(edges, axis=-1)[..., None] / 2.0
        y = edges[:, :-1, None] + half * (1.0 + _NODES)
        with np.errstate(divide="ignore"):
            log_widths = np.log(half * _WEIGHTS)
        return y.reshape(w.size, -1), log_widths.reshape(w.size, -1)

    def _edges(self, w: Floats) -> Floats:
        """Return where the stretches of y begin and end, shape (m, stretches + 1), the last perhaps of length 0."""
        slopes, roots = np.array([_slope_and_root(n, self.n_control) for n, _times in self.n_treated]).T
        # t_i rises around w / lambda over r_i / lambda; with the normal, what it adds lies around lambda w, over r_i.
        rise, most = w[:, None] / slopes, w[:, None] * slopes
        longest = _longest(sum(count for _n, count in self.n_treated))
        start = np.minimum(rise, most) - _REACH * roots / slopes
        end = np.maximum(rise, most) + _REACH * roots / slopes
        y = np.maximum(np.min(most, axis=-1) - _REACH, 0.0 if self.two_sided else -_REACH)
        last = np.maximum(np.max(most, axis=-1), 0.0) + _REACH
        edges = [y]
        while np.any(y < last):
            near = np.maximum(y[:, None] + longest * roots, start)
            y = np.minimum(y + longest, np.min(np.where(y[:, None] < end, near, np.inf), axis=-1))
            y = np.minimum(y, last)
            edges.append(y)
        return np.stack(edges, axis=-1)


def largest_log_upper(c: float, n_control: int, n_treated: tuple[int, ...], df: float, *, two_sided: bool) -> float:
    """Return log P(max |T_i| > c), or log P(max T_i > c), for groups of these sizes against one control."""
    if two_sided and c <= 0.0:
        return 0.0
    return log_mean_over_scale(_family(n_control, n_treated, two_sided), df, c)


@lru_cache(maxsize=1024)
def largest_critical(tail: float, n_control: int, n_treated: tuple[int, ...], df: float, *, two_sided: bool) -> float:
    """Return the c that the largest statistic exceeds with chance `tail`."""

    def log_upper(_rows: NDArray[np.intp], c: Floats) -> Floats:
        return np.array([largest_log_upper(float(c[0]), n_control, n_treated, df, two_sided=two_sided)])

    return float(critical_values(log_upper, tail, np.array([2.5]))[0])


def _family(n_control: int, n_treated: tuple[int, ...], two_sided: bool) -> LargestAgainstControl:
    return LargestAgainstControl(n_control, tuple(sorted(Counter(n_treated).items())), two_sided)


def _longest(treatments: int) -> float:
    """Return the length of a stretch of y, in the standard deviations of what varies along it.

    The more treatments, the steeper the rise of the largest one's distribution: over the inverse of where it rises,
    about ndtri(1 - 1/treatments). With 20 nodes a stretch the chance is right to 1e-14 for any number up to ten
    thousand.
    """
    return min(4.0, 4.2 / max(-float(special.ndtri(1.0 / treatments)), 1.0))


def _slope_and_root(n: int, n_control: int) -> tuple[float, float]:
    """Return lambda and r of a treatment of n values."""
    return math.sqrt(n / (n + n_control)), math.sqrt(n_control / (n + n_control))


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
_UNBOUNDED = Undefined(Reason.NO_BOUND_ON_SIDE)


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
        error = 0.0 if isinstance(about, Undefined) else max((abs(end - about) for end in ends), default=0.0) / 2.0
        text = f"{item.treatment} (n = {item.n}) {number_text(about, error=error)}{with_unit(unit)}"
        if isinstance(item.t, Undefined):
            return f"{text}, no test, because {item.t.reason}"
        low = "" if item.ci_low == _UNBOUNDED else f"from {number_text(item.ci_low, error=error)}{with_unit(unit)} "
        high = "" if item.ci_high == _UNBOUNDED else f"to {number_text(item.ci_high, error=error)}{with_unit(unit)}"
        p = p_text(item.p, alpha_beside(self.level))
        return f"{text} (CI {(low + high).strip()}), {statistic_text('t', item.t, (self.df,))}, {p}"


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
        self.critical: float | Undefined = self._critical(1.0 - level) if reason is None else reason

    def compare(self, name: str) -> AgainstControl:
        group = self.by_name.get(name)
        if group is None or self.control is None:
            none = Undefined(Reason.CONTROL_EMPTY)
            if group is None:
                none = Undefined(Reason.GROUP_EMPTY, group=f"group {name!r}")
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

    def _why_no_test(self) -> Undefined | None:
        if self.read.empty:
            return Undefined(Reason.GROUP_EMPTY_OF_FAMILY, group=f"group {self.read.empty[0]!r}")
        if not self.treated_ns:
            return Undefined(Reason.NO_TREATMENT)
        if self.df < 1:
            return Undefined(Reason.NO_GROUP_OF_TWO_TO_SCATTER)
        return Undefined(Reason.NO_GROUP_SCATTERS) if self.squares == 0 else None
