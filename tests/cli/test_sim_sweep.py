"""`labbook sim sweep`: what is printed and written."""

from __future__ import annotations

import importlib.metadata
import itertools
import json
from pathlib import Path
from typing import Any

import pytest
import xarray

from tests.cli.shell import good, labbook, process, refused
from tests.helpers.kernels import interpreted
from tests.helpers.wording import says

KEYS = {
    *("out", "scene", "dims", "jumps", "accuracy", "sampling", "outcomes", "ill_conditioned", "assumed"),
    *("set_by_user", "refused", "under_surface", "open_book", "error_bars", "sampled", "sampled_outside"),
    *("variables", "chunks", "chunks_before", "compile_time_s", "compute_time_s", "write_time_s", "jump_time_us"),
    *("in_lanes", "small_cost", "cost_not_positive", "never_rose"),
}
GRID = ("--over", "b_ad=0:300:4", "--over", "foot_radius=0.02,0.03,0.038")


def swept(at: Path, *more: str, out: str = "sweep.nc") -> Any:
    return good(labbook("sim", "sweep", "--scene", "sim2", *more, "--out", out, "--json", at=at)).json


def shown(at: Path, *words: str) -> str:
    return good(labbook("sim", "sweep", *words, at=at)).out


def test_a_grid_holds_what_single_runs_give(tmp_path: Path) -> None:
    found = swept(tmp_path, *GRID, "--set", "gain=300", "--effects", "+leg_damping", "--accuracy", "1e-5")
    assert found.keys() == KEYS
    assert (found["jumps"], found["dims"]) == (12, {"b_ad": 4, "foot_radius": 3})
    assert found["outcomes"] == {"touchdown": 12}
    assert found["set_by_user"] == {"k_extension": 835.36}
    with xarray.open_dataset(tmp_path / found["out"]) as dataset:
        assert json.loads(dataset.attrs["set_by_user"]) == {"k_extension": 835.36}
        says(dataset.attrs["scene_toml"], "k_extension", "value = 835.36", "set_by_user")
        says(dataset.attrs["title"], "gain=300", "leg_damping", "b_ad", "foot_radius")
        assert dataset.attrs["labbook_version"] == importlib.metadata.version("robot-labbook")
        for b_ad, radius in itertools.product((0, 300), (0.02, 0.038)):
            sets = f"--set b_ad={b_ad} --set foot_radius={radius} --set gain=300"
            words = f"sim run --scene sim2 {sets} --accuracy 1e-5 --no-error-bars --json"
            one = good(labbook(*words.split(), at=tmp_path)).json
            there = dataset.sel(b_ad=b_ad, foot_radius=radius)
            for name in ("cost_J", "apex_height_m", "liftoff_time_s", "max_depth_m", "energy_residual_J", "steps"):
                assert there[name].item() == one[name], name


def test_jumps_whose_cost_is_small_or_not_positive_are_told_with_the_reason(tmp_path: Path) -> None:
    """Motors of little resistance: what braking gives back is as much as the jump takes."""
    words = ("sim", "sweep", "--scene", "bed", "--set", "motor_resistance=0.001", "--over", "gain=200:340:8")
    told = good(labbook(*words, "--out", "free.nc", at=tmp_path)).out
    found = good(labbook(*words, "--out", "free.nc", "--json", at=tmp_path)).json
    assert found["jumps"] == 8
    assert 0 < found["small_cost"] <= found["ill_conditioned"] < 8
    assert 0 < found["cost_not_positive"] < 8
    (line,) = (line for line in told.splitlines() if "ill-conditioned" in line)
    says(line, f"ill-conditioned: {found['ill_conditioned']}", f"{found['small_cost']} of them", "small difference")
    (warning,) = (line for line in told.splitlines() if line.startswith("warning: "))
    says(warning, str(found["cost_not_positive"]), "not positive", "+no_regeneration")
    with xarray.open_dataset(tmp_path / "free.nc") as dataset:
        assert int((dataset["cost_J"] <= 0.0).sum()) == found["cost_not_positive"]


def test_a_touchdown_of_a_foot_that_never_rose_is_counted_apart(tmp_path: Path) -> None:
    """Strong active damping: the gains of flight press the lifted foot down until the body falls."""
    scene = ("--scene", "bed", "--accuracy", "1e-5")
    words = ("sim", "sweep", *scene, "--over", "b_ad=500:5000:10", "--out", "sweep.nc", "--json")
    found = good(labbook(*words, at=tmp_path)).json
    outcomes = found["outcomes"]
    assert 0 < outcomes["never_rose"] == found["never_rose"] < 10 == sum(outcomes.values())
    with xarray.open_dataset(tmp_path / "sweep.nc") as dataset:
        no_jump = dataset["never_rose"] == 1
        assert (dataset["apex_time_s"] == dataset["next_touchdown_time_s"])[no_jump].all()
        assert (dataset["unresisted_sink_m"] > 0.0)[no_jump].all()
        b_ad = float(dataset["b_ad"][no_jump][0])
    told = good(labbook("sim", "run", *scene, "--set", f"b_ad={b_ad}", at=tmp_path)).out
    says(told.splitlines()[1], "did not jump", "never rose above its print", "touchdown")


