"""What is said of a jump that no robot makes, or that finer steps have not mended."""

from __future__ import annotations

from dataclasses import replace

from labbook.presenting.simulation.simulated import as_lines, warnings
from simulator.result import JumpResult
from tests.helpers.scenes import is_sentence
from tests.labbook.presenting.simulation.test_simulated import JUMP, result


def warned(jump: JumpResult, accuracy: float = 1e-6) -> str:
    (line,) = warnings(result(jump, accuracy=accuracy))
    assert is_sentence(line)
    assert as_lines(result(jump, accuracy=accuracy))[2] == line, "before the numbers"
    return line


def test_an_ordinary_jump_is_not_warned_of() -> None:
    assert warnings(result()) == []
    assert warnings(result(replace(JUMP, repeats=2))) == []


def test_a_body_under_the_surface() -> None:
    sunk = replace(JUMP, max_depth_m=0.2, min_body_height_m=-0.0123, under_surface=True)
    assert warned(sunk) == (
        "warning: no robot jumps like this. The foot sinks 0.2 m, and the body gets 0.0123 m under the surface of the "
        "grains, which act on the foot alone: give a larger foot or firmer grains."
    )
    assert "The foot sinks 0.57 m, deeper than the longest leg (0.3 m), and the body" in warned(
        replace(sunk, max_depth_m=0.57)
    )


def test_a_book_that_stays_open() -> None:
    unclosed = replace(JUMP, energy_residual_J=-2e-5, energy_at_play_J=4.0, open_book=True)
    assert warned(unclosed) == (
        "warning: the energy book of this jump does not close within the accuracy. It is off by 5.0e-06 of what it "
        "turns over, where 1e-06 was asked for, and so may be the other numbers."
    )
    assert "accuracy, though it was simulated again 5 times with finer steps. It" in warned(
        replace(unclosed, repeats=5)
    )


def test_finer_steps_that_are_too_many() -> None:
    line = warned(replace(JUMP, outcome="step_limit", repeats=1))
    assert line.startswith("warning: the scene was simulated again once with finer steps, since errors grow in it or ")
    assert line.endswith("did not close within the accuracy, and they are too many: ask for a coarser --accuracy.")
    assert warnings(result(replace(JUMP, outcome="step_limit"))) == []


def test_of_many_jumps_those_with_an_open_book_are_counted() -> None:
    unclosed = replace(JUMP, energy_residual_J=1e-5, open_book=True)
    lines = as_lines(result(unclosed, JUMP, scene="emulator"))
    assert any(line.startswith("2 of 100 jumps, 1 with an energy book that does not close: ") for line in lines)
