"""Two groups whose runs or values belong to days: what comparisons within days are made of.

The difference of means within days is weighted as least squares with day effects weights it, n_a n_b / (n_a + n_b) for
each day; without days it is the difference of means. Runs may be pooled over levels of another factor (strata) within a
day, and carry errors in common with others.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike, NDArray

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.checks import Labels, Missing, Sample, as_labels, as_sample, complete_rows
from stats.compare.shared_error import SharedError, shared_of_mean, weighted_sum
from stats.exact.numbers import common_shift, exact_sum, finite, greatest, out_of_range, times_power
from stats.results import plural

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ValuesOfDay:
    """The values of both groups on one day, each in ascending order."""

    a: Floats
    b: Floats

    @property
    def weight(self) -> float:
        """Weight of the day's difference."""
        return self.a.size * self.b.size / (self.a.size + self.b.size)


@dataclass(frozen=True, slots=True)
class Cell:
    """The values of one group on one day about their mean."""

    values: Floats
    weight: float
    """Of their mean in the difference; negative for group b."""
    name: str
    """"a" or "b"."""


@dataclass(frozen=True, slots=True)
class TwoByDay:
    """Both groups by day, and what was given."""

    shared_days: tuple[ValuesOfDay, ...]
    """Days that hold both groups, in an order that their labels do not decide; in units of 2**exponent."""
    exponent: int
    """0 but where differences of the values could overflow or lose bits."""
    exact_difference: Fraction
    """a minus b within days, in the unit of the values; 0 where no day holds both groups."""
    n_a: int
    n_b: int
    n_days: int | Undefined
    missing: int
    """Values left out because they or their day were missing."""

    @property
    def unused_a(self) -> int:
        """Number of values of group a on days that hold no value of group b: they enter nothing."""
        return self.n_a - sum(each.a.size for each in self.shared_days)

    @property
    def unused_b(self) -> int:
        """Number of values of group b on days that hold no value of group a: they enter nothing."""
        return self.n_b - sum(each.b.size for each in self.shared_days)

    @property
    def difference(self) -> float | Undefined:
        """a minus b within days in the unit of the values, if doubles reach so far."""
        return finite(self.exact_difference, "the difference")

    def in_unit(self, scaled: float, what: str = "the difference") -> float | Undefined:
        """Return a difference in the unit of the values, if doubles reach so far."""
        return finite(times_power(scaled, self.exponent), what)

    def centred_cells(self) -> tuple[list[Cell], int]:
        """Return the values about the means of their day and group, and the power of two they are multiples of."""
        total = math.fsum(each.weight for each in self.shared_days)
        cells = []
        for each in self.shared_days:
            for name, values, sign in (("a", each.a, 1.0), ("b", each.b, -1.0)):
                shifted = values - values[0]
                exponent = math.frexp(greatest(shifted))[1]
                shifted = np.ldexp(shifted, -exponent)
                about = np.ldexp(shifted - math.fsum(shifted) / shifted.size, exponent)
                cells.append(Cell(about, sign * each.weight / total, name))
        exponent = math.frexp(max(greatest(cell.values) for cell in cells))[1]
        return [Cell(np.ldexp(cell.values, -exponent), cell.weight, cell.name) for cell in cells], exponent

    def why_no_shared_day(self) -> Undefined:
        """Return why there is no day to compare within."""
        if self.n_a == 0 or self.n_b == 0:
            return Undefined(Reason.GROUP_EMPTY, group=f"group {'a' if self.n_a == 0 else 'b'}")
        return Undefined(Reason.NO_SHARED_DAY)


