"""Values gathered into cells (one condition in one run of one day): sizes, means, and the squares within them.

All values of a cell have the same expectation and the same random effects, so that a mixed model needs nothing else of
them: its cost does not grow with the number of values.

Cells in runs and runs in days are dealt with group by group, so that nothing is as large as rows by rows. The rows of a
group stand together, so that a reflection of each group is two sums over it, and pairs of rows are
gathered in a tree. Time and memory grow with the number of rows.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.checks import Sample
from stats.exact.numbers import Number, common_shift, exact_sum, greatest, moments

Floats = NDArray[np.float64]
Codes = NDArray[np.intp]

WIDTH = 16
"""Members of a bundle: their pairs are listed, those of different bundles follow from triangles."""


@dataclass(frozen=True, slots=True)
class Blocks:
    """Rows in order of their groups."""

    group: Codes
    """Number of each row's group, shape (m,), ascending from 0 without gaps."""
    first: Codes
    """Place of each group's first row, shape (g,)."""

    def sums(self, columns: Floats) -> Floats:
        """Return the sums over each group of columns of shape (m, ...)."""
        return np.asarray(np.add.reduceat(columns, self.first, axis=0))

    def reflected(self, root: Floats, columns: Floats) -> Floats:
        """Turn columns of shape (m, c) by the reflection that takes each group's part of `root` onto its first row.

        `root`, shape (m,), is positive. Orthogonal and symmetric: applied twice it changes nothing.
        """
        length = np.sqrt(self.sums(root * root))
        axis = root.copy()
        axis[self.first] += length
        along = self.sums(axis[:, None] * columns) / (length * axis[self.first])[:, None]
        return np.asarray(axis[:, None] * along[self.group] - columns)

    def split(self, columns: Floats, size: Floats) -> tuple[Floats, Floats]:
        """Turn weighted rows into (between, within): a row a group, its root-sized mean, and all orthogonal to it.

        `columns` has shape (m, c) and holds means of `size` values; rows of equal variance result, shapes (g, c) and
        (m - g, c). No mean is subtracted from anything, so that large differences between groups leave the rows within
        them unharmed.
        """
        weight = np.sqrt(size)
        # The first row as origin: what all rows of a group have in common must not reach the rows within it.
        origin = columns[self.first]
        turned = self.reflected(weight, weight[:, None] * (columns - origin[self.group]))
        between = turned[self.first] + np.sqrt(self.sums(size))[:, None] * origin
        return between, np.delete(turned, self.first, axis=0)


def blocks_of(group: Codes) -> Blocks:
    """Return blocks of the groups' numbers, shape (m,), ascending from 0 without gaps."""
    return Blocks(group, np.flatnonzero(np.diff(group, prepend=-1)))


def parts_of(condition: Codes, group: Codes) -> Codes:
    """Return for each condition, shape (k,), the number of the connected part it belongs to through shared groups."""
    label = np.arange(int(condition.max()) + 1)
    while True:
        lowest = np.full(int(group.max()) + 1, label.size)
        np.minimum.at(lowest, group, label[condition])
        before, label = label, label.copy()
        np.minimum.at(label, condition, lowest[group])
        if (label == before).all():
            return np.asarray(np.unique(label, return_inverse=True)[1])


def pair_squares(factors: Sequence[Floats], group: Codes) -> tuple[Floats, list[Floats]]:
    """Return what all pairs of different members of one group add up to, and the members of each group as one.

    `factors` are arrays of shapes (m, rows, columns), one matrix a member. The first result, shape (f, f), holds above
    the diagonal and on it the sums of |AB'|^2 over both orders of every pair, A of the one factor and B of the other.
    The second holds for each factor matrices G with G'G the sum of A'A over the group, shapes (g, ..., columns).
    Neighbours are bundled and their triangle stands for them, up a tree: squares are only added, whatever the sizes.
    """
    sums, joined = np.zeros((len(factors), len(factors))), list(factors)
    while group.size > int(group[-1]) + 1:
        place = np.arange(group.size) - blocks_of(group).first[group]
        leads = place % WIDTH == 0
        bundle, slot = np.cumsum(leads) - 1, place % WIDTH
        bundles = [np.zeros((int(bundle[-1]) + 1, int(slot.max()) + 1, *each.shape[1:])) for each in joined]
        for members, each in zip(bundles, joined, strict=True):
            members[bundle, slot] = each
        for i, j in combinations_with_replacement(range(len(factors)), 2):
            sums[i, j] += _squares(bundles[i], bundles[j])
        joined = [_as_one(members) for members in bundles]
        group = group[leads]
    return sums, joined


