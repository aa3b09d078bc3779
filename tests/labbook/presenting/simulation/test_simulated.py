"""What is said of a simulation: to people, to programs, and of what cannot be trusted in it."""

from __future__ import annotations

import json
import math
from dataclasses import MISSING, fields, replace
from typing import Any

import pytest

from labbook.presenting.simulation.simulated import as_data, as_lines, warnings
from simulator.changes import changed_by_words
from simulator.kernel import layout
from simulator.result import JumpResult, ModeChange, SceneResult
from simulator.scene_file import load_scene
from tests.helpers.scenes import is_sentence
from tests.helpers.wording import says

NUMBERS: dict[str, Any] = {field.name: 0.0 for field in fields(JumpResult) if field.default is MISSING}
JUMP = JumpResult(
    **NUMBERS
    | {
        "outcome": "apex",
        "liftoff_time_s": 0.3137413071234,
        "cost_J": 30.53116304,
        "apex_foot_height_m": None,
        "next_touchdown_time_s": None,
        "next_touchdown_body_velocity_m_s": None,
        "energy_at_play_J": 1.0,
        "decision_margin": math.inf,
        "decision_tick": None,
        "counters": {"guard_switch": 0},
        "mode_changes": (ModeChange(0.1, "intruding", "jammed"),),
    }
)


def result(*jumps: JumpResult, scene: str = "sim2", accuracy: float = 1e-6) -> SceneResult:
    return SceneResult(load_scene(scene), accuracy, jumps or (JUMP,), 12.5, 0.000321)


def changed(scene: str, *sets: str) -> SceneResult:
    return SceneResult(changed_by_words(load_scene(scene), sets), 1e-6, (JUMP,), 12.5, 7.1)


def test_what_was_set_is_said_and_never_called_sourced() -> None:
    lines = as_lines(changed("sim2", "b_g=16", "b_ad=33"))
    says(lines, "set by you", "b_g = 16", "33 kg")
    says(lines, "every other parameter")
    bed = changed("bed", "kg_scale=2", "body_mass=2.1", "gain=300")
    lines = as_lines(bed)
    says(lines, "2.1 kg", "835.36 N/m", "kg_scale = 2")
    assert [line.split()[0] for line in lines if line.startswith("  ") and ": " in line] == ["foot_mass"]
    data = as_data(bed)
    assert data["set_by_user"] == {"body_mass": 2.1, "k_extension": 835.36, "kg_scale": 2.0}
    assert data["assumed"].keys() == {"foot_mass"}


def test_data_is_json_without_infinities() -> None:
    data = as_data(result(JUMP, JUMP, scene="emulator"))
    text = json.dumps(data, allow_nan=False)
    back = json.loads(text)
    assert back["decision_margin"] is None
    assert back["liftoff_time_s"] == JUMP.liftoff_time_s
    assert [jump["cost_J"] for jump in back["jumps"]] == [JUMP.cost_J] * 2
    named = {"before_name": "platform yields", "after_name": "platform held"}
    assert back["mode_changes"] == [{"time_s": 0.1, "before": "intruding", "after": "jammed", **named}]
    assert [jump["mode_changes"] for jump in back["jumps"]] == [back["mode_changes"]] * 2
    assert "platform_stiffness" in back["assumed"]
    assert "sigma" not in back["values"]


@pytest.mark.parametrize("outcome", layout.OUTCOMES)
def test_every_outcome_has_its_sentence(outcome: str) -> None:
    assert f"({outcome})" in as_lines(result(replace(JUMP, outcome=outcome)))[1]


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
    says(warned(sunk), "no robot jumps", "0.2 m", "0.0123 m")
    says(warned(replace(sunk, max_depth_m=0.57)), "0.57 m", "longest leg", "0.3 m")


def test_a_cost_that_is_not_positive() -> None:
    says(warned(replace(JUMP, cost_J=-7.61)), "not positive", "-7.61 J", "net work", "+no_regeneration")
    stopped = replace(JUMP, outcome="no_liftoff", cost_J=-7.61)
    assert warnings(result(stopped)) == []  # what was braked so far


def test_a_foot_that_does_not_clear_the_surface_is_told_of() -> None:
    hole = replace(JUMP, outcome="touchdown", apex_foot_height_m=-0.281)
    lines = as_lines(result(hole))
    says(lines, "foot at the apex", "-0.281", "above the surface")
    says(lines, "note", "0.281 m below the surface", "does not clear")
    clear = as_lines(result(replace(hole, apex_foot_height_m=0.02)))
    says(clear, "foot at the apex", "0.02")
    assert not any(line.startswith("note: ") for line in clear)


def test_drag_of_geared_motors_is_told_of() -> None:
    dragged = replace(JUMP, stance_drag_J=1804.0, jump_drag_J=1804.0, energy_at_play_J=20.3)
    says(as_lines(result(dragged)), "note", "1.8e+03 J", "89 times", "--effects -drag")
    assert not any("-drag" in line for line in as_lines(result(replace(dragged, energy_at_play_J=1000.0))))


def test_each_of_several_jumps_has_a_line() -> None:
    jumps = [replace(JUMP, outcome="touchdown", apex_height_m=0.3 + 0.01 * number) for number in range(1, 31)]
    jumps[2] = replace(jumps[2], never_rose=True)
    few = as_lines(result(*jumps[:5], scene="emulator"))
    at = few.index(next(line for line in few if line.split()[:3] == ["jump", "apex", "m"]))
    assert [line.split()[:3] for line in few[at + 1 : at + 6]] == [
        [str(number), f"{0.3 + 0.01 * number:g}", "30.53116"] for number in range(1, 6)
    ]
    says(few[at + 3], "never rose")
    many = as_lines(result(*jumps, scene="emulator"))
    says(many, "20 more", "--json")
    assert any(line.split()[:2] == ["30", "0.6"] for line in many)
    assert not any(line.split()[:2] == ["15", "0.45"] for line in many)


def test_a_book_that_stays_open() -> None:
    unclosed = replace(JUMP, energy_residual_J=-2e-5, energy_at_play_J=4.0, open_book=True)
    says(warned(unclosed), "not close within", "5.0e-06", "1e-06")
