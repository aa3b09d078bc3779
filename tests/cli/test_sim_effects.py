"""`labbook sim effects` and `--effects auto`: kernels are left uncompiled here, which changes no number."""

from __future__ import annotations

import itertools
import os
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from simulator.scene_file import load_scene, write_scene
from tests.cli.shell import Answer, environment, good, labbook, refused
from tests.helpers.kernels import interpreted

KEYS = {
    *("scene", "effects", "accuracy", "within", "jumps_measured", "full", "alone", "pairs", "stay", "smallest_set"),
    *("effects_left_out", "change", "candidates", "exhaustive", "times", "checked", "searched_within"),
}
OFF = "-cost_of_whole_jump,-torque_cap"
PLATE = ("--scene", "force_plate", "--set", "jumps=12", "--effects", OFF)
SWEEP = ("--scene", "sim2", "--over", "b_ad=0,1", "--out", "a.nc")


@pytest.fixture(autouse=True)
def _nothing_is_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_DISABLE_JIT", "1")


def uncompiled(*words: str, at: Path) -> Answer:
    """Give a command in the process in which nothing is compiled: to start one for each takes seconds."""
    return interpreted(given, words, at)


def given(words: tuple[str, ...], at: Path) -> Answer:
    os.environ.update(environment())
    return labbook(*words, at=at)


def after_its_announcement(answer: Answer) -> Answer:
    """What a command gave back after the line that says what it will do."""
    first, _, rest = answer.err.partition("\n")
    assert re.fullmatch(r"simulating without \d+ sets of effects, then compiling 2 kernels to time them: .*\.", first)
    return replace(answer, err=rest)


def test_data_for_programs(tmp_path: Path) -> None:
    found = good(uncompiled("sim", "effects", *PLATE, "--within", "2%", "--timings", "--json", at=tmp_path)).json
    assert set(found) >= KEYS
    assert found["within"] == 0.02
    assert found["jumps_measured"] == 10
    alone = {item["without"][0]: item for item in found["alone"]}
    assert {*alone, *found["stay"]} == set(found["effects"])
    assert {*found["smallest_set"], *found["effects_left_out"]} == set(found["effects"])
    assert found["checked"].pop("jumps") == 12
    assert all(abs(change) <= 0.02 for change in (*found["change"].values(), *found["checked"].values()))
    assert -1.0 < alone["motor_heat"]["cost"] < -0.9
    assert alone["leg_damping"]["cost"] is None
    assert alone["leg_damping"]["undefined"] == "leg_straight in jump 1"
    pairs = {frozenset(item["without"]) for item in found["pairs"]}
    assert len(pairs) == len(found["pairs"])
    assert pairs <= {frozenset(pair) for pair in itertools.combinations(alone, 2)}
    assert set(found["times"]["without"]) == set(alone)
    assert found["times"]["full"]["time_per_jump_s"] > 0.0
    assert not found["times"]["full"]["compiled"]


def test_tables_and_sentences_for_people(tmp_path: Path) -> None:
    answer = uncompiled("sim", "effects", *PLATE, "--within", "2%", "--pairs", at=tmp_path)
    assert answer.err.startswith("simulating without 15 sets of effects, then compiling 2 kernels ")
    shown = good(after_its_announcement(answer)).out
    for said in (
        "All 7 effects, jump 10 of 12: cost ",
        "leg_straight in jump 1",
        "rigid_ground stays: a scene without a ground has nothing to jump on",
        "Within 2 % in jump 10, ",
        "Left out: short_leg_guard, drag; that changes cost by -",
        "All sets were tried of the ",
        "In jump 12 that changes cost by -",
        "A jump takes in plain Python (NUMBA_DISABLE_JIT is set) ",
        "motor_heat and drag",
    ):
        assert said in shown, said


def test_a_run_with_only_the_effects_that_matter(tmp_path: Path) -> None:
    words = ("--scene", "force_plate", "--set", "jumps=1", "--json")
    found = good(uncompiled("sim", "run", *words, "--effects", f"auto,{OFF}", "--within", "2%", at=tmp_path)).json
    assert found["effects_left_out"] == ["short_leg_guard", "drag"]
    assert set(found["effects"]) == set(found["smallest_set"])
    by_hand = good(uncompiled("sim", "run", *words, "--effects", f"{OFF},-short_leg_guard,-drag", at=tmp_path)).json
    assert found["jumps"] == by_hand["jumps"]
    assert by_hand["effects_left_out"] == []


