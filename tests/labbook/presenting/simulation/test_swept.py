"""What is said of a finished sweep."""

from __future__ import annotations

from pathlib import Path

from labbook.presenting.simulation.swept import sweep_data, sweep_lines
from simulator.sweep.outputs import FLAGS
from simulator.sweep.run import Finished, Summary
from tests.helpers.sweeps import sobol_sweep

SWEEP = sobol_sweep(300)
NONE = dict.fromkeys(FLAGS, 0)
SUMMARY = Summary({"touchdown": 300}, NONE)


def test_a_sweep_that_went_on_says_how_many_jumps_were_there() -> None:
    done = Finished(Path("a.nc"), SWEEP, SUMMARY, 2, 44, compile_time_s=1.0, compute_time_s=44 * 5.16e-3)
    assert SWEEP.chunks.bounds(2) == (256, 300)
    how = sweep_lines(done)[-2]
    assert how.startswith("227 ms, 5.16 ms a jump, for a relative error of 0.001; ")
    assert how.endswith("compiling; 256 of 300 jumps were there from before.")
    assert sweep_data(done)["jump_time_us"] == 1e6 * done.compute_time_s / 44


def test_a_whole_one_says_nothing_of_before_and_times_in_microseconds() -> None:
    done = Finished(Path("a.nc"), SWEEP, SUMMARY, 0, 300, compile_time_s=1.0, compute_time_s=300 * 51.6e-6)
    assert sweep_lines(done)[-2].startswith("15.5 ms, 51.6 µs a jump, ")
    assert "before" not in sweep_lines(done)[-2]


def test_nothing_was_left() -> None:
    done = Finished(Path("a.nc"), SWEEP, SUMMARY, SWEEP.chunks.count)
    assert "nothing was left to simulate." in sweep_lines(done)
    assert sweep_data(done)["jump_time_us"] is None


def test_only_jumps_that_were_made_are_counted() -> None:
    some = Summary({"refused": 290, "not_made": 9, "touchdown": 1}, NONE)
    done = Finished(Path("a.nc"), SWEEP, some, 0, 1, compute_time_s=1e-3)
    assert sweep_data(done)["jumps"] == 1
    assert sweep_data(done)["jump_time_us"] == 1000.0
    assert sweep_lines(done)[0].startswith("sim2: 1 jump over ")


def test_jumps_that_are_not_to_be_trusted_are_warned_of() -> None:
    assert not any(line.startswith("warning") for line in sweep_lines(Finished(Path("a.nc"), SWEEP, SUMMARY, 0)))
    flagged = Summary({"touchdown": 300}, {"ill_conditioned": 0, "under_surface": 2, "open_book": 1})
    lines = sweep_lines(Finished(Path("a.nc"), SWEEP, flagged, 0))
    assert [line[:57] for line in lines if line.startswith("warning: ")] == [
        "warning: in 2 jumps the body gets under the surface of th",
        "warning: in 1 jump the energy book does not close within ",
    ]
