"""Values gathered into cells (one condition in one run of one day): sizes, means, and the squares within them.

All values of a cell have the same expectation and the same random effects, so that a mixed model needs nothing else of
them: its cost does not grow with the number of values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from stats.checks import Sample
from stats.days.blocked_unit import Unit
from stats.days.blocks import Blocks, Codes, Floats, blocks_of
from stats.exact.error_free import exact_sum, greatest, two_product, two_sum
from stats.exact.sums import common_shift, sum_of_products


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
            told = some.tobytes(), how_often.tobytes()
            if any(held.setdefault(each, told) != told for each in some.tolist()):
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


def cells_of(sample: Sample, condition: Codes, day: Codes, run: Codes) -> Cells:
    """Return the cells of values of shape (n,) with the numbers of their conditions, days and runs."""
    outer = math.frexp(greatest(sample.values))[1]
    scaled = np.ldexp(sample.values, -outer)
    shift = common_shift(scaled)
    scaled, low = two_sum(scaled, -shift)
    if sample.rest is not None:
        scaled, low = two_sum(scaled, low + np.ldexp(sample.rest, -outer))
    # What doubles leave of numbers far beyond 2^53 may have a large part in common too.
    further = common_shift(scaled)
    scaled = (scaled - further) + low
    inner = math.frexp(greatest(scaled))[1]
    scaled = np.ldexp(scaled, -inner)
    unit = Unit(Fraction(shift) + Fraction(further), outer, outer + inner)
    condition_means = tuple(map(unit.scaled, _condition_means(sample, condition)))
    order = np.lexsort((scaled, condition, run, day))
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
    parts = [np.split(part[order], ends) for part in (sample.values, sample.rest) if part is not None]
    return [sum(map(exact_sum, of_one), Fraction(0)) / max(of_one[0].size, 1) for of_one in zip(*parts, strict=True)]


def _medians(values: Floats, group: Codes) -> Floats:
    """Return the lower median of each group's values."""
    first, size = blocks_of(group).first, np.bincount(group)
    return np.asarray(values[np.lexsort((values, group))][first + (size - 1) // 2])


def _means(values: Floats, cells: Blocks) -> tuple[Floats, float]:
    """Return the mean of each cell and the sum of all squared deviations from them, rounded once.

    Values are at most 4 in size. They are counted from the first of their cell, so that a constant cell has no
    deviations; sums are those of whole numbers of a common grid (`exact.error_free.exact_sum`), means pairs of doubles.
    """
    origin = values[cells.first]
    high, low = two_sum(values, -origin[cells.group])
    size = cells.sums(np.ones(values.size))
    room = int(size.max()).bit_length() + 1
    grid, left, sums = math.ldexp(16.0, room), high, []
    for _ in range(2):
        part = (grid + left) - grid
        sums.append(cells.sums(part))
        left = left - part
        grid = math.ldexp(grid, room - 53)
    total, error = two_sum(*sums)
    mean = total / size
    product, rest = two_product(mean, size)
    small = (((total - product) - rest) + error + cells.sums(left + low)) / size
    away, further = two_sum(high, -mean[cells.group])
    away, further = two_sum(away, further + (low - small[cells.group]))
    exponent = math.frexp(greatest(away))[1]
    pair = (np.ldexp(away, -exponent), np.ldexp(further, -exponent))
    middle, rest = two_sum(origin, mean)
    return middle + (rest + small), math.ldexp(float(sum_of_products(pair, pair)), 2 * exponent)
