"""`labbook sim falsify`: what is printed and drawn of boxes of one and of three parameters, and what is refused."""

from __future__ import annotations

import contextlib
import os
import subprocess
from pathlib import Path

import pytest
from PIL import Image

from tests.cli.shell import LABBOOK, environment, good, labbook, refused
from tests.helpers.wording import says

BED = ("sim", "falsify", "--scene", "bed")
SOFT = ("--over", "kg_scale=0.3:1", "--over", "bg_scale=0.03:0.1")


def test_a_box_of_one_parameter(tmp_path: Path) -> None:
    words = (*BED, "--over", "kg_scale=0.3:30", "--grounds", "16", "--plot", "one.svg")
    told = good(labbook(*words, at=tmp_path)).out
    says(told, "equal height", "b_ad = 517.67 kg/m", "none was set", "16 grounds", "kg_scale=0.3:30:log")
    assert (tmp_path / "one.svg").stat().st_size > 5_000


def test_a_box_of_three_parameters_in_which_the_claim_fails(tmp_path: Path) -> None:
    words = (*BED, *SOFT, "--over", "b_ad=300:600", "--equal", "gains", "--grounds", "32", "--plot", "three.png")
    found = good(labbook(*words, "--json", at=tmp_path)).json
    assert found["failing"] > 5 * len(found["counterexamples"]) == 25
    says_something = 32 - sum(found["verdicts"][apart] for apart in list(found["verdicts"])[3:])
    assert found["share_failing"] == found["verdicts"]["active damping costs more"] / says_something > 0.2
    low, high = found["share_failing_95"]
    assert low < found["share_failing"] <= high
    for one in found["counterexamples"]:
        assert one["ground"].keys() == {"kg_scale", "bg_scale", "b_ad"}
        assert one["cost_J"]["ad"] - one["cost_J"]["ce"] == pytest.approx(one["more_J"])
        assert one["more_J"] > one["bar_J"] + one["other_solver_J"]
        assert one["confirmed"]
    with Image.open(tmp_path / "three.png") as drawn:
        assert drawn.size[0] > 2 * drawn.size[1]


def test_a_terminal_of_80_columns_holds_what_is_told(tmp_path: Path) -> None:
    """Sentences break between words, and grounds stand side by side under their numbers in the figure."""
    words = (*BED, *SOFT, "--over", "b_ad=300:600", "--equal", "gains", "--grounds", "16")
    leader, follower = os.openpty()
    done = subprocess.run(
        [LABBOOK, *words], cwd=tmp_path, env=environment(), stdout=follower, stderr=subprocess.PIPE, check=False
    )
    os.close(follower)
    said = b""
    with contextlib.suppress(OSError), os.fdopen(leader, "rb", 0) as terminal:  # it ends with an error
        while more := terminal.read(4096):
            said += more
    lines = said.decode().splitlines()
    assert (done.returncode, done.stderr) == (0, b"")
    assert len(lines) > 15
    assert max(map(len, lines)) <= 80
    assert ["1", "2", "3", "4", "5"] in [line.split() for line in lines]
    assert ["confirmed", *["yes"] * 5] in [line.split() for line in lines]


def test_a_box_in_which_braking_gives_back_more_than_a_jump_takes(tmp_path: Path) -> None:
    words = (*BED, "--set", "motor_resistance=0.001", "--set", "initial_height=0.35", "--over", "kg_scale=0.5:5")
    told = good(labbook(*words, "--grounds", "16", "--plot", "joules.png", at=tmp_path)).out
    (sentence,) = (line for line in told.splitlines() if "not positive" in line)
    found = good(labbook(*words, "--grounds", "16", "--json", at=tmp_path)).json
    says(sentence, str(found["cost_not_positive"]), "joules")
    assert found["verdicts"]["active damping saves"] > 4
    assert found["failing"] == found["verdicts"]["active damping costs more"] == 0


def test_what_cannot_be_asked_is_refused(tmp_path: Path) -> None:
    refused(labbook(*BED, *SOFT, "--claim", "hops", at=tmp_path), 2, "hops", "saves")
    refused(labbook(*BED, *SOFT, "--plot", "grounds.txt", at=tmp_path), 2, "--plot", ".png")
    refused(labbook(*BED, *SOFT, "--plot", "none/grounds.png", at=tmp_path), 2, "--plot none/grounds.png", "make none")
    refused(labbook(*BED, *SOFT, "--equal", "cost", at=tmp_path), 2, "--equal", "'cost'", "'gains', 'height'")
    refused(labbook(*BED, "--over", "kg_scale=0.3:1:5", at=tmp_path), 2, "kg_scale", "LOW:HIGH")
    refused(labbook(*BED, "--over", "kg_scale=0.0009:1", at=tmp_path), 2, "kg_scale=0.0009:1", "0.001 to 1e+09")
    refused(labbook(*BED, *SOFT, "--effects", "-active_damping", at=tmp_path), 2, "active damping", "--effects")
