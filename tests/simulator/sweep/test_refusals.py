"""Scenes of a sweep whose values do not fit together: said beforehand, not simulated, and marked in the file."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pytest
import xarray

from data_schema.errors import UsageError
from simulator.jump import simulate
from simulator.scene import Scene
from simulator.scene_file import load_scene
from simulator.sweep.compute import Threads
from simulator.sweep.outputs import OUTPUTS
from simulator.sweep.run import run_sweep
from simulator.sweep.sweep import Sweep
from tests.helpers.scenes import is_sentence, scene_or_sentence
from tests.helpers.sweeps import every_byte, grid_sweep, sobol_sweep
from tests.helpers.wording import refuses

CORNERS = ("upper_link=0.12,0.22", "b_ad=0,100", "lower_link=0.2,0.3", "rest_length=0.15,0.27,0.36")
"""Two rules are broken here, by some scenes both; the damping between them is read by none."""


@pytest.mark.parametrize(
    ("over", "count", "said"),
    [
        (["kg_scale=0.01,1"], "1 of 2 scenes cannot be simulated and is marked refused", "K < m_a g"),
        (["kg_scale=0.01,1"], "1 of 2", "the first at kg_scale = 0.01: "),
        (
            ["rest_length=0.2:0.31:12"],
            "2 of 12 scenes cannot be simulated and are",
            "the first at rest_length = 0.3: rest_length = 0.3 m is out of",
        ),
        (
            ["upper_link=0.1,0.2", "lower_link=0.2,0.3"],
            "1 of 4",
            "the first at upper_link = 0.2, lower_link = 0.2: upper_link = 0.2 m is not shorter",
        ),
    ],
)
def test_how_many_and_why_is_said_before_anything_runs(over: list[str], count: str, said: str) -> None:
    sentence = grid_sweep(*over).refused
    assert sentence.startswith(count)
    assert said in sentence
    assert is_sentence(sentence)


def test_nothing_is_said_of_a_sweep_without_any() -> None:
    assert (grid_sweep("b_ad=0,100").refused, grid_sweep("b_ad=0,100").refusals.count) == ("", 0)


def assert_those_a_scene_refuses(sweep: Sweep) -> None:
    names = [axis.parameter for axis in sweep.design.axes]
    rows = sweep.design.rows(0, sweep.design.row_count).tolist()
    alone = [scene_or_sentence(sweep.scene.changed, dict(zip(names, row, strict=True))) for row in rows]
    expected = [not isinstance(made, Scene) for made in alone]
    assert 0 < sum(expected) < len(rows)
    assert sweep.refusals.count == sum(expected)
    for cut in (0, 1, len(rows) // 2, len(rows)):
        found = [*sweep.refusals.rows(0, cut).tolist(), *sweep.refusals.rows(cut, len(rows)).tolist()]
        assert found == expected


def test_they_are_the_scenes_that_are_refused_one_by_one() -> None:
    assert_those_a_scene_refuses(grid_sweep(*CORNERS))
    assert_those_a_scene_refuses(sobol_sweep(256, "kg_scale=0.01:10:log", "foot_radius=0.02:0.05"))
    guarded = grid_sweep("guard_length=0.1,0.25", "rest_length=0.2,0.27", scene=load_scene("force_plate"))
    assert_those_a_scene_refuses(guarded)


def test_the_others_are_simulated_as_if_alone_and_these_marked(tmp_path: Path) -> None:
    sweep, out = grid_sweep(*CORNERS), tmp_path / "out.nc"
    told: list[int] = []
    done = run_sweep(sweep, out, Threads(), told.append)
    assert sum(told) == done.jumps_made == sweep.legal_rows == 24 - sweep.refusals.count
    assert done.summary.outcomes["refused"] == sweep.refusals.count
    with xarray.open_dataset(out, engine="netcdf4") as found:
        assert found.attrs["refused"] == sweep.refused
        outcome = found["outcome"]
        flags = dict(zip(outcome.attrs["flag_values"], outcome.attrs["flag_meanings"].split(), strict=True))
        flat = {output.name: found[output.name].values.ravel() for output in OUTPUTS}
    refused = sweep.refusals.rows(0, 24)
    assert [flags[value] == "refused" for value in flat["outcome"].tolist()] == refused.tolist()
    for output in OUTPUTS[1:]:
        marked = flat[output.name][refused]
        assert np.isnan(marked).all() if output.kind == "f8" else (marked == -1).all(), output.name
    names = [axis.parameter for axis in sweep.design.axes]
    for place in np.flatnonzero(~refused).tolist():
        values = dict(zip(names, sweep.design.rows(place, place + 1)[0].tolist(), strict=True))
        jump = simulate(sweep.scene.changed(values), sweep.accuracy).jump
        assert (flat["cost_J"][place], flat["steps"][place]) == (jump.cost_J, jump.steps)


def test_all_jumps_of_a_refused_scene_are_marked(tmp_path: Path) -> None:
    scene = load_scene("emulator").changed(jumps=2)
    sweep = grid_sweep("release_tolerance=0.004,0.01", scene=scene)
    assert run_sweep(sweep, tmp_path / "out.nc", Threads()).summary.outcomes == {"refused": 2, "touchdown": 2}


def test_whole_chunks_of_them_and_interruptions_change_no_bit(tmp_path: Path) -> None:
    """More than a chunk of refused scenes in a row, and a sweep that goes on after it was stopped."""
    sweep = grid_sweep("upper_link=0.12,0.22", "lower_link=0.2,0.3", "b_ad=0:300:300")
    bounds = [sweep.chunks.bounds(number) for number in range(sweep.chunks.count)]
    assert any(sweep.refusals.rows(*both).all() for both in bounds)
    run_sweep(sweep, tmp_path / "whole.nc", Threads())
    told: list[int] = []

    def stop(chunks: int) -> None:
        told.append(chunks)
        if len(told) > 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_sweep(sweep, tmp_path / "stopped.nc", Threads(1), stop)
    done = run_sweep(sweep, tmp_path / "stopped.nc", Threads(3))
    assert 0 < done.chunks_before < sweep.chunks.count
    assert every_byte(tmp_path / "stopped.nc") == every_byte(tmp_path / "whole.nc")


def test_a_sweep_of_nothing_else_is_refused() -> None:
    for over in (["kg_scale=0.01,0.011"], ["upper_link=0.2,0.25", "lower_link=0.15,0.2"]):
        with refuses(UsageError, "no scene of") as refusal:
            grid_sweep(*over)
        assert is_sentence(str(refusal.value))


def test_rows_are_found_among_those_of_a_part() -> None:
    for sweep in (grid_sweep(*CORNERS), sobol_sweep(24)):
        design = sweep.design
        names = [axis.parameter for axis in design.axes]
        rows = design.rows(0, 24).tolist()
        for chosen in itertools.chain(*(itertools.combinations(names, size) for size in (1, 2, len(names)))):
            part = design.part(chosen)
            points = part.rows(0, part.row_count).tolist()
            for row, place in zip(rows, design.rows_in_part(chosen, 0, 24).tolist(), strict=True):
                assert points[place] == [value for name, value in zip(names, row, strict=True) if name in chosen]
