"""`labbook sim effects`."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.shell import good, labbook, refused
from tests.helpers.wording import says

PLATE = ("--scene", "force_plate", "--set", "jumps=1", "--effects", "-cost_of_whole_jump,-torque_cap")
KEYS = {
    *("scene", "effects", "accuracy", "within", "jumps_measured", "full", "alone", "stay", "smallest_set"),
    *("effects_left_out", "change"),
}


def test_data_for_programs_and_words_that_simulate_so(tmp_path: Path) -> None:
    words = ("sim", "effects", *PLATE, "--within", "2%")
    found = good(labbook(*words, "--json", at=tmp_path)).json
    assert set(found) >= KEYS
    assert found["within"] == 0.02
    alone = {item["without"][0]: item for item in found["alone"]}
    assert {*alone, *found["stay"]} == set(found["effects"])
    assert {*found["smallest_set"], *found["effects_left_out"]} == set(found["effects"])
    assert alone["leg_damping"]["cost"] is None
    assert "leg_straight" in alone["leg_damping"]["undefined"]
    shown = good(labbook(*words, at=tmp_path)).out
    says(shown, "leg_straight", "rigid_ground stays", "Within 2 %", *found["effects_left_out"])
    assert f"--effects {','.join(f'-{name}' for name in found['effects_left_out'])}" in shown


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--scene", "sim3"], "'sim3' is not a known scene: did you mean 'sim2'?"),
        (["--scene", "sim2", "--within", "much"], "is no share above 0"),
        (["--scene", "sim2", "--accuracy", "0.01"], "too fine to tell"),
        (["--scene", "sim2", "--effects", "+dragg"], "did you mean 'drag'?"),
        (["--scene", "sim2", "--set", "k_extension=100"], "ends in no_liftoff, before an apex"),
        ([], "--scene"),
    ],
)
def test_refused_with_a_sentence(words: list[str], said: str, tmp_path: Path) -> None:
    refused(labbook("sim", "effects", *words, at=tmp_path), 2, said)