def _squares(a: Floats, b: Floats) -> float:
    """Return the sum of |AB'|^2 over different members of one bundle, for shapes (bundles, members, rows, columns)."""
    n, width = a.shape[:2]
    product = a.reshape(n, -1, a.shape[-1]) @ b.reshape(n, -1, b.shape[-1]).transpose(0, 2, 1)
    own = np.arange(width)
    product.reshape(n, width, a.shape[2], width, b.shape[2])[:, own, :, own, :] = 0.0
    return float(np.vdot(product, product))


def _as_one(members: Floats) -> Floats:
    rows = members.reshape(members.shape[0], -1, members.shape[-1])
    return np.asarray(np.linalg.qr(rows, mode="r")) if rows.shape[1] > rows.shape[2] else rows


@dataclass(frozen=True, slots=True)
class Unit:
    """What values are counted from and in, once as many powers of two are taken out that their squares are doubles."""

    shift: Fraction
    """What they are counted from, in units of 2**shift_exponent."""
    shift_exponent: int
    exponent: int
    """They are in units of 2**exponent."""

    def value(self, scaled: Number, what: str) -> float | Undefined:
        """Return a value in the unit of the values given; `what` it is stands in the reason."""
        return _rounded(self._exact(scaled), what)

    def values(self, low: float, high: float) -> tuple[float, float] | Undefined:
        """Return an interval of values."""
        return _interval(self._exact(low), self._exact(high))

    def difference(self, scaled: Number, what: str) -> float | Undefined:
        """Return a difference of values."""
        return _rounded(_times(scaled, self.exponent), what)

    def differences(self, low: float, high: float) -> tuple[float, float] | Undefined:
        """Return an interval of differences."""
        return _interval(_times(low, self.exponent), _times(high, self.exponent))

    def spread(self, scaled: float, what: str, power: int = 1) -> float | Undefined:
        """Return a standard error, or a variance (`power` 2): 0 only where it is 0 and not for being small."""
        found = _rounded(_times(scaled, power * self.exponent), what)
        if found == 0.0 < scaled:
            return Undefined(Reason.BELOW_DOUBLES_IN_UNIT, what=what)
        return found

    def scaled(self, value: Fraction) -> Fraction:
        """Return a value in the unit given as it is counted here."""
        return (value / Fraction(2) ** self.shift_exponent - self.shift) * Fraction(2) ** (
            self.shift_exponent - self.exponent
        )

    def _exact(self, scaled: Number) -> Fraction:
        return _times(self.shift, self.shift_exponent) + _times(scaled, self.exponent)


def _times(value: Number, exponent: int) -> Fraction:
    return Fraction(value) * Fraction(2) ** exponent


def _rounded(value: Fraction, what: str) -> float | Undefined:
    try:
        return float(value)
    except OverflowError:
        return Undefined(Reason.BEYOND_DOUBLES_IN_UNIT, what=what)


def _interval(low: Fraction, high: Fraction) -> tuple[float, float] | Undefined:
    first, last = (_rounded(end, "an end of the interval") for end in (low, high))
    if isinstance(first, Undefined):
        return first
    return last if isinstance(last, Undefined) else (first, last)


@dataclass(frozen=True, slots=True)
class Cells:
    """The cells of a design, shapes (m,), by day and run, in a unit that leaves room for squares."""

    condition: Codes
    """Number of the condition, 0 to k - 1."""
    day: Codes
    """Number of the day, ascending."""
    run: Codes
    """Number of the run, 0 to r - 1, ascending; a run belongs to one day."""
    size: Floats
    """How many values the cell holds."""
    mean: Floats
    """Mean of its values."""
    base: Floats
    """Median of all values of its day."""
    offset: Floats
    """Mean of its values from `base`: comparisons within a day lose nothing to how much days differ."""
    sum_squares: float
    """Sum of squared deviations of all values from the mean of their cell, in the unit squared."""
    unit: Unit
    condition_means: tuple[Fraction, ...]
    """Mean of all values of each condition, without error."""

    @property
    def n(self) -> int:
        """Number of values."""
        return int(self.size.sum())

    @property
    def n_conditions(self) -> int:
        """Number of conditions."""
        return int(self.condition.max()) + 1

    @property
    def counts(self) -> Floats:
        """Number of values of each condition, shape (k,)."""
        return np.asarray(np.bincount(self.condition, weights=self.size))

    def plain(self, *groups: Codes) -> bool:
        """Whether least squares takes the plain means of conditions, however much each group of cells has in common.

        So it is where all groups that hold a condition hold every condition equally often (Zyskind 1967, theorem 2: the
        covariance then maps the space of the conditions into itself).
        """
        return all(self._alike(group) for group in groups)

    def _alike(self, group: Codes) -> bool:
        pairs, place = np.unique(group * self.n_conditions + self.condition, return_inverse=True)
        counts = np.bincount(place, weights=self.size)
        of_pair, conditions = np.divmod(pairs, self.n_conditions)
        ends = np.flatnonzero(np.diff(of_pair)) + 1
        held: dict[int, tuple[bytes, bytes]] = {}
        for some, how_often in zip(np.split(conditions, ends), np.split(counts, ends), strict=True):
            content = some.tobytes(), how_often.tobytes()
            if any(held.setdefault(each, content) != content for each in some.tolist()):
                return False
        return True

    def rows(self, basis: Floats, group: Codes) -> tuple[Floats, Floats]:
        """Return rows between groups and within them: the conditions in a basis, shape (k, c), and the values.

        As `Blocks.split` has it, the values in the last column; `group`, shape (m,), is the day, the run or one for
        all.
        """
        blocks, design = blocks_of(group), basis[self.condition]
        base = self.base[blocks.first]
        if (self.base != base[group]).any():  # groups of several days
            return blocks.split(np.column_stack([design, self.mean]), self.size)
        between, within = blocks.split(np.column_stack([design, self.offset]), self.size)
        between[:, -1] += np.sqrt(blocks.sums(self.size)) * base
        return between, within


