"""What is done group by group, against the same written down in full."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stats.checks import as_sample
from stats.days.cells import blocks_of, cells_of, pair_squares, parts_of

GROUPS = st.lists(st.integers(1, 9), min_size=1, max_size=6).map(
    lambda sizes: np.repeat(np.arange(len(sizes)), sizes)  # of one row and of many
)


@given(GROUPS, st.integers(0, 2**32))
def test_pairs_are_those_of_all_products(group, seed):
    """Members of very different size: nothing may be lost beside the largest."""
    rng = np.random.default_rng(seed)
    a, b = (10.0 ** rng.integers(-6, 7, (group.size, 1)) * rng.normal(size=(group.size, 3)) for _ in range(2))
    sums, joined = pair_squares([a[:, None, :], b[:, None, :]], group)
    pairs = (group[:, None] == group) & ~np.eye(group.size, dtype=bool)
    for i, j, product in ((0, 0, a @ a.T), (0, 1, a @ b.T), (1, 1, b @ b.T)):
        assert sums[i, j] == pytest.approx(float((product[pairs] ** 2).sum()), rel=1e-12)
    for factor, whole in zip(joined, (a, b), strict=True):
        for number, matrix in enumerate(factor):
            own = whole[group == number]
            np.testing.assert_allclose(matrix.T @ matrix, own.T @ own, rtol=1e-12, atol=1e-13 * (own * own).sum())


def test_a_small_square_survives_beside_large_ones():
    """Members at right angles but for 1e-9: a sum of squares less the large ones would be 0 or rounding."""
    factor = np.array([[[1e3, 0.0]], [[1e-6, 1e3]]])
    assert pair_squares([factor], np.zeros(2, dtype=np.intp))[0][0, 0] == pytest.approx(2e-6, rel=1e-12)


@given(GROUPS, st.integers(0, 2**32))
def test_a_reflection_turns_each_group_onto_its_first_row(group, seed):
    rng = np.random.default_rng(seed)
    root, columns = rng.uniform(0.1, 5.0, group.size), rng.normal(size=(group.size, 2))
    blocks = blocks_of(group)
    turned = blocks.reflected(root, columns)
    np.testing.assert_allclose(blocks.reflected(root, turned), columns, atol=1e-13)
    np.testing.assert_allclose(blocks.sums(turned**2), blocks.sums(columns**2), rtol=1e-12)
    onto = np.zeros((group.size, 1))
    onto[blocks.first, 0] = np.sqrt(blocks.sums(root**2))
    np.testing.assert_allclose(blocks.reflected(root, root[:, None]), onto, atol=1e-13)
    between, within = blocks.split(columns, root)
    means = blocks.sums(root[:, None] * columns) / blocks.sums(root)[:, None]
    np.testing.assert_allclose(between, np.sqrt(blocks.sums(root))[:, None] * means, atol=1e-12)
    about = columns - means[group]
    np.testing.assert_allclose(within.T @ within, about.T @ (root[:, None] * about), atol=1e-11)


@given(st.lists(st.tuples(st.integers(0, 6), st.integers(0, 9)), min_size=1, max_size=25))
def test_parts_are_what_shared_groups_join(pairs):
    conditions = sorted({condition for condition, _ in pairs})
    groups = sorted({group for _, group in pairs})
    condition = np.array([conditions.index(condition) for condition, _ in pairs])
    group = np.array([groups.index(group) for _, group in pairs])
    parts = [{each} for each in range(len(conditions))]
    for number in range(len(groups)):
        touched = [part for part in parts if part & set(condition[group == number].tolist())]
        parts = [part for part in parts if part not in touched] + [set.union(*touched)]
    found = parts_of(condition, group)
    assert sorted(map(sorted, parts)) == [
        np.flatnonzero(found == number).tolist() for number in np.unique(found).tolist()
    ]


@given(
    st.lists(st.tuples(st.integers(0, 2), st.integers(0, 3), st.integers(-(2**20), 2**20)), min_size=1, max_size=40),
    st.sampled_from([0, 2**30, 2**45]),
    st.sampled_from([0, 100, 2**40]),
)
def test_means_and_squares_of_cells_are_exact_but_for_one_rounding(rows, offset, apart):
    """Whatever the values have in common, and however far apart days are."""
    days = sorted({day for _, day, _ in rows})
    condition = np.array([each for each, _, _ in rows])
    day = np.array([days.index(each) for _, each, _ in rows])
    numbers = [value + offset + apart * int(place) for (_, _, value), place in zip(rows, day, strict=True)]
    cells = cells_of(as_sample("values", [float(value) for value in numbers]), condition, day, day)
    unit, squares = Fraction(2) ** cells.unit.exponent, Fraction(0)
    shift = Fraction(cells.unit.shift) * Fraction(2) ** cells.unit.shift_exponent
    for place in range(cells.size.size):
        own = [
            Fraction(value)
            for value, c, d in zip(numbers, condition, day, strict=True)
            if (c, d) == (cells.condition[place], cells.day[place])
        ]
        mean = sum(own) / len(own)
        squares += sum((value - mean) ** 2 for value in own)
        exact = (mean - shift) / unit - Fraction(cells.base[place])
        assert cells.size[place] == len(own)
        assert cells.offset[place] == pytest.approx(float(exact), rel=2.0**-52, abs=2.0**-100)
    assert cells.sum_squares == pytest.approx(float(squares / unit**2), rel=2.0**-52, abs=0.0)
