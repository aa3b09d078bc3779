from __future__ import annotations

import json
import math
from dataclasses import fields, replace
from typing import Any

import pytest

from labbook.presenting.simulation.simulated import OUTCOMES, ROWS, as_data, as_lines, warnings
from simulator.changes import changed_by_words
from simulator.effects.registry import ENERGIES
from simulator.kernel import layout
from simulator.result import JumpResult, ModeChange, SceneResult
from simulator.scene_file import load_scene
from tests.helpers.scenes import is_sentence
from tests.helpers.wording import says

ENERGIES_J: dict[str, Any] = {column: 0.0 for energy in ENERGIES for column in energy.columns}
ENERGIES_J |= {"ground_loss_J": 2.0, "grain_energy_J": 0.1, "stance_heat_J": 26.8783689, "jump_heat_J": 27.1}
JUMP = JumpResult(
    outcome="apex",
    touchdown_time_s=0.0,
    liftoff_time_s=0.3137413071234,
    max_depth_m=0.07075555,
    unresisted_sink_m=0.0,
    liftoff_body_height_m=0.19,
    liftoff_body_velocity_m_s=1.638227,
    liftoff_foot_velocity_m_s=0.0,
    apex_height_m=0.303334225,
    apex_time_s=0.44,
    next_touchdown_time_s=None,
    next_touchdown_body_velocity_m_s=None,
    stance_mechanical_J=3.65279414,
    jump_mechanical_J=3.4,
    passive_J=0.0,
    cost_J=30.53116304,
    leg_work_J=3.0,
    **ENERGIES_J,
    energy_residual_J=1e-14,
    energy_at_play_J=1.0,
    decision_margin=math.inf,
    decision_tick=None,
    error_growth=1.0,
    min_leg_length_m=0.15,
    max_leg_length_m=0.309,
    min_body_height_m=0.071,
    capped_time_s=0.02,
    counters={"guard_switch": 0},
    mode_changes=(ModeChange(0.1, "intruding", "jammed"),),
    steps=300,
    rhs_evaluations=4000,
)


def result(*jumps: JumpResult, scene: str = "sim2", accuracy: float = 1e-6) -> SceneResult:
    return SceneResult(load_scene(scene), accuracy, jumps or (JUMP,), 12.5, 0.000321)


def test_every_line_is_a_number_of_the_result() -> None:
    assert {key.format(span=span) for _, key, _ in ROWS for span in ("jump", "stance")} <= {
        item.name for item in fields(JumpResult)
    }
    assert set(layout.OUTCOMES) <= set(OUTCOMES)


def test_no_two_lines_have_the_same_name() -> None:
    names = [name for name, _, _ in ROWS]
    assert len(set(names)) == len(names)
    shown = [" ".join(line.split()) for line in as_lines(result())]
    says(shown, "height at lift-off", "0.19 m")
    says(shown, "velocity at lift-off", "1.638227 m/s")


def test_the_table_has_as_many_digits_as_the_accuracy_is_worth() -> None:
    assert any(line.split() == ["lift-off", "0.3137413", "s", "after", "touchdown"] for line in as_lines(result()))
    assert any(line.split()[:2] == ["lift-off", "0.3137413071"] for line in as_lines(result(accuracy=1e-9)))


def test_the_parts_of_the_cost_are_those_that_are_summed() -> None:
    for scene, heat in (("sim2", "26.87837"), ("emulator", "27.1")):
        assert any(line.split() == ["heat", "in", "the", "motors", heat, "J"] for line in as_lines(result(scene=scene)))


def test_what_is_absent_or_nothing_is_left_out() -> None:
    text = "\n".join(as_lines(result()))
    assert "drag" not in text
    assert "next touchdown" not in text
    never = replace(JUMP, outcome="no_liftoff", liftoff_time_s=None, apex_height_m=None)
    says(as_lines(result(never)), "no_liftoff")
    assert any(line.split()[:2] == ["lift-off", "-"] for line in as_lines(result(never)))


def test_assumed_parameters_are_named_with_their_reasons() -> None:
    says(as_lines(result()), "every parameter has")
    lines = as_lines(result(scene="bed"))
    says(lines, "on assumed parameters")
    says(lines, "kg_scale = 1.4", "0.02 m", "5.3")
    says(lines, "foot_mass", "0.2 kg")


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


def test_the_title_is_that_of_the_jump_that_was_simulated() -> None:
    lines = as_lines(changed("bed", "gain=300"))
    says(lines[0], "400", "5", "gain=300")
    assert as_data(changed("bed", "gain=300"))["title"].endswith("but with gain=300")


def test_a_jump_that_ended_otherwise_has_no_cost_of_the_jump() -> None:
    names = [line for line in as_lines(result(replace(JUMP, outcome="leg_folded"))) if line.startswith("cost")]
    assert [name.split("  ")[0] for name in names] == ["cost until it ended"]


def test_times_have_the_unit_that_suits_them() -> None:
    says(as_lines(changed("sim2", "b_ad=33"))[-1], "7.1 s", "12.5 s", "of compiling")


