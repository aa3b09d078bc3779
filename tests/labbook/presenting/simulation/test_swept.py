"""What is said of a finished sweep, and of a chosen set of effects at its corners."""

from __future__ import annotations

from pathlib import Path

from labbook.presenting.simulation.swept import corners_data, corners_lines, sweep_data, sweep_lines
from simulator.ablation.corners import Corner, Corners
from simulator.ablation.outputs import Difference
from simulator.sweep.outputs import FLAGS
from simulator.sweep.run import Finished, Summary
from tests.helpers.scenes import is_sentence
from tests.helpers.sweeps import sobol_sweep
from tests.helpers.wording import says
from tests.labbook.presenting.simulation.test_effects_ablation import FOLDED, WORTH

SWEEP = sobol_sweep(300)
NONE = dict.fromkeys(FLAGS, 0)
SUMMARY = Summary({"touchdown": 300}, NONE)


def test_a_sweep_that_went_on_says_how_many_jumps_were_there() -> None:
    done = Finished(Path("a.nc"), SWEEP, SUMMARY, 2, 44, compile_time_s=1.0, compute_time_s=44 * 5.16e-3)
    assert SWEEP.chunks.bounds(2) == (256, 300)
    how = sweep_lines(done)[-2]
    says(how, "227 ms", "5.16 ms", "a relative error", "0.001", "256", "300 jumps")
    assert sweep_data(done)["jump_time_us"] == 1e6 * done.compute_time_s / 44


def test_a_whole_one_says_nothing_of_before_and_times_in_microseconds() -> None:
    done = Finished(Path("a.nc"), SWEEP, SUMMARY, 0, 300, compile_time_s=1.0, compute_time_s=300 * 51.6e-6)
    says(sweep_lines(done)[-2], "15.5 ms", "51.6 µs", "a jump")
    assert "before" not in sweep_lines(done)[-2]


def test_it_says_which_kernel_took_the_scenes_and_why() -> None:
    in_lanes = Finished(Path("a.nc"), SWEEP, SUMMARY, 0, 300, compute_time_s=1.0)
    says(sweep_lines(in_lanes)[-2], "in lanes")
    assert sweep_data(in_lanes)["in_lanes"] is True
    scalar = Finished(Path("a.nc"), SWEEP, SUMMARY, 0, 300, compute_time_s=1.0, why_scalar="rail_friction has no lanes")
    says(sweep_lines(scalar)[-2], "one after the other", "rail_friction")
    assert sweep_data(scalar)["in_lanes"] is False


def test_nothing_was_left() -> None:
    done = Finished(Path("a.nc"), SWEEP, SUMMARY, SWEEP.chunks.count)
    says(sweep_lines(done), "nothing was left")
    assert sweep_data(done)["jump_time_us"] is None


def test_only_jumps_that_were_made_are_counted() -> None:
    some = Summary({"refused": 290, "not_made": 9, "touchdown": 1}, NONE)
    done = Finished(Path("a.nc"), SWEEP, some, 0, 1, compute_time_s=1e-3)
    assert sweep_data(done)["jumps"] == 1
    assert sweep_data(done)["jump_time_us"] == 1000.0
    says(sweep_lines(done)[0], "1 jump")


def test_jumps_that_are_not_to_be_trusted_are_warned_of() -> None:
    assert not any(line.startswith("warning") for line in sweep_lines(Finished(Path("a.nc"), SWEEP, SUMMARY, 0)))
    flagged = Summary({"touchdown": 300}, {"ill_conditioned": 0, "under_surface": 2, "open_book": 1})
    lines = sweep_lines(Finished(Path("a.nc"), SWEEP, flagged, 0))
    under, unclosed = (line for line in lines if line.startswith("warning: "))
    says(under, "2 jumps", "under the surface")
    says(unclosed, "1 jump", "not close")


NEAR = Corner({"b_ad": 0.0, "gain": 300.0}, Difference(0.001, -0.002, 0.0))
FAR = Corner({"b_ad": 300.0, "gain": 600.0}, Difference(0.012, -0.002, 0.0))
FOLDS = Corner({"b_ad": 300.0, "gain": 900.0}, Difference(FOLDED, FOLDED, FOLDED))


def said(*corners: Corner, refused: int = 0) -> str:
    (line,) = corners_lines(Corners(corners, refused), WORTH)
    assert is_sentence(line) or "at no corner" in line
    return line


def test_within_the_tolerance() -> None:
    says(said(NEAR, NEAR), "2 corners", "b_ad", "gain = 300", "+0.1 %", "-0.2 %")


def test_beyond_the_tolerance_is_a_warning_with_what_to_do() -> None:
    line = said(NEAR, FAR, refused=1)
    says(line, "1 %", "2 corners", "1 more", "b_ad", "300")
    ends = "gain = 900: there the jump ends otherwise than with all effects (leg_folded). Sweep less far, give"
    assert ends in said(FAR, FOLDS)


def test_no_corner_and_no_set() -> None:
    says(said(refused=4), "effects be simulated")
    assert corners_lines(None, WORTH) == corners_lines(Corners((), 0), None) == []
    assert corners_data(None, WORTH) == {}


def test_data() -> None:
    found = corners_data(Corners((NEAR, FAR), 1), WORTH)["corners"]
    assert found == {
        "compared": 2,
        "refused": 1,
        "worst": {"at": dict(FAR.at), "cost": 0.012, "apex": -0.002, "depth": 0.0, "undefined": None},
        "within": False,
    }
    folded = corners_data(Corners((FOLDS,), 0), WORTH)["corners"]["worst"]
    assert (folded["cost"], folded["undefined"]) == (None, "leg_folded")
    nothing = corners_data(Corners((), 4), WORTH)["corners"]
    assert (nothing["worst"], nothing["within"]) == (None, False)
