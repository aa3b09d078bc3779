"""The words after --over."""

from __future__ import annotations

import numpy as np
import pytest

from data_schema.errors import UsageError
from simulator.changes import FLIGHT_EFFECTS, WORDS
from simulator.gains import stiffness_n_m
from simulator.scene_file import load_scene
from simulator.sweep.axes import GAINS, NOT_SWEPT, axes_of, ranges_of
from tests.helpers.scenes import is_sentence

SIM2 = load_scene("sim2").effects


def test_a_range_with_a_count_a_list_and_a_logarithmic_range() -> None:
    even, listed, log = axes_of(["b_ad=0:300:4", "foot_radius = 0.038, 0.02", "kg_scale=0.1:1000:5:log"], SIM2)
    assert even.coordinates.tolist() == [0.0, 100.0, 200.0, 300.0]
    assert listed.values.tolist() == [0.038, 0.02]
    assert log.values == pytest.approx([0.1, 1.0, 10.0, 100.0, 1000.0], rel=1e-14)
    assert (log.values[0], log.values[-1]) == (0.1, 1000.0)
    assert [(axis.name, axis.parameter, axis.quantity.unit) for axis in (even, listed, log)] == [
        ("b_ad", "b_ad", "kg/m"),
        ("foot_radius", "foot_radius", "m"),
        ("kg_scale", "kg_scale", "1"),
    ]


def test_gains_stand_for_their_parameters() -> None:
    gain, damping = axes_of(["gain=300,600", "damping_gain=0,150"], SIM2)
    assert (gain.parameter, damping.parameter) == ("k_extension", "b_ad")
    assert gain.coordinates.tolist() == [300.0, 600.0]
    assert gain.values.tolist() == [stiffness_n_m(300.0), stiffness_n_m(600.0)]
    assert damping.values == pytest.approx([0.0, 3.32 * 150 + 19.67], rel=1e-15)
    (on_emulator,) = axes_of(["damping_gain=150"], load_scene("emulator").effects)
    assert on_emulator.values.tolist() == [3.32 * 150]


def test_ranges_to_sample() -> None:
    even, log = ranges_of(["b_ad=0:300", "kg_scale=0.1:10:log"], SIM2)
    assert (even.low, even.high, even.logarithmic) == (0.0, 300.0, False)
    assert (log.low, log.high, log.logarithmic) == (0.1, 10.0, True)


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("b_ad", "does not name a parameter and its values"),
        ("=1,2", "does not name a parameter and its values"),
        ("b_ad=", "does not name a parameter and its values"),
        ("bad=0,1", "did you mean 'b_ad'?"),
        ("flight=soft,held", "cannot be swept: give it with --set"),
        ("flight=soft,held", "switches effects"),
        ("flight=soft,held", "a sweep of its own for each of soft, held and massless"),
        ("drop_height=0.4,0.5", "cannot be swept: give it with --set"),
        ("drop_height=0.4,0.5", "or sweep initial_height"),
        ("jumps=1,2", "cannot be swept: give it with --set"),
        ("jumps=1,2", "the result holds all jumps"),
        ("b_ad=0:300", "how many values there are"),
        ("b_ad=0:300:1", "2 or more"),
        ("b_ad=0:300:2.5", "how many values there are"),
        ("b_ad=0:300:01", "how many values there are"),
        ("b_ad=0:1:1000000000000", "asks for 1000000000000 values: sweep at most 100000000 scenes."),
        (f"b_ad=0:1:{'9' * 5000}", "sweep at most 100000000 scenes."),
        ("b_ad=0:300:3:4", "how many values there are"),
        ("b_ad=300:0:4", "give the smaller end first"),
        ("b_ad=0:300:4:log", "0, which has no logarithm"),
        ("b_ad=log:1:2", "'log' where a finite number belongs"),
        ("b_ad=0,x", "'x' where a finite number belongs"),
        ("b_ad=0,nan", "'nan' where a finite number belongs"),
        ("b_ad=0:inf:3", "'inf' where a finite number belongs"),
        ("b_ad=0,1,0.0", "0 more than once"),
    ],
)
def test_words_of_a_grid_without_a_meaning(word: str, said: str) -> None:
    with pytest.raises(UsageError) as refusal:
        axes_of([word], SIM2)
    assert said in str(refusal.value)
    assert is_sentence(str(refusal.value))


@pytest.mark.parametrize("word", ["b_ad=0:300:4", "b_ad=0,300", "b_ad=0:300:4:log", "b_ad=5", "b_ad=5:5"])
def test_words_of_a_sample_without_a_meaning(word: str) -> None:
    with pytest.raises(UsageError) as refusal:
        ranges_of([word], SIM2)
    assert is_sentence(str(refusal.value))


def test_every_word_of_set_is_swept_or_refused_with_a_reason() -> None:
    assert set(WORDS) == set(GAINS) ^ set(NOT_SWEPT)


def test_the_ways_a_leg_can_fly_are_all_named() -> None:
    assert all(way in NOT_SWEPT["flight"] for way in ("soft", *FLIGHT_EFFECTS))


def test_values_are_plain_arrays() -> None:
    (axis,) = axes_of(["b_ad=3"], SIM2)
    assert axis.values.dtype == np.float64
    assert axis.values.shape == (1,)