def by_values(values: Floats, group: Codes) -> Codes:
    """Return the number of each value's group, shape (n,), when size and values decide the order of the groups.

    What is summed in this order rounds alike whatever the groups are called; groups of like values keep their order.
    """
    group = np.unique(group, return_inverse=True)[1]
    order, size = np.lexsort((values, group)), np.bincount(group)
    first = blocks_of(group[order]).first
    keys = [-values[order[first + place]] for place in (size - 1, (size - 1) // 2, 0 * size)]
    number = np.empty(size.size, dtype=np.intp)
    number[np.lexsort((*keys, size))] = np.arange(size.size)
    return np.asarray(number[group])


def cells_of(sample: Sample, condition: Codes, day: Codes, run: Codes) -> Cells:
    """Return the cells of values of shape (n,) with the numbers of their conditions, days and runs.

    The conditions of a run stand in the order of `by_values`, not of their numbers.
    """
    outer = math.frexp(greatest(sample.values))[1]
    scaled = np.ldexp(sample.values, -outer)
    shift = common_shift(scaled)
    scaled = scaled - shift
    if sample.rest is not None:
        scaled = scaled + np.ldexp(sample.rest, -outer)
    # What doubles leave of numbers far beyond 2^53 may have a large part in common too.
    further = common_shift(scaled)
    scaled = scaled - further
    inner = math.frexp(greatest(scaled))[1]
    scaled = np.ldexp(scaled, -inner)
    unit = Unit(Fraction(shift) + Fraction(further), outer, outer + inner)
    condition_means = tuple(map(unit.scaled, _condition_means(sample, condition)))
    order = np.lexsort((scaled, by_values(scaled, condition), run, day))
    scaled, condition, day, run = scaled[order], condition[order], day[order], run[order]
    new = [np.diff(each, prepend=-1) != 0 for each in (condition, run, day)]
    cells = blocks_of(np.cumsum(new[0] | new[1] | new[2]) - 1)
    base = _medians(scaled, day)
    offset, squares = _means(scaled - base[day], cells)
    day = day[cells.first]
    return Cells(
        condition=condition[cells.first],
        day=day,
        run=run[cells.first],
        size=cells.sums(np.ones(scaled.size)),
        mean=base[day] + offset,
        base=base[day],
        offset=offset,
        sum_squares=squares,
        unit=unit,
        condition_means=condition_means,
    )


def _condition_means(sample: Sample, condition: Codes) -> list[Fraction]:
    """Return the exact mean of each condition's values, 0 of none, in the unit given."""
    ends = np.cumsum(np.bincount(condition))[:-1]
    order = np.argsort(condition, kind="stable")
    values = np.split(sample.values[order], ends)
    remainders = [None] * len(values) if sample.rest is None else np.split(sample.rest[order], ends)
    return [exact_sum(one, rest) / max(one.size, 1) for one, rest in zip(values, remainders, strict=True)]


def _medians(values: Floats, group: Codes) -> Floats:
    """Return the lower median of each group's values."""
    first, size = blocks_of(group).first, np.bincount(group)
    return np.asarray(values[np.lexsort((values, group))][first + (size - 1) // 2])


def _means(values: Floats, cells: Blocks) -> tuple[Floats, float]:
    """Return the mean of each cell and the sum of all squared deviations from them, each rounded once."""
    parts = [moments(part) for part in np.split(values, cells.first[1:])]
    squares = sum((part.exact_sum_squares for part in parts), Fraction(0))
    return np.array([part.mean for part in parts]), float(squares)
