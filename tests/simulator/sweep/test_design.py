"""Grids and samples."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import UsageError
from simulator.gains import stiffness_n_m
from simulator.scene_file import load_scene
from simulator.sweep.design import Design, grid, sobol
from tests.helpers.scenes import is_sentence
from tests.helpers.wording import refuses

SIM2 = load_scene("sim2").effects


def three_axes() -> Design:
    return grid(["b_ad=0:300:4", "foot_radius=0.02,0.03,0.038", "gain=100,200"], SIM2)


def sample(rows: int = 64, seed: int = 7) -> Design:
    return sobol(["b_ad=0:300", "kg_scale=0.1:10:log"], SIM2, rows, seed)


def test_a_grid_holds_every_combination_the_last_axis_fastest() -> None:
    design = three_axes()
    assert design.dims == {"b_ad": 4, "foot_radius": 3, "gain": 2}
    assert design.rows(0, 24).tolist() == list(map(list, itertools.product(*(axis.values for axis in design.axes))))
    words = (["b_ad=0,1"], ["b_ad=0,2"], ["b_ad=0,1,2"], ["mu=0.1,1"], ["b_ad=0,1", "mu=1,2"])
    assert len({grid(word, SIM2).content_hash() for word in words}) == len(words)


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


def test_refused() -> None:
    with refuses(UsageError, "k_extension", "--over"):
        grid(["gain=100,200", "k_extension=300,400"], SIM2)
    with refuses(UsageError, "something to sweep"):
        grid([], SIM2)
    with refuses(UsageError, "b_ad", "--over"):
        sobol(["b_ad=0:1", "b_ad=2:3"], SIM2, 8, 0)
    for rows in (0, -1, 10**12):
        with refuses(UsageError, "100000000"):
            sobol(["b_ad=0:1"], SIM2, rows, 0)
    with refuses(UsageError, "negative"):
        sample(seed=-1)
    for word in ("b_ad=0:300:4", "b_ad=0,300", "b_ad=0:300:4:log", "b_ad=5", "b_ad=5:5"):
        with refuses(UsageError, "b_ad") as refusal:
            sobol([word], SIM2, 8, 0)
        assert is_sentence(str(refusal.value))


def test_a_range_with_a_count_a_list_and_a_logarithmic_range() -> None:
    even, listed, log = grid(["b_ad=0:300:4", "foot_radius = 0.038, 0.02", "kg_scale=0.1:1000:5:log"], SIM2).axes
    assert even.coordinates.tolist() == [0.0, 100.0, 200.0, 300.0]
    assert listed.values.tolist() == [0.038, 0.02]
    assert log.values == pytest.approx([0.1, 1.0, 10.0, 100.0, 1000.0], rel=1e-14)
    assert (log.values[0], log.values[-1]) == (0.1, 1000.0)
    assert [(axis.name, axis.parameter, axis.unit) for axis in (even, listed, log)] == [
        ("b_ad", "b_ad", "kg/m"),
        ("foot_radius", "foot_radius", "m"),
        ("kg_scale", "kg_scale", "1"),
    ]


def test_gains_stand_for_their_parameters() -> None:
    gain, damping = grid(["gain=300,600", "damping_gain=0,150"], SIM2).axes
    assert (gain.parameter, damping.parameter) == ("k_extension", "b_ad")
    assert gain.coordinates.tolist() == [300.0, 600.0]
    assert gain.values.tolist() == [stiffness_n_m(300.0), stiffness_n_m(600.0)]
    assert damping.values == pytest.approx([0.0, 3.32 * 150 + 19.67], rel=1e-15)
    (on_emulator,) = grid(["damping_gain=150"], load_scene("emulator").effects).axes
    assert on_emulator.values.tolist() == [3.32 * 150]


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("b_ad", "does not name a parameter and its values"),
        ("bad=0,1", "did you mean 'b_ad'?"),
        ("flight=soft,held", "cannot be swept: give it with --set, in a sweep of its own for each of soft, held and"),
        ("drop_height=0.4,0.5", "cannot be swept: give it with --set, or sweep initial_height"),
        ("jumps=1,2", "cannot be swept: give it with --set, and the result holds all jumps"),
        ("b_ad=0:300", "how many values there are"),
        ("b_ad=0:300:1", "2 or more"),
        ("b_ad=0:300:2.5", "how many values there are"),
        ("b_ad=0:1:1000000000000", "asks for 1000000000000 values: sweep at most 100000000 scenes."),
        (f"b_ad=0:1:{'9' * 5000}", "sweep at most 100000000 scenes."),
        ("b_ad=0:300:3:4", "how many values there are"),
        ("b_ad=300:0:4", "give the smaller end first"),
        ("b_ad=0:300:4:log", "0, which has no logarithm"),
        ("b_ad=log:1:2", "'log' where a finite number belongs"),
        ("b_ad=0,x", "'x' where a finite number belongs"),
        ("b_ad=0:inf:3", "'inf' where a finite number belongs"),
        ("b_ad=0,1,0.0", "0 more than once"),
    ],
)
def test_words_of_a_grid_without_a_meaning(word: str, said: str) -> None:
    with refuses(UsageError, said) as refusal:
        grid([word], SIM2)
    assert is_sentence(str(refusal.value))
