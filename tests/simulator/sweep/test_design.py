"""Grids and samples."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import UsageError
from simulator.scene_file import load_scene
from simulator.sweep.axes import axes_of, ranges_of
from simulator.sweep.design import Design, grid, sobol
from tests.helpers.wording import refuses

SIM2 = load_scene("sim2").effects


def three_axes() -> Design:
    return grid(axes_of(["b_ad=0:300:4", "foot_radius=0.02,0.03,0.038", "gain=100,200"], SIM2))


def sample(rows: int = 64, seed: int = 7) -> Design:
    return sobol(ranges_of(["b_ad=0:300", "kg_scale=0.1:10:log"], SIM2), rows, seed)


def test_a_grid_holds_every_combination_the_last_axis_fastest() -> None:
    design = three_axes()
    assert design.dims == {"b_ad": 4, "foot_radius": 3, "gain": 2}
    assert design.row_count == 24
    expected = list(itertools.product(*(axis.values for axis in design.axes)))
    assert design.rows(0, 24).tolist() == [list(point) for point in expected]


@given(cut=st.tuples(st.integers(0, 24), st.integers(0, 24)))
def test_rows_do_not_depend_on_how_they_are_asked_for(cut: tuple[int, int]) -> None:
    first, second = sorted(cut)
    for design in (three_axes(), sample(24)):
        parts = [design.rows(*part) for part in ((0, first), (first, second), (second, 24))]
        assert np.concatenate(parts).tolist() == design.rows(0, 24).tolist()


def test_a_sample_fills_its_ranges_evenly() -> None:
    design = sample(64)
    assert design.dims == {"sample": 64}
    damping, scale = design.rows(0, 64).T
    # a scrambled Sobol sequence of 2^m points has one in each of 2^m equal parts of every range
    assert sorted(np.floor(damping / 300 * 64)) == list(range(64))
    assert sorted(np.floor((np.log10(scale) + 1) / 2 * 64)) == list(range(64))


def test_a_sample_is_drawn_again_by_its_seed_and_begins_every_longer_one() -> None:
    assert sample().content_hash() == sample().content_hash()
    assert sample(seed=8).content_hash() != sample().content_hash()
    assert sample(100).rows(0, 64).tolist() == sample(64).rows(0, 64).tolist()


def test_other_values_have_another_hash() -> None:
    words = (["b_ad=0,1"], ["b_ad=0,2"], ["b_ad=0,1,2"], ["mu=0.1,1"], ["b_ad=0,1", "mu=1,2"])
    assert len({grid(axes_of(word, SIM2)).content_hash() for word in words}) == len(words)


@pytest.mark.parametrize("design", [three_axes(), sample(24)])
def test_a_part_has_each_combination_of_the_rows_once(design: Design) -> None:
    part = design.part([axis.parameter for axis in design.axes][:2])
    rows = {tuple(row[:2]) for row in design.rows(0, 24).tolist()}
    found = [tuple(row) for row in part.rows(0, part.row_count).tolist()]
    assert set(found) == rows
    assert len(found) == len(rows)


def test_refused() -> None:
    axes = axes_of(["gain=100,200", "k_extension=300,400"], SIM2)
    with refuses(UsageError, "k_extension", "--over"):
        grid(axes)
    with refuses(UsageError, "something to sweep"):
        grid([])
    with refuses(UsageError, "b_ad", "--over"):
        sobol(ranges_of(["b_ad=0:1", "b_ad=2:3"], SIM2), 8, 0)
    for rows in (0, -1, 10**12):
        with refuses(UsageError, "sweep", "100000000"):
            sobol(ranges_of(["b_ad=0:1"], SIM2), rows, 0)
    with pytest.raises(UsageError, match="negative"):
        sample(seed=-1)
