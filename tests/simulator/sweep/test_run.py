"""A sweep to a file: what xarray reads, equal files however they came about, other files left alone."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

from data_schema.errors import UsageError
from simulator.jump import simulate
from simulator.scene_file import load_scene, parse_scene
from simulator.sweep.chunks import ERRORS, FLAGS, OUTPUTS, SAMPLED_ERROR, simulator_here
from simulator.sweep.run import Computing, Finished, part_folder, run_sweep, threads
from simulator.sweep.sweep import Sweep
from tests.helpers.scenes import is_sentence
from tests.helpers.sweeps import every_byte, grid_sweep, sobol_sweep
from tests.helpers.wording import says

FORMATS = ("nc", "zarr")


def run(sweep: Sweep, out: Path, count: int | None = None, advance: Callable[[int], None] = lambda _: None) -> Finished:
    with threads(count) as computing:
        return run_sweep(sweep, out, computing, advance)


def opened(path: Path) -> xarray.Dataset:
    with xarray.open_dataset(path, engine="zarr" if path.suffix == ".zarr" else "netcdf4") as dataset:
        return dataset.load()


@pytest.mark.parametrize("kind", FORMATS)
def test_a_grid_as_xarray_reads_it(kind: str, tmp_path: Path) -> None:
    sweep = grid_sweep("b_ad=0:300:4", "gain=300,600", "foot_radius=0.02,0.03,0.038")
    out = tmp_path / f"grid.{kind}"
    done = run(sweep, out)
    found = opened(out)
    assert dict(found.sizes) == {"b_ad": 4, "gain": 2, "foot_radius": 3}
    assert set(found.data_vars) == {output.name for output in (*OUTPUTS, SAMPLED_ERROR)}
    assert set(found.coords) == {"b_ad", "gain", "foot_radius", "k_extension"}
    assert found["k_extension"].dims == ("gain",)
    assert found["b_ad"].values.tolist() == [0.0, 100.0, 200.0, 300.0]
    assert found["b_ad"].attrs == {"units": "kg/m", "long_name": sweep.design.axes[0].meaning}
    assert found["cost_J"].attrs["units"] == "J"
    assert all({"units", "long_name"} <= set(found[name].attrs) for name in (*found.data_vars, *found.coords))
    assert max(len(found[name].attrs["long_name"]) for name in (*found.data_vars, *found.coords)) <= 60  # labels fit
    says(found["apex_height_m"].attrs["comment"], "undisturbed surface", "NaN")
    assert {str(found[output.name].dtype) for output in OUTPUTS} == {"float64", "int32", "int8"}

    point = found.sel(b_ad=200.0, gain=600.0, foot_radius=0.038)
    values = {"b_ad": 200.0, "foot_radius": 0.038, "k_extension": float(point["k_extension"])}
    jump = simulate(sweep.scene.changed(values), sweep.accuracy).jump
    assert float(point["cost_J"]) == jump.cost_J
    assert float(point["apex_height_m"]) == jump.apex_height_m
    assert int(point["steps"]) == jump.steps

    outcome = found["outcome"]
    flags = dict(zip(outcome.attrs["flag_values"], outcome.attrs["flag_meanings"].split(), strict=True))
    assert {flags[one] for one in np.unique(outcome)} == {"touchdown"}
    assert done.summary.outcomes == {"touchdown": 24}
    assert done.summary.flagged == {flag: int((found[flag] == 1).sum()) for flag in FLAGS}
    assert not part_folder(out).exists()


def test_a_file_says_what_it_rests_on(tmp_path: Path) -> None:
    scene = load_scene("bed").changed({"body_mass": 1.5})
    sweep = grid_sweep("kg_scale=1,2", scene=scene)
    run(sweep, tmp_path / "bed.nc")
    attributes = opened(tmp_path / "bed.nc").attrs
    assert parse_scene(attributes["scene_toml"], "bed") == scene
    assert json.loads(attributes["assumed"]) == {"foot_mass": scene.values["foot_mass"].why}
    assert attributes["accuracy"] == sweep.accuracy
    assert attributes["effects"].split() == [name for name in attributes["effects"].split() if name in scene.effects]
    assert attributes["simulator_fingerprint"] == simulator_here()
    assert attributes["labbook_version"] == "0.test"


def test_a_sample_and_scenes_with_several_jumps(tmp_path: Path) -> None:
    run(sobol_sweep(32, "b_ad=0:300", "gain=100:600"), tmp_path / "sample.nc")
    sample = opened(tmp_path / "sample.nc")
    assert dict(sample.sizes) == {"sample": 32}
    assert set(sample.coords) == {"b_ad", "gain", "k_extension"}
    assert sample["gain"].dims == ("sample",)

    scene = load_scene("emulator").changed({}, jumps=3)
    run(grid_sweep("k_extension=20,200,1000", scene=scene), tmp_path / "jumps.nc")
    jumps = opened(tmp_path / "jumps.nc")
    assert dict(jumps.sizes) == {"k_extension": 3, "jump": 3}
    assert jumps["jump"].values.tolist() == [1, 2, 3]
    assert jumps["outcome"].values.tolist() == [[4, -1, -1], [3, -1, -1], [2, 2, 2]]
    assert jumps["steps"].values[0, 1:].tolist() == [-1, -1]
    assert np.isnan(jumps["apex_height_m"].values[:2]).all()


def test_both_formats_hold_the_same(tmp_path: Path) -> None:
    sweep = sobol_sweep(300)
    for kind in FORMATS:
        run(sweep, tmp_path / f"out.{kind}")
    xarray.testing.assert_identical(opened(tmp_path / "out.nc"), opened(tmp_path / "out.zarr"))


class Backwards(Executor):
    """Computes the chunks when all under way are there, the last one first, and stops after so many."""

    def __init__(self, most: int) -> None:
        self.most, self.waiting = most, list[tuple[Future[Any], Callable[..., Any], tuple[Any, ...]]]()

    def submit(self, work: Callable[..., Any], /, *arguments: Any, **_: Any) -> Future[Any]:
        future: Future[Any] = Future()
        self.waiting.append((future, work, arguments))
        if len(self.waiting) == 3:
            self.compute()
        return future

    def compute(self) -> None:
        while self.waiting:
            future, work, arguments = self.waiting.pop()
            self.most -= 1
            if self.most < 0:
                future.set_exception(KeyboardInterrupt())
            else:
                future.set_result(work(*arguments))


@pytest.mark.parametrize("kind", ["nc", pytest.param("zarr", marks=pytest.mark.soak)])
def test_threads_order_and_interruptions_change_no_bit(kind: str, tmp_path: Path) -> None:
    sweep = sobol_sweep(1536)
    assert len(sweep.chunks) == 12
    first = tmp_path / f"first.{kind}"
    assert run(sweep, first, 1).chunks_before == 0
    run(sweep, tmp_path / f"threads.{kind}", 7)
    run_sweep(sweep, tmp_path / f"backwards.{kind}", Computing(Backwards(100), 3))
    for name in ("threads", "backwards"):
        assert every_byte(tmp_path / f"{name}.{kind}") == every_byte(first)
    broken = tmp_path / f"broken.{kind}"
    with pytest.raises(KeyboardInterrupt):
        run_sweep(sweep, broken, Computing(Backwards(4), 3))
    assert not broken.exists()
    for name in (f".result.{kind}", ".11.npy"):
        (part_folder(broken) / name).write_bytes(b"killed while this was written")
    told: list[int] = []
    done = run(sweep, broken, advance=told.append)
    assert 3 <= done.chunks_before <= 4
    assert told[0] == 128 * done.chunks_before == 1536 - done.jumps_wanted
    assert sum(told) == sweep.jumps_wanted == 1536
    assert every_byte(broken) == every_byte(first)
    assert {path.name for path in tmp_path.iterdir()} == {
        f"{name}.{kind}" for name in ("first", "threads", "backwards", "broken")
    }


@pytest.mark.parametrize("damage", ["emptied", "cut", "flipped", "another's"])
def test_a_damaged_chunk_is_computed_anew(tmp_path: Path, damage: str) -> None:
    sweep, first, broken = sobol_sweep(1536), tmp_path / "first.nc", tmp_path / "broken.nc"
    run(sweep, first)
    with pytest.raises(KeyboardInterrupt):
        run_sweep(sweep, broken, Computing(Backwards(4), 3))
    one, other, *_more = sorted(part_folder(broken).glob("[0-9]*.npy"))
    content = one.read_bytes()
    middle = len(content) // 2
    one.write_bytes(
        {
            "emptied": b"",
            "cut": content[:-1],
            "flipped": content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :],
            "another's": b"\x93NUMPY" + bytes(len(content) - 6),
        }[damage]
    )
    assert other.exists()
    done = run(sweep, broken)
    assert done.chunks_before < 4
    assert every_byte(broken) == every_byte(first)


def test_a_chunk_is_there_when_it_is_on_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def power_cut(_file: int) -> None:
        raise KeyboardInterrupt

    out = tmp_path / "out.nc"
    with pytest.raises(KeyboardInterrupt):
        run_sweep(sobol_sweep(600), out, Computing(Backwards(0), 3))
    with monkeypatch.context() as patch:
        patch.setattr("os.fsync", power_cut)
        with pytest.raises(KeyboardInterrupt):
            run(sobol_sweep(600), out)
    assert run(sobol_sweep(600), out).chunks_before == 0


def test_error_bars_are_variables(tmp_path: Path) -> None:
    sweep, out = sobol_sweep(300, error_bars=1.0), tmp_path / "out.nc"
    with pytest.raises(KeyboardInterrupt):
        run_sweep(sweep, out, Computing(Backwards(2), 3))
    says(refusal(sobol_sweep(300), out), "unfinished", "error bars", "100 % there", "5 % now")
    run(sweep, out)
    found = opened(out)
    assert set(found.data_vars) == {output.name for output in (*OUTPUTS, *ERRORS)}
    assert np.all(found["cost_J_error"].values > 0.0)
    assert found["cost_J_error"].attrs["units"] == "J"
    says(refusal(sobol_sweep(300), out), "differs in error bars")


def test_a_sample_of_the_scenes_has_error_bars_and_changes_no_other_number(tmp_path: Path) -> None:
    """Those of the sample are what a sweep with all error bars gives."""
    outs = {share: tmp_path / f"{share}.nc" for share in (0.0, 0.05, 1.0)}
    over = ("b_ad=0:300:10", "foot_radius=0.02:0.04:8")
    done = {share: run(grid_sweep(*over, accuracy=1e-6, error_bars=share), out) for share, out in outs.items()}
    plain, sampled, every = (opened(out) for out in outs.values())
    assert set(sampled.data_vars) - set(plain.data_vars) == {SAMPLED_ERROR.name}
    assert all(np.array_equal(sampled[name], plain[name], equal_nan=True) for name in plain.data_vars)
    over_goal, there = sampled[SAMPLED_ERROR.name], ~np.isnan(sampled[SAMPLED_ERROR.name])
    assert 15 <= there.sum() <= 25
    names = ("max_depth_m", "liftoff_time_s", "apex_height_m", "cost_J")
    shares = [every[f"{name}_error"] / abs(every[name]) / 1e-6 for name in names]
    assert np.allclose(np.max(shares, axis=0)[there.values], over_goal.values[there.values])
    assert (done[0.05].summary.sampled, done[0.05].summary.outside) == (there.sum(), (over_goal > 1.0).sum())


def test_a_jump_of_the_sample_that_misses_its_goal_is_flagged(tmp_path: Path) -> None:
    out = tmp_path / "out.nc"
    done = run(grid_sweep("b_ad=600:700:30", scene=load_scene("sim1"), accuracy=1e-9), out)
    found = opened(out)
    missed = found[SAMPLED_ERROR.name].values > 1.0
    assert done.summary.outside == missed.sum() > 0
    assert (found["ill_conditioned"].values[missed] == 1).all()


@pytest.mark.parametrize("times", [1, pytest.param(20, marks=pytest.mark.soak)])
def test_of_programs_that_want_the_same_sweep_at_once_one_computes_it(times: int, tmp_path: Path) -> None:
    """Threads stand for them; the library for the other format bears only one."""
    sweep = grid_sweep("b_ad=0,100")

    def until_it_is_there(out: Path) -> int:
        while True:
            try:
                return run(sweep, out, 1).chunks_before
            except UsageError as refused:
                told_off = str(refused)
            assert "another program" in told_off
            time.sleep(0.002)

    for number in range(times):
        out = tmp_path / f"{number}.zarr"
        with ThreadPoolExecutor(3) as programs:
            before = list(programs.map(until_it_is_there, [out] * 3))
        assert sorted(before) == [0, *[len(sweep.chunks)] * 2]
        assert not part_folder(out).exists()


@pytest.mark.parametrize("kind", FORMATS)
def test_a_finished_file_is_left_as_it_is(kind: str, tmp_path: Path) -> None:
    sweep, out = sobol_sweep(200), tmp_path / f"out.{kind}"
    done = run(sweep, out)
    before = every_byte(out)
    part_folder(out).mkdir()  # as if killed after the file had its name: the folder is still there
    told: list[int] = []
    again = run(sweep, out, advance=told.append)
    assert again.summary == done.summary
    assert again.chunks_before == len(sweep.chunks)
    assert sum(told) == 200
    assert every_byte(out) == before
    assert not part_folder(out).exists()


def test_a_folder_of_somebody_else_is_left_alone(tmp_path: Path) -> None:
    out = tmp_path / "out.nc"
    part_folder(out).mkdir()
    (part_folder(out) / "thesis.txt").write_text("mine", encoding="utf-8")
    says(refusal(sobol_sweep(8), out), "no unfinished sweep")
    assert (part_folder(out) / "thesis.txt").read_text(encoding="utf-8") == "mine"


def refusal(sweep: Sweep, out: Path) -> str:
    with pytest.raises(UsageError) as refused:
        run(sweep, out)
    assert is_sentence(str(refused.value))
    return str(refused.value)


@pytest.mark.parametrize("kind", FORMATS)
def test_other_files_are_not_written_over(kind: str, tmp_path: Path) -> None:
    out = tmp_path / f"out.{kind}"
    run(grid_sweep("b_ad=0,50,100"), out)
    before = every_byte(out)
    says(refusal(grid_sweep("b_ad=0,50,100", accuracy=1e-4), out), "differs in accuracy", "0.001", "0.0001 now")
    says(refusal(grid_sweep("b_ad=0,200"), out), "b_ad", "3 values", "100", "2 values", "200 now")
    says(refusal(sobol_sweep(2, "b_ad=0:100"), out), "differs in sampling")
    changed = load_scene("sim2").changed({"foot_radius": 0.04})
    says(refusal(grid_sweep("b_ad=0,50,100", scene=changed), out), "foot_radius", "0.03", "0.04 now")
    says(refusal(grid_sweep("b_ad=0,60,100"), out), "differs in swept")
    assert every_byte(out) == before
    assert [path.name for path in tmp_path.iterdir()] == [out.name]
    run(sobol_sweep(64, seed=1), sample := tmp_path / f"sample.{kind}")
    says(refusal(sobol_sweep(64, seed=2), sample), "scrambled with seed", "1")


@pytest.mark.parametrize("kind", FORMATS)
def test_a_file_that_is_no_sweep(kind: str, tmp_path: Path) -> None:
    out = tmp_path / f"out.{kind}"
    out.write_bytes(b"something else")
    says(refusal(grid_sweep("b_ad=0,100"), out), "is no sweep")
    assert out.read_bytes() == b"something else"
    folder = tmp_path / "folder.zarr"
    folder.mkdir()
    says(refusal(grid_sweep("b_ad=0,100"), folder), "is no sweep")
