"""Values gathered into cells (one condition in one run of one day), and what is left of them within groups of cells.

All values of a cell have the same expectation and the same random effects, so that a mixed model needs only the cells'
sizes, their means and the sum of squares within them: its cost does not grow with the number of values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from stats.checks import Sample
from stats.sums import common_shift, moments

Floats = NDArray[np.float64]
Codes = NDArray[np.intp]


@dataclass(frozen=True, slots=True)
class Cells:
    """The cells of a design, shapes (m,); values are counted from `shift` in a unit that is a power of two."""

    condition: Codes
    """Number of the condition, 0 to k - 1."""
    day: Codes
    run: Codes
    """Number of the run, 0 to r - 1; a run belongs to one day."""
    size: Floats
    """How many values the cell holds."""
    mean: Floats
    """Mean of its values, from `shift`, in the unit."""
    base: Floats
    """Median of all values of its day, from `shift`."""
    offset: Floats
    """Mean of its values from `base`: comparisons within a day lose nothing to how much days differ."""
    sum_squares: float
    """Sum of squared deviations of all values from the mean of their cell, in the unit squared."""
    shift: float
    """What the means are counted from, in units of 2**shift_exponent."""
    shift_exponent: int
    exponent: int
    """The unit is 2**exponent."""

    @property
    def n(self) -> int:
        """Number of values."""
        return int(self.size.sum())

    @property
    def n_conditions(self) -> int:
        """Number of conditions."""
        return int(self.condition.max()) + 1

    @property
    def dummies(self) -> Floats:
        """One column a condition, shape (m, k)."""
        return np.asarray(np.eye(self.n_conditions)[self.condition])


def cells_of(sample: Sample, condition: Codes, day: Codes, run: Codes) -> Cells:
    """Return the cells of values of shape (n,) with the numbers of their conditions, days and runs."""
    values = sample.values
    outer = math.frexp(float(np.max(np.abs(values))))[1]
    scaled = np.ldexp(values, -outer)
    shift = common_shift(scaled)
    scaled = scaled - shift
    if sample.rest is not None:
        scaled = scaled + np.ldexp(sample.rest, -outer)
    inner = math.frexp(float(np.max(np.abs(scaled))))[1]
    scaled = np.ldexp(scaled, -inner)
    keys, member = np.unique(np.stack([day, run, condition]), axis=1, return_inverse=True)
    order = np.argsort(member.ravel(), kind="stable")
    edges = np.cumsum(np.bincount(member.ravel()))[:-1]
    base = np.array([common_shift(scaled[day == number]) for number in range(int(day.max()) + 1)])
    parts = [moments(part, 0.0) for part in np.split((scaled - base[day])[order], edges)]
    offset = np.array([part.offset for part in parts])
    return Cells(
        condition=keys[2],
        day=keys[0],
        run=keys[1],
        size=np.array([float(part.n) for part in parts]),
        mean=base[keys[0]] + offset,
        base=base[keys[0]],
        offset=offset,
        sum_squares=math.fsum(part.sum_squares for part in parts),
        shift=shift,
        shift_exponent=outer,
        exponent=outer + inner,
    )


def parts_of(condition: Codes, group: Codes) -> Codes:
    """Return for each condition, shape (k,), the number of the connected part it belongs to through shared groups."""
    label = np.arange(int(condition.max()) + 1)
    while True:
        before = label.copy()
        for number in range(int(group.max()) + 1):
            members = condition[group == number]
            label[members] = label[members].min()
        label = label[label]
        if (label == before).all():
            return np.asarray(np.unique(label, return_inverse=True)[1])


def reflector(direction: Floats) -> Floats:
    """Return the orthogonal matrix (a Householder reflection) that turns `direction` onto the first axis."""
    axis = direction.copy()
    length = float(np.linalg.norm(direction))
    axis[0] += math.copysign(length, axis[0])
    turned = np.eye(axis.size) - (2.0 / float(axis @ axis)) * np.outer(axis, axis)
    return -math.copysign(1.0, direction[0]) * turned


def split_by_group(columns: Floats, size: Floats, group: Codes) -> tuple[Floats, Floats]:
    """Turn weighted cells into (between, within): one row a group, its root-sized mean, and all rows orthogonal to it.

    `columns` has shape (m, c) and holds cell means; rows of equal variance result, shapes (g, c) and (m - g, c). No
    mean is subtracted from anything, so that large differences between groups leave the rows within them unharmed.
    """
    between, within = [], []
    for number in range(int(group.max()) + 1):
        chosen = group == number
        weight = np.sqrt(size[chosen])
        # The first cell as origin: what all cells of a group have in common must not reach the rows within it.
        origin = columns[chosen][0]
        turned = reflector(weight) @ (weight[:, None] * (columns[chosen] - origin))
        between.append(turned[0] + math.sqrt(float(size[chosen].sum())) * origin)
        within.append(turned[1:])
    return np.array(between), np.concatenate(within)


def rows_of(cells: Cells, basis: Floats, group: Codes) -> tuple[Floats, Floats]:
    """Return `split_by_group` of the conditions in a basis, shape (k, c), and the values as the last column."""
    design = cells.dummies @ basis
    in_one_day = all(np.unique(cells.base[group == number]).size == 1 for number in range(int(group.max()) + 1))
    if not in_one_day:
        return split_by_group(np.column_stack([design, cells.mean]), cells.size, group)
    between, within = split_by_group(np.column_stack([design, cells.offset]), cells.size, group)
    first = np.unique(group, return_index=True)[1]
    between[:, -1] += np.sqrt(np.bincount(group, weights=cells.size)) * cells.base[first]
    return between, within
