"""Scenes of a sweep whose values do not fit together: said beforehand, not simulated, and marked in the file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray

from simulator.jump import simulate
from simulator.scene import Scene
from simulator.scene_file import load_scene
from simulator.sweep.chunks import OUTPUTS
from simulator.sweep.run import run_sweep, threads
from simulator.sweep.sweep import Sweep
from tests.helpers.scenes import scene_or_sentence
from tests.helpers.sweeps import every_byte, grid_sweep, sobol_sweep

CORNERS = ("upper_link=0.12,0.22", "b_ad=0,100", "lower_link=0.2,0.3", "rest_length=0.15,0.27,0.36")
"""Two rules are broken here, by some scenes both; the damping between them is read by none."""


def assert_those_a_scene_refuses(sweep: Sweep) -> None:
    names = [axis.parameter for axis in sweep.design.axes]
    rows = sweep.design.rows(0, sweep.design.row_count).tolist()
    alone = [scene_or_sentence(sweep.scene.changed, dict(zip(names, row, strict=True))) for row in rows]
    expected = [not isinstance(made, Scene) for made in alone]
    assert 0 < sum(expected) < len(rows)
    assert sweep.refused.tolist() == expected


def test_they_are_the_scenes_that_are_refused_one_by_one() -> None:
    assert_those_a_scene_refuses(grid_sweep(*CORNERS))
    assert_those_a_scene_refuses(sobol_sweep(256, "kg_scale=0.01:10:log", "foot_radius=0.02:0.05"))
    guarded = grid_sweep("guard_length=0.1,0.25", "rest_length=0.2,0.27", scene=load_scene("force_plate"))
    assert_those_a_scene_refuses(guarded)


def test_the_others_are_simulated_as_if_alone_and_these_marked(tmp_path: Path) -> None:
    sweep, out = grid_sweep(*CORNERS), tmp_path / "out.nc"
    told: list[int] = []
    with threads() as computing:
        done = run_sweep(sweep, out, computing, told.append)
    assert sum(told) == done.jumps_wanted == 24 - sweep.refused.sum()
    assert done.summary.outcomes["refused"] == sweep.refused.sum()
    with xarray.open_dataset(out, engine="netcdf4") as found:
        assert found.attrs["refused"] == sweep.why_refused
        outcome = found["outcome"]
        flags = dict(zip(outcome.attrs["flag_values"], outcome.attrs["flag_meanings"].split(), strict=True))
        flat = {output.name: found[output.name].values.ravel() for output in OUTPUTS}
    refused = sweep.refused
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
    with threads() as computing:
        assert run_sweep(sweep, tmp_path / "out.nc", computing).summary.outcomes == {"refused": 2, "touchdown": 2}


def test_whole_chunks_of_them_and_interruptions_change_no_bit(tmp_path: Path) -> None:
    """More than a chunk of refused scenes in a row, and a sweep that goes on after it was stopped."""
    sweep = grid_sweep("upper_link=0.12,0.22", "lower_link=0.2,0.3", "b_ad=0:300:300")
    assert any(sweep.refused[rows].all() for rows in sweep.chunks)
    with threads() as computing:
        run_sweep(sweep, tmp_path / "whole.nc", computing)
    told: list[int] = []

    def stop(jumps: int) -> None:
        told.append(jumps)
        if len(told) > 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), threads(1) as computing:
        run_sweep(sweep, tmp_path / "stopped.nc", computing, stop)
    with threads(3) as computing:
        done = run_sweep(sweep, tmp_path / "stopped.nc", computing)
    assert 0 < done.chunks_before < len(sweep.chunks)
    assert every_byte(tmp_path / "stopped.nc") == every_byte(tmp_path / "whole.nc")