def test_a_knife_s_edge_is_shown_with_both_branches() -> None:
    other = replace(JUMP, apex_height_m=0.25, cost_J=31.0)
    edge = replace(JUMP, decision_margin=2.5, decision_tick=140, ill_conditioned=True, other_branch=other)
    lines = as_lines(result(edge))
    (warning,) = (line for line in lines if line.startswith("warning: "))
    assert "knife's edge" in warning
    says(warning, "140", "2.5 local", "10", "branches are shown")
    says(lines, "as decided", "fallen otherwise")
    assert any(
        line.split()[:4] == ["cost", "of", "the", "jump"] and "30.53116" in line and "31" in line for line in lines
    )
    assert as_data(result(edge))["other_branch"]["apex_height_m"] == 0.25


def test_a_knife_s_edge_whose_other_branch_was_not_simulated() -> None:
    edge = replace(JUMP, decision_margin=2.5, decision_tick=140, ill_conditioned=True)
    lines = as_lines(result(JUMP, edge, scene="emulator"))
    says(lines, "knife's edge", "only the branch")
    assert not any("otherwise" in line for line in lines if not line.startswith("warning: "))
    says(lines, "2", "100 jumps")


def test_growing_errors_are_no_knife_s_edge() -> None:
    grown = replace(JUMP, decision_margin=2.7e12, error_growth=1.24e11, ill_conditioned=True)
    lines = as_lines(result(grown))
    (warning,) = (line for line in lines if line.startswith("warning: "))
    says(warning, "1.2e+11", "rounding alone leaves", "0.012 %")
    assert any(line.split()[:2] == ["lift-off", "0.31374"] for line in lines)  # the digits that are worth showing
    lost = as_lines(result(replace(grown, error_growth=1e300)))
    says(lost, "leaves an error", "1e+02 %")


def test_what_follows_an_ill_conditioned_jump_is_known_no_better() -> None:
    edge = replace(JUMP, decision_margin=2.5, decision_tick=140, ill_conditioned=True)
    lines = as_lines(result(JUMP, edge, replace(JUMP, ill_conditioned=True), scene="emulator"))
    (warning,) = (line for line in lines if line.startswith("warning: "))
    says(warning, "2", "known no better")


def test_both_causes_are_said() -> None:
    both = replace(JUMP, decision_margin=0.5, decision_tick=3, error_growth=1e12, ill_conditioned=True)
    assert sum(line.startswith("warning: ") for line in as_lines(result(both))) == 2


def test_a_leg_beyond_its_reach_and_odd_jumps_are_noted() -> None:
    says(as_lines(result()), "0.309 m", "links reach", "0.3 m")
    counted = replace(JUMP, counters={"guard_switch": 1, "bottomed": 0}, max_leg_length_m=0.29)
    lines = as_lines(result(counted, counted, scene="emulator"))
    says(lines, "2 times", "100 jumps")
    once = replace(counted, counters={"guard_switch": 1})
    says(as_lines(result(once)), "guard switch once")


def test_of_many_jumps_the_last_is_shown_and_all_are_summed() -> None:
    last = replace(JUMP, apex_height_m=0.4, cost_J=10.0)
    lines = as_lines(result(JUMP, last, scene="emulator"))
    says(lines, "jump", "2", "100")
    says(lines, "100 jumps", "40.5312 J", "0.3033", "0.4 m")
    says(lines[-1], "600 steps", "8000 evaluations", "100 jumps", "1e-06", "321")
    plate = as_lines(result(*[JUMP] * 80, scene="force_plate"))
    says(plate, "80 jumps", "2442.49 J", "0.3033 m")
    says(plate[-1], "24000 steps", "320000 evaluations", "80 jumps")
    assert as_data(result(JUMP, last, scene="emulator"))["steps"] == JUMP.steps


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


@pytest.mark.parametrize(
    ("scene", "before", "after"),
    [("sim2", "intruding", "jammed"), ("force_plate", "intruding", "stands")],
)
def test_modes_in_data_have_the_kernel_s_names_and_those_of_their_ground(scene: str, before: str, after: str) -> None:
    branches = as_data(result(replace(JUMP, other_branch=JUMP), scene=scene))
    for branch in (branches, branches["other_branch"]):
        (change,) = branch["mode_changes"]
        assert (change["before"], change["after"]) == ("intruding", "jammed")
        assert (change["before_name"], change["after_name"]) == (before, after)


@pytest.mark.parametrize("outcome", layout.OUTCOMES)
def test_every_outcome_has_its_sentence(outcome: str) -> None:
    assert f"({outcome})." in as_lines(result(replace(JUMP, outcome=outcome)))[1]


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


def test_a_book_that_stays_open() -> None:
    unclosed = replace(JUMP, energy_residual_J=-2e-5, energy_at_play_J=4.0, open_book=True)
    says(warned(unclosed), "not close within", "5.0e-06", "1e-06")
    says(warned(replace(unclosed, repeats=5)), "5 times")


def test_finer_steps_that_are_too_many() -> None:
    line = warned(replace(JUMP, outcome="step_limit", repeats=1))
    says(line, "simulated again once", "--accuracy")
    assert warnings(result(replace(JUMP, outcome="step_limit"))) == []


def test_of_many_jumps_those_with_an_open_book_are_counted() -> None:
    unclosed = replace(JUMP, energy_residual_J=1e-5, open_book=True)
    lines = as_lines(result(unclosed, JUMP, scene="emulator"))
    says(lines, "2", "100 jumps")