def test_what_a_run_says_of_the_effects_it_left_out(tmp_path: Path) -> None:
    lean = load_scene("force_plate").changed(effects_off=["cost_of_whole_jump", "torque_cap"], jumps=1)
    (tmp_path / "lean.toml").write_text(write_scene(lean), encoding="utf-8")
    shown = good(
        uncompiled("sim", "run", "--scene", "lean.toml", "--effects", "auto", "--within", "2%", at=tmp_path)
    ).out
    assert "Within 2 %, 5 of 7 effects are enough: rigid_ground, " in shown
    assert "Left out: short_leg_guard, drag; that changes cost by -" in shown


def test_a_sweep_with_only_the_effects_that_matter_keeps_those_that_read_what_is_swept(tmp_path: Path) -> None:
    def swept(out: str, over: str, effects: str, *more: str) -> Any:
        words = ("--scene", "force_plate", "--set", "jumps=1", "--over", over, "--effects", effects, "--out", out)
        return good(uncompiled("sim", "sweep", *words, *more, at=tmp_path))

    found = swept("auto.nc", "gain=300,310", f"auto,{OFF}", "--within", "2%", "--json").json
    assert found["effects_left_out"] == ["short_leg_guard", "drag"]
    assert found["corners"]["compared"] == 2
    assert found["corners"]["worst"]["at"]["gain"] in (300.0, 310.0)
    assert found["corners"]["within"]
    by_hand = swept("hand.nc", "gain=300,310", f"{OFF},-short_leg_guard,-drag", "--json").json
    assert by_hand["effects_left_out"] == []
    assert (tmp_path / "auto.nc").read_bytes() == (tmp_path / "hand.nc").read_bytes()
    shown = swept("drag.nc", "velocity_constant=0.03,0.04", f"auto,{OFF}", "--within", "2%").out
    assert "chosen for the scene as it stands, before anything is swept:\nWithin 2 %, 6 of 7 effects are" in shown
    assert "Left out: short_leg_guard; that changes" in shown
    assert "Of 2 corners of what is swept, the set is farthest off at velocity_constant = 0.0" in shown


def test_a_sweep_that_goes_too_far_for_its_effects_is_warned_of(tmp_path: Path) -> None:
    words = ("--scene", "force_plate", "--set", "jumps=1", "--effects", f"auto,{OFF}", "--within", "2%")
    over = ("--over", "gain=300,600", "--over", "initial_height=0,0.45")
    shown = good(uncompiled("sim", "sweep", *words, *over, "--out", "far.nc", at=tmp_path)).out
    assert "Left out: short_leg_guard, drag; that changes" in shown
    start = "warning: the chosen set of effects does not stay within 2 % in all of this sweep. Of 4 corners of what is "
    (line,) = [line for line in shown.splitlines() if line.startswith(start)]
    assert "farthest off at gain = 300, initial_height = 0.45: there it changes cost by -" in line
    assert line.endswith("depth by 0. Sweep less far, give a smaller --within, or name the effects instead of auto.")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["effects", "--scene", "sim3"], "'sim3' is not a known scene: did you mean 'sim2'?"),
        (["effects", "--scene", "sim2", "--within", "1"], "--within 1 does not say of what: write --within 1%"),
        (["effects", "--scene", "sim2", "--within", "much"], "is not a share above 0"),
        (["effects", "--scene", "sim2", "--accuracy", "0"], "an accuracy of 0 cannot be had"),
        (["effects", "--scene", "sim2", "--accuracy", "0.01"], "too fine to tell"),
        (["effects", "--scene", "sim2", "--effects", "auto"], "leave auto out of --effects"),
        (["effects", "--scene", "sim2", "--effects", "+dragg"], "did you mean 'drag'?"),
        (["effects"], "--scene"),
        (["run", "--scene", "sim2", "--effects", "auto"], "add --within"),
        (["run", "--scene", "sim2", "--within", "1%"], "add --effects auto"),
        (["run", "--scene", "sim2", "--effects", "+drag", "--within", "1%"], "add --effects auto"),
        (["run", "--scene", "sim2", "--effects", "auto", "--within", "0"], "is not a share above 0"),
        (["sweep", *SWEEP, "--effects", "auto"], "add --within"),
        (["sweep", *SWEEP, "--within", "1%"], "add --effects auto"),
        (["accuracy", "--scene", "sim2", "--effects", "auto"], "is for labbook sim run and sim sweep"),
    ],
)
def test_refused_with_a_sentence(words: list[str], said: str, tmp_path: Path) -> None:
    refused(labbook("sim", *words, at=tmp_path), 2, said)


def test_a_scene_that_does_not_jump_is_refused(tmp_path: Path) -> None:
    answer = labbook("sim", "effects", "--scene", "sim2", "--set", "k_extension=100", at=tmp_path)
    refused(after_its_announcement(answer), 2, "ends in no_liftoff, before an apex")