def two_by_day(
    a: ArrayLike, b: ArrayLike, day_a: Labels | None, day_b: Labels | None, missing: Missing = "refuse"
) -> TwoByDay:
    """Return groups of shapes (n_a,) and (n_b,) by the labels of their days, one for each value, or all as one day.

    Raises `InputRefused` for infinite values, for labels of another length or of one group only, and, unless `missing`
    is "drop", for values or days that are missing.
    """
    if (day_a is None) != (day_b is None):
        raise InputRefused("days are given for one group only: give them for both or for none.")
    samples, days, left_out = [], [], 0
    for name, values, labels in (("a", a, day_a), ("b", b, day_b)):
        columns = [values] if labels is None else [values, as_labels(f"day_{name}", labels, missing)]
        (present, *present_days), fewer = complete_rows(columns, missing)
        sample = as_sample(f"group {name}", present)
        words = [str(day) for day in present_days[0]] if present_days else [""] * sample.values.size
        if len(words) != sample.values.size:
            raise InputRefused(
                f"group {name} has {plural(sample.values.size, 'value')} and {plural(len(words), 'label')} of day: "
                "give one label for each value."
            )
        samples.append(sample)
        days.append(words)
        left_out += fewer
    difference = _difference(*(_exact_means(sample, words) for sample, words in zip(samples, days, strict=True)))
    first, second = _as_doubles(*samples)
    of_a, of_b = (_by_day(values, words) for values, words in zip((first, second), days, strict=True))
    shared = [ValuesOfDay(of_a[day], of_b[day]) for day in of_a.keys() & of_b.keys()]
    shared.sort(key=lambda each: (each.a.tolist(), each.b.tolist()))
    n_days: int | Undefined = Undefined(Reason.NO_DAYS_GIVEN) if day_a is None else len(shared)
    exponent = out_of_range(np.concatenate([first, second]))
    in_range = tuple(ValuesOfDay(np.ldexp(each.a, -exponent), np.ldexp(each.b, -exponent)) for each in shared)
    return TwoByDay(in_range, exponent, difference, first.size, second.size, n_days, left_out)


def _exact_means(sample: Sample, words: list[str]) -> dict[str, tuple[int, Fraction]]:
    """Return the number of values of each day and their mean without error: sums that cancel keep all digits."""
    values = _by_day(sample.values, words)
    remainders_by_day = {} if sample.rest is None else _by_day(sample.rest, words)
    return {day: (each.size, exact_sum(each, remainders_by_day.get(day)) / each.size) for day, each in values.items()}


def _difference(a: Mapping[str, tuple[int, Fraction]], b: Mapping[str, tuple[int, Fraction]]) -> Fraction:
    """Return the weighted difference of the means of the days that hold both groups."""
    total, weights = Fraction(0), Fraction(0)
    for day in a.keys() & b.keys():
        (n_a, mean_a), (n_b, mean_b) = a[day], b[day]
        weight = Fraction(n_a * n_b, n_a + n_b)
        total, weights = total + weight * (mean_a - mean_b), weights + weight
    return total / weights if weights else total


def _by_day(values: Floats, words: list[str]) -> dict[str, Floats]:
    """Return the values of each day in ascending order."""
    places = {word: place for place, word in enumerate(dict.fromkeys(words))}
    codes = np.array([places[word] for word in words], dtype=np.intp)
    ends = np.cumsum(np.bincount(codes, minlength=len(places)))
    parts = np.split(values[np.lexsort((values, codes))], ends)
    return dict(zip(places, parts, strict=False))  # the last part is what no day holds: nothing


def _as_doubles(a: Sample, b: Sample) -> tuple[Floats, Floats]:
    """Return both samples as doubles, less a common shift where they have digits beyond those of doubles."""
    if a.rest is None and b.rest is None:
        return a.values, b.values
    origin = Fraction(common_shift(a.values, b.values))
    first, second = (np.array([float(value - origin) for value in _exact(sample)]) for sample in (a, b))
    return first, second


def _exact(sample: Sample) -> list[Fraction]:
    rest = np.zeros(sample.values.size) if sample.rest is None else sample.rest
    return [Fraction(high) + Fraction(low) for high, low in zip(sample.values.tolist(), rest.tolist(), strict=True)]


Block = tuple[str, str]
"""A day and a stratum."""


@dataclass(frozen=True, slots=True)
class Runs:
    """The runs of one condition on one day: their number and mean, the squares about it, their error in common."""

    n: int
    mean: float
    squares: float
    shared: SharedError


@dataclass(frozen=True, slots=True)
class Counts:
    """Runs on shared days, and runs on other days, which enter nothing."""

    control: int
    treated: int
    other_control: int
    other_treated: int


