"""Rows in groups (cells in runs, runs in days), dealt with group by group: nothing here is as large as rows by rows.

The rows of a group stand together, so that a reflection of each group is two sums over it, and pairs of rows are
gathered in a tree. Time and memory grow with the number of rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Codes = NDArray[np.intp]

WIDTH = 16
"""Members of a bundle: their pairs are written down, those of different bundles are told by triangles."""


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
