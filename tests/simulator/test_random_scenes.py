"""Scenes drawn over the whole legal box: refused in a sentence, or simulated in bounded work to a named outcome, with
every number there, the energy book closed within the accuracy, and the same bits again.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from simulator.effects.registry import EFFECTS
from simulator.jump import simulate
from simulator.kernel.rows import COLUMN
from simulator.result import JumpResult
from tests.helpers.random_scenes import (
    FEW_STEPS,
    Flags,
    Made,
    Row,
    bases,
    endless,
    energy_at_play_j,
    lacking,
    make,
    open_book,
    run,
    well_posed,
)
from tests.helpers.scenes import is_sentence

ACCURACY = 1e-6
SCENES = 200
PUBLIC = 10
"""Scenes of each set that go through `simulate` as well."""
SHIPPED = list(bases(0, 0))
DRAWN_SETS, SEED = 35, 2024
ALL = list(bases(DRAWN_SETS, SEED))
SOAKED = 100_000 // len(ALL)
GOALS = 10.0 ** -np.arange(6.0, 11.5)
"""Where errors set the steps; at coarser ones the motion does, and errors lie further below what was asked for."""
FINEST = 1e-12
FEWEST_COMPARED, COMPARED = 30, 60
MOST_ENDLESS, MOST_ENDLESS_DRAWN = 0.02, 0.1
"""Of the shipped effect sets, and of drawn ones: without a clock, light feet slide on thresholds, and no mode follows a
foot without inertia through grains (up to 8 % were measured)."""
LEAST_SLOPE, MOST_SLOPE = 0.7, 1.15
"""Of a method whose steps keep a local error: the error of what comes out goes with the accuracy asked for (0.71 to
1.09 were measured over 40 effect sets)."""


def shipped(*by_default: str) -> list[Any]:
    """The places of the shipped scenes, those that are not named in a soak."""
    return [
        pytest.param(place, id=base.name, marks=() if base.name in by_default else pytest.mark.soak)
        for place, base in enumerate(SHIPPED)
    ]


@pytest.fixture(scope="module", params=shipped("sim2", "emulator"))
def made(request: pytest.FixtureRequest) -> Made:
    """Scenes with the effects of a shipped one."""
    return make(SHIPPED[request.param], SCENES, request.param, ACCURACY)


def none_of(faults: Mapping[str, str], told: str = "") -> None:
    """Fail with all faults that there are, in full."""
    found = [f"{name}: {fault}" for name, fault in faults.items() if fault]
    if found:
        pytest.fail("\n".join([*found, told]), pytrace=False)


def too_many(made: Made, wrong: Flags, most: float) -> str:
    return made.told(wrong) if wrong.mean() > most else ""


def test_what_is_refused_is_refused_in_a_sentence(made: Made) -> None:
    assert made.refusals
    assert [text for text in made.refusals if not is_sentence(text)] == []


def test_every_scene_ends_in_bounded_work(made: Made) -> None:
    """Few by the limit on steps, which is an outcome with a name: those that would need millions."""
    assert made.made[:, 0].all()
    assert np.nanmax(made.column("steps")) <= FEW_STEPS
    none_of({"work": too_many(made, endless(made), MOST_ENDLESS)})


def test_every_number_that_an_outcome_has_is_there_and_finite(made: Made) -> None:
    none_of({name: made.told(wrong) for name, wrong in lacking(made).items()})


def test_the_energy_book_closes_within_the_accuracy(made: Made) -> None:
    """Of every scene that was simulated to an end."""
    none_of({"energy": made.told(open_book(made, ACCURACY) & ~endless(made))})


def test_a_repeat_in_another_order_is_the_same_bit_for_bit(made: Made) -> None:
    order = np.random.default_rng(1).permutation(len(made.table))
    again = run(made.base, np.ascontiguousarray(made.table[order]), ACCURACY)
    assert same_bits(again, made.rows[order])


def same_bits(first: Row, second: Row) -> bool:
    return first.tobytes() == second.tobytes()


def compared(jump: JumpResult) -> list[float | None]:
    return [jump.max_depth_m, jump.liftoff_time_s, jump.apex_height_m, jump.jump_heat_J, jump.energy_residual_J]


def columns(row: Row) -> list[float | None]:
    names = ("max_depth_m", "liftoff_time_s", "apex_height_m", "jump_heat_J", "energy_residual_J")
    return [float(row[COLUMN[name]]) if math.isfinite(row[COLUMN[name]]) else None for name in names]


def test_simulate_gives_the_same(made: Made) -> None:
    quick = np.flatnonzero(~endless(made))[:PUBLIC]
    assert len(quick) == PUBLIC
    for place in quick:
        jumps = simulate(made.scenes[place], ACCURACY).jumps
        rows = made.rows[place, made.made[place]]
        assert [compared(jump) for jump in jumps] == [columns(row) for row in rows]


def errors(made: Made, finest: Made) -> Row:
    """Largest relative error of what an accuracy is promised for, at the last jump, shape (scenes,).

    The cost counts against the energy at play where it is less: with motors that brake what they drove it is a small
    difference.
    """

    def last(found: Made, *names: str) -> Row:
        return np.asarray(sum(found.column(name)[:, -1] for name in names))

    cost = ("jump_heat_J", "jump_mechanical_J", "jump_drag_J")
    scale_j = np.maximum(np.abs(last(finest, *cost)), energy_at_play_j(finest)[:, -1])
    found = [np.abs(last(made, *cost) - last(finest, *cost)) / scale_j]
    with np.errstate(invalid="ignore", divide="ignore"):  # a depth or time of 0 is no part of the comparison
        outputs = ("max_depth_m", "liftoff_time_s", "apex_height_m")
        found += [np.abs(last(made, name) / last(finest, name) - 1.0) for name in outputs]
    return np.asarray(np.fmax.reduce(found, axis=0))


def slope_of_median_error(made: Made) -> float | None:
    """Slope of the logarithm of the median error against that of the accuracy, over well-posed scenes, if many are."""
    table = made.table[well_posed(made, ACCURACY)][:COMPARED]
    if len(table) < FEWEST_COMPARED:
        return None

    def at(accuracy: float) -> Made:
        return replace(made, scenes=(), refusals=(), table=table, rows=run(made.base, table, accuracy))

    finest = at(FINEST)
    median = [np.nanmedian(errors(at(goal), finest)) for goal in GOALS]
    return float(np.polyfit(np.log(GOALS), np.log(median), 1)[0])


@pytest.mark.parametrize("made", shipped("sim2"), indirect=True)
def test_errors_shrink_with_the_accuracy_asked_for(made: Made) -> None:
    slope = slope_of_median_error(made)
    assert slope is not None
    assert LEAST_SLOPE < slope < MOST_SLOPE


def test_the_soaked_sets_have_every_effect_and_most_pairs() -> None:
    pairs = {pair for base in ALL for pair in itertools.combinations(sorted(base.effects), 2)}
    assert {name for base in ALL for name in base.effects} == set(EFFECTS)
    assert len({base.effects for base in ALL}) == len(ALL) <= 40
    assert len(pairs) > 290


@pytest.mark.soak
@pytest.mark.parametrize("place", range(len(ALL)))
def test_a_hundred_thousand_scenes(place: int, capsys: pytest.CaptureFixture[str]) -> None:
    """All of the above for one of the effect sets, and every fault of it at once."""
    made = make(ALL[place], SOAKED, 1000 + place, ACCURACY)
    again = run(made.base, np.ascontiguousarray(made.table[::-1]), ACCURACY)
    with capsys.disabled():
        print(f"\neffect set {place + 1} of {len(ALL)}: {SOAKED} scenes, {len(made.refusals)} refused", flush=True)
    faults = {name: made.told(wrong) for name, wrong in lacking(made).items()}
    faults |= {"work": too_many(made, endless(made), MOST_ENDLESS_DRAWN)}
    faults |= {"energy": made.told(open_book(made, ACCURACY) & ~endless(made))}
    faults["refusals"] = " ".join({text for text in made.refusals if not is_sentence(text)})
    faults["repeat"] = "" if same_bits(again[::-1], made.rows) else "other bits in another order"
    slope = slope_of_median_error(made)
    faults["slope"] = "" if slope is None or LEAST_SLOPE < slope < MOST_SLOPE else f"{slope:.2f}"
    none_of(faults, f"effects {', '.join(sorted(made.base.effects))}")