def test_with_error_bars_a_scene_has_what_a_single_run_shows(tmp_path: Path) -> None:
    words = ("--over", "foot_radius=0.02,0.038", "--accuracy", "1e-5")
    assert swept(tmp_path, *words, "--error-bars", out="bars.nc")["error_bars"] == 1.0
    alone = ("sim", "run", "--scene", "sim2", "--set", "foot_radius=0.02", *words[2:], "--json")
    one = good(labbook(*alone, at=tmp_path)).json
    with xarray.open_dataset(tmp_path / "bars.nc") as dataset:
        there = dataset.sel(foot_radius=0.02)
        assert (there["cost_J"].item(), there["cost_J_error"].item()) == (one["cost_J"], one["errors"]["cost_J"])
        assert there["ill_conditioned"].item() == one["ill_conditioned"]


def test_a_sample_to_zarr_and_the_same_command_again(tmp_path: Path) -> None:
    words = ("--over", "b_ad=0:300", "--over", "kg_scale=1:100:log", "--sobol", "32", "--seed", "7")
    found = swept(tmp_path, *words, out="sweep.zarr")
    assert found["dims"] == {"sample": 32}
    says(found["sampling"], "scrambled with seed", "7")
    assert found["chunks_before"] == 0
    with xarray.open_zarr(tmp_path / "sweep.zarr") as dataset:
        assert set(dataset.coords) == {"b_ad", "kg_scale"}
    again = swept(tmp_path, *words, out="sweep.zarr")
    assert again["chunks_before"] == again["chunks"]
    assert again["jump_time_us"] is None
    assert again["outcomes"] == found["outcomes"]


def test_what_a_person_sees(tmp_path: Path) -> None:
    words = ("sim", "sweep", "--scene", "bed", "--over", "gain=300,400", "--out", "bed.nc")
    shown = good(labbook(*words, at=tmp_path)).out
    says(shown, "2 jumps")
    says(shown, "kg_scale is assumed: ")
    assert "set by you" not in shown
    with xarray.open_dataset(tmp_path / "bed.nc") as dataset:
        says(shown, f"{len(dataset.data_vars)} variables", "xarray.open_dataset", "'bed.nc'")
    says(good(labbook(*words, at=tmp_path)).out, "nothing was left")


def test_parameters_assumed_for_one_reason_are_told_of_in_one_line(tmp_path: Path) -> None:
    words = ("--scene", "sim1", "--over", "foot_radius=0.02,0.03", "--accuracy", "1e-3", "--out", "sim1.nc")
    says(
        interpreted(shown, tmp_path, *words), "k_compression, k_extension, b_compression and b_extension are assumed: "
    )


def test_a_corner_that_cannot_be_is_told_of_and_left_out(tmp_path: Path) -> None:
    words = ("--over", "kg_scale=0.01,1", "--over", "b_ad=0,100")
    found = swept(tmp_path, *words)
    assert found["outcomes"] == {"refused": 2, "touchdown": 2}
    assert (found["jumps"], found["dims"]) == (2, {"kg_scale": 2, "b_ad": 2})
    assert found["refused"]["scenes"] == 2
    shown = good(labbook("sim", "sweep", "--scene", "sim2", *words, "--out", "sweep.nc", at=tmp_path)).out.splitlines()
    assert shown[1] == f"note: {found['refused']['why']}"


@pytest.mark.parametrize("over", ["air_drag:drag_area=0,0.5", "rail_friction:rail_friction_force=1,3"])
def test_a_parameter_that_the_scene_lacks_can_be_swept(over: str, tmp_path: Path) -> None:
    """One with an assumed value, and one that has none; two jumps take less time than to compile a kernel for them."""
    effect, words = over.split(":")
    found = interpreted(swept, tmp_path, "--effects", f"+{effect}", "--over", words, "--accuracy", "1e-3")
    assert found["outcomes"] == {"touchdown": 2}
    with xarray.open_dataset(tmp_path / "sweep.nc") as dataset:
        assert dataset["apex_height_m"].values[0] > dataset["apex_height_m"].values[-1]


def test_no_address_of_a_scheduler_is_refused_to_the_last_line(tmp_path: Path) -> None:
    """In a process of its own: what a client leaves behind is told as Python ends."""
    address = "http://127.0.0.1:8786"
    words = ("--scene", "sim2", "--over", "b_ad=0,1", "--out", "a.nc", "--scheduler", address)
    refused(process("sim", "sweep", *words, at=tmp_path), 2, f"no Dask scheduler answers at {address}")
