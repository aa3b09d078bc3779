"""What is said of effects' worth, from results that are given."""

from __future__ import annotations

from dataclasses import replace

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.presenting.simulation.effects_ablation import (
    ablation_data,
    alone_table,
    footnotes,
    heading,
    pairs_table,
    time_lines,
    verdict,
)
from simulator.ablation.kernel_time import KernelTime
from simulator.ablation.outputs import Difference, Outputs
from simulator.ablation.smallest import LeftOut, Smallest, in_order
from simulator.ablation.study import Ablation
from simulator.scene_file import load_scene
from tests.helpers.wording import says

SCENE = load_scene("sim2")
FULL = Outputs("touchdown", 1, 30.0, 0.3, 0.07, 1000, False, 100)
FOLDED = Undefined(Reason.AS_SAID, said="leg_folded")


def left_out(
    *effects: str, cost: float = 0.0, apex: float = 0.0, folds: bool = False, flagged: bool = False
) -> LeftOut:
    changed = Difference(FOLDED, FOLDED, FOLDED) if folds else Difference(cost, apex, 0.0)
    return LeftOut(in_order(frozenset(effects)), replace(FULL, rhs_evaluations=900, ill_conditioned=flagged), changed)


ALONE = [
    left_out("motor_heat", cost=-0.88),
    left_out("leg_damping", folds=True),
    left_out("added_mass", cost=0.006, apex=0.013),
    left_out("short_leg_guard", cost=1e-9, flagged=True),
]
PAIR = left_out("added_mass", "motor_heat", cost=-0.80, apex=0.013)
GONE = left_out("added_mass", "short_leg_guard", cost=0.006, apex=0.004)
WORTH = Ablation(
    scene=SCENE,
    accuracy=1e-6,
    tolerance=0.01,
    full=FULL,
    alone={item.effects[0]: item for item in ALONE},
    needed={"hydrostatic_stiffness": "a scene without a ground has nothing to jump on."},
    pairs={("added_mass", "motor_heat"): PAIR, ("motor_heat", "added_mass"): PAIR},
    smallest=Smallest(in_order(SCENE.effects - set(GONE.effects)), GONE, GONE.effects, True),
    checked=GONE,
    searched_within=0.01,
)
TIME = KernelTime(50e-6, 12.0, 100, True)


def test_the_effect_that_changes_most_comes_first() -> None:
    head, *rows = alone_table(WORTH, {}, None)
    assert head == ["without", "cost", "apex", "depth", "evaluations", "most together with"]
    assert [row[0] for row in rows] == ["leg_damping", "motor_heat", "added_mass", "short_leg_guard*"]
    assert rows[0][1:4] == ["leg_folded"] * 3
    assert rows[2][1:5] == ["+0.6 %", "+1.3 %", "0", "-10 %"]
    says(rows[2][-1], "motor_heat", "-80 %", "-87.9 %")
    assert rows[3][1] == "0", "below the accuracy"


def test_times_without_each_effect_are_shown_where_they_were_measured() -> None:
    times = dict.fromkeys(WORTH.alone, replace(TIME, time_per_jump_s=40e-6))
    head, *rows = alone_table(WORTH, times, TIME)
    assert head[5] == "time a jump"
    assert {row[5] for row in rows} == {"-20 %"}


def test_each_pair_has_one_row() -> None:
    assert pairs_table(WORTH)[1:] == [["added_mass and motor_heat", "-80 %", "+1.3 %", "0"]]


def test_marks_and_missing_rows_are_explained() -> None:
    lines = footnotes(WORTH)
    says(lines, "* an ill-conditioned")
    says(lines, "hydrostatic_stiffness")
    assert not any(line.startswith("step_limit") for line in lines)
    slow = replace(ALONE[0], outputs=replace(FULL, outcome="step_limit"))
    lines = footnotes(replace(WORTH, alone={**WORTH.alone, "motor_heat": slow}))
    says(lines, "step_limit", "30 times")


def test_the_verdict() -> None:
    lines = verdict(WORTH)
    says(lines[0], "1 %", "10", "12 effects", "hydrostatic_stiffness", "inertial_drag")
    says(lines, "short_leg_guard", "+0.6 %", "+0.4 %", "added_mass alone")
    says(lines, "2 effects")
    assert not any("jump" in line and "In jump" in line for line in lines)


def test_what_the_verdict_warns_of() -> None:
    flagged = replace(WORTH, full=replace(FULL, ill_conditioned=True))
    assert any("is ill-conditioned" in line for line in heading(SCENE, flagged))
    assert any("is ill-conditioned" in line for line in verdict(flagged))
    greedy = replace(WORTH, smallest=replace(WORTH.smallest, exhaustive=False))
    says(verdict(greedy), "not all of")
    nothing = replace(WORTH, smallest=Smallest(in_order(SCENE.effects), left_out(), (), True))
    says(verdict(nothing), "1 %", "none of the", "No effect can")


def test_later_jumps_are_told_of() -> None:
    later = replace(GONE, outputs=replace(GONE.outputs, jumps=80))
    lines = verdict(replace(WORTH, checked=later, searched_within=0.005))
    says(lines, "80", "changes cost by", "+0.6 %", "+0.4 %")
    says(lines, "0.5 %", "because differences grow")


def test_times_are_told_in_fitting_units() -> None:
    (line,) = time_lines(TIME, replace(TIME, time_per_jump_s=5e-3))
    says(line, "50 µs", "with all effects", "5 ms", "10000 %", "compile or load", "12 s")
    assert "in plain Python" in time_lines(replace(TIME, compiled=False), TIME)[0]


def test_data_has_nothing_where_there_is_no_number() -> None:
    data = ablation_data(SCENE, WORTH)
    alone = {item["without"][0]: item for item in data["alone"]}
    assert alone["leg_damping"]["cost"] is None
    assert alone["leg_damping"]["undefined"] == "leg_folded"
    assert alone["added_mass"]["undefined"] is None
    assert len(data["pairs"]) == 1
    assert data["effects_left_out"] == ("added_mass", "short_leg_guard")