@dataclass(frozen=True, slots=True)
class RunsByDay:
    """The runs of a control and of a treatment, by day and stratum."""

    control: Mapping[Block, Runs]
    treated: Mapping[Block, Runs]

    def without(self, day: str) -> RunsByDay:
        """Return the runs of the other days."""
        control, treated = (
            {block: runs for block, runs in side.items() if block[0] != day} for side in (self.control, self.treated)
        )
        return RunsByDay(control, treated)

    @property
    def shared_days(self) -> tuple[SharedDay, ...]:
        """Days that hold runs of both, stratum by stratum."""
        both = sorted(self.control.keys() & self.treated.keys())
        return tuple(SharedDay(block[0], self.control[block], self.treated[block]) for block in both)

    def why_no_day_is_shared(self, control: str, treated: str) -> Undefined:
        """Return that no day holds both, or that none does within one stratum."""
        days = [{day for day, _stratum in side} for side in (self.control, self.treated)]
        code = Reason.NO_DAY_HOLDS_BOTH_ALIKE if days[0] & days[1] else Reason.NO_DAY_HOLDS_BOTH
        return Undefined(code, a=control, b=treated)

    def counts(self) -> Counts:
        """Count the runs."""
        control, treated = (sum(runs.n for runs in side.values()) for side in (self.control, self.treated))
        shared = self.shared_days
        on_shared = sum(day.control.n for day in shared), sum(day.treated.n for day in shared)
        return Counts(*on_shared, control - on_shared[0], treated - on_shared[1])


@dataclass(frozen=True, slots=True)
class SharedDay:
    """A day with runs of both conditions; within days, of one stratum."""

    day: str
    control: Runs
    treated: Runs

    @property
    def weight(self) -> float:
        """The inverse variance of the contrast, in units of that of a run."""
        return self.control.n * self.treated.n / (self.control.n + self.treated.n)


def one_day(strata: Sequence[SharedDay]) -> SharedDay:
    """Return the strata of a day as one day."""
    if len(strata) == 1:
        return strata[0]
    weights = weights_of(strata)

    def side(runs: Sequence[Runs]) -> Runs:
        mean = math.fsum(weight * one.mean for weight, one in zip(weights, runs, strict=True))
        squares, shared = math.fsum(one.squares for one in runs), weighted_sum([one.shared for one in runs], weights)
        return Runs(sum(one.n for one in runs), mean, squares, shared)

    return SharedDay(strata[0].day, side([each.control for each in strata]), side([each.treated for each in strata]))


def mean_of_runs(blocks: Mapping[Block, Runs], name: str) -> float | Undefined:
    """Return the mean of all runs, whatever their day."""
    n = sum(runs.n for runs in blocks.values())
    if not n:
        return Undefined(Reason.GROUP_EMPTY, group=name)
    return math.fsum(runs.n * runs.mean for runs in blocks.values()) / n


def weights_of(days: Sequence[SharedDay]) -> list[float]:
    """Return n m / (n + m) of days or strata, in shares of 1."""
    total = math.fsum(day.weight for day in days)
    return [day.weight / total for day in days]


def blocks_of_runs(
    name: str,
    values: ArrayLike,
    labels: Labels | None,
    strata: Labels | None,
    errors: Sequence[SharedError] | None,
) -> dict[Block, Runs]:
    """Gather values by the labels of their day and stratum; raises `InputRefused` as `contrast_by_day` says."""
    found = as_sample(name, values).values
    n = int(found.size)
    days, levels = (
        [""] * n if given is None else [str(each) for each in as_labels(f"{what}_{name}", given, "refuse")]
        for what, given in (("days", labels), ("strata", strata))
    )
    own = [SharedError()] * n if errors is None else list(errors)
    for what, given in (("label of day", days), ("label of stratum", levels), ("shared error", own)):
        if len(given) != n:
            raise InputRefused(
                f"{name} has {plural(n, 'value')} and {plural(len(given), what)}: give one for each value."
            )
    blocks: dict[Block, list[int]] = {}
    for at, block in enumerate(zip(days, levels, strict=True)):
        blocks.setdefault(block, []).append(at)
    return {block: _runs(found[places].tolist(), [own[at] for at in places]) for block, places in blocks.items()}


def _runs(values: Sequence[float], errors: Sequence[SharedError]) -> Runs:
    mean = math.fsum(values) / len(values)
    # The mean of equal values, rounded, may be another number; they do not scatter about it.
    squares = 0.0 if min(values) == max(values) else math.fsum((value - mean) ** 2 for value in values)
    return Runs(len(values), mean, squares, shared_of_mean(errors))
