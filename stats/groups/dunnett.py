"""Dunnett's comparisons of several treatments with one control: adjusted p-values and simultaneous intervals.

One pooled standard deviation serves all comparisons, so all groups are taken to scatter alike. Sizes may differ.

The upper tail is that of the largest of several t-statistics that share a control and a standard deviation. With the
control's mean known (y, a standard normal) and the standard deviation known (s) the comparisons are independent. With
lambda_i = sqrt(n_i / (n_i + n_control)) and r_i^2 = 1 - lambda_i^2 the largest |T| exceeds c with the chance 1 -
product over i of (1 - t_i), t_i = Phi(-(c s - lambda_i y) / r_i) + Phi(-(c s + lambda_i y) / r_i); for the largest T
the first term alone. Where a treatment is much larger than the control t_i is nearly a step, r_i wide: panels of
Gauss's rule over y are short where a t_i rises. The same digits at every call, and tails as small as they are.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache, partial
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy import special

from data_schema.errors import InputRefused, unknown_name
from data_schema.reasons import Reason
from data_schema.rounding import alpha_of_level, end_text, level_text, number_text, p_text, statistic_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_groups, as_level
from stats.compare.summary import Groups, read_groups
from stats.exact.numbers import Floats, exact_root, finite, to_120_bits
from stats.exact.quadrature import (
    Rows,
    critical_values,
    gauss_nodes,
    log_means_over_scale,
    log_sum,
    log_upper_of_any,
    steepness_of_largest,
)
from stats.results import Result, missing_text, with_unit

_REACH = 9.5
"""Standard deviations beyond which a normal adds nothing to 16 digits."""
_LONGEST = 3.2
"""Length of a panel in the standard deviations of what varies along it."""
_FALLING, _FALL = np.linspace(0.0, 42.0, 12), 5.0
"""Where exp(-x) has fallen, and how far it may within a panel of that length."""
_MOST_PANELS = 60
_LOG_ROOT_2PI = 0.5 * math.log(2.0 * math.pi)


def log_largest_chance(w: Floats, n_control: int, n_treated: tuple[int, ...], *, two_sided: bool) -> Floats:
    """Return the logarithm of the chance that the largest T, or |T|, of treatments exceeds each w, any shape.

    The standard deviation is taken to be known; it is integrated over the control's mean.
    """
    sizes = Counter(n_treated)
    y, weights = gauss_nodes(_edges(w, n_control, sizes, two_sided=two_sided))
    none, rare = np.zeros_like(y), np.full_like(y, -math.inf)
    for n, count in sizes.items():
        slope, root = _slope_and_root(n, n_control)
        log_tail = special.log_ndtr((slope * y - w[..., None]) / root)
        if two_sided:
            log_tail = np.minimum(np.logaddexp(log_tail, special.log_ndtr((-slope * y - w[..., None]) / root)), 0.0)
        with np.errstate(divide="ignore"):
            none += count * np.log1p(-np.exp(log_tail))
        rare = np.logaddexp(rare, log_tail + math.log(count))
    with np.errstate(divide="ignore"):
        # Where all are too small for a double, the chance of any is their sum.
        any_of_them = np.where(rare < -600.0, rare, np.log(-np.expm1(none)))
        found = log_sum(any_of_them - 0.5 * y * y + np.log(weights))
    # The integrand of both sides is even in y: half of it is integrated.
    return np.asarray(np.minimum(found + (math.log(2.0) if two_sided else 0.0) - _LOG_ROOT_2PI, 0.0))


def _edges(w: Floats, n_control: int, sizes: Mapping[int, int], *, two_sided: bool) -> Floats:
    """Return where the panels of y begin and end, shape (..., edges).

    With the normal, what t_i adds lies around lambda w, over r_i; it rises around w / lambda over r_i / lambda. The
    more treatments, the steeper the rise of the largest one's distribution: over the inverse of where it rises.
    """
    slopes, roots = np.array([_slope_and_root(n, n_control) for n in sizes]).T
    most = w[..., None] * slopes
    first = np.maximum(np.min(most, axis=-1) - _REACH, 0.0 if two_sided else -_REACH)[..., None]
    last = np.maximum(np.max(most, axis=-1), 0.0)[..., None] + _REACH
    steepness = steepness_of_largest(sum(sizes.values()))
    fastest = max(steepness * max(float(np.max(slopes / roots)), 1.0), float(np.max(w)) / _FALL)
    even = math.ceil(float(np.max(last - first)) * fastest / _LONGEST)
    if even <= _MOST_PANELS:
        return np.linspace(first[..., 0], last[..., 0], even + 1, axis=-1)
    steps = np.linspace(-_REACH, _REACH, 1 + math.ceil(2.0 * _REACH * steepness / _LONGEST))
    sharp = roots < slopes  # the others rise no faster than the normal
    rise, width = w[..., None] / slopes[sharp], (roots / slopes)[sharp]
    # Where all t_i are 1, what is left is the normal, which falls as exp(-w y).
    falling = _FALLING / np.maximum(w, 1.0)[..., None]
    places = [
        steps * np.ones_like(last),
        most[..., None] + roots[:, None] * steps,
        rise[..., None] + width[:, None] * steps,
        (rise + _REACH * width)[..., None] + falling[..., None, :],
    ]
    edges = np.concatenate([first, last, *(each.reshape(*w.shape, -1) for each in places)], axis=-1)
    return np.sort(np.clip(edges, first, last), axis=-1)


def largest_log_upper(c: float, n_control: int, n_treated: tuple[int, ...], df: float, *, two_sided: bool) -> float:
    """Return log P(max |T_i| > c), or log P(max T_i > c), for groups of these sizes against one control."""
    return float(_log_uppers(np.array([c]), n_control, n_treated, df, two_sided=two_sided)[0])


def _log_uppers(c: Floats, n_control: int, n_treated: tuple[int, ...], df: float, *, two_sided: bool) -> Floats:
    if math.isinf(df):
        return log_largest_chance(c, n_control, n_treated, two_sided=two_sided)

    def log_chance(u: Floats, rows: Rows) -> Floats:
        return log_largest_chance(c[rows, None] * np.exp(u), n_control, n_treated, two_sided=two_sided)

    lowest, steepness = -np.log(np.maximum(np.abs(c), 1.0)) - 3.0, steepness_of_largest(len(n_treated))
    found = log_means_over_scale(log_chance, np.full(c.shape, df), lowest, steepness=steepness)
    return np.where(c <= 0.0, 0.0, found) if two_sided else found


@lru_cache(maxsize=1024)
def largest_critical(tail: float, n_control: int, n_treated: tuple[int, ...], df: float, *, two_sided: bool) -> float:
    """Return the c that the largest statistic exceeds with chance `tail`."""
    uppers = partial(_log_uppers, n_control=n_control, n_treated=n_treated, df=df, two_sided=two_sided)
    return float(
        critical_values(lambda c, _rows: uppers(c), tail, np.array([df]), len(n_treated), two_sided=two_sided)[0]
    )


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
        low = "" if item.ci_low == _UNBOUNDED else f"from {end_text(item.ci_low, error)}{with_unit(unit)} "
        high = "" if item.ci_high == _UNBOUNDED else f"to {end_text(item.ci_high, error)}{with_unit(unit)}"
        p = p_text(item.p, alpha_of_level(self.level))
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
        half, t = Fraction(self.critical) * se, to_120_bits(difference / se)
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
