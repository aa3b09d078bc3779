"""Constant groups on the command line: what was tested and what was not, in words and in figures."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.cli.shell import good, labbook
from tests.helpers.wording import says

BY = ("--value", "energy_J", "--by", "gain")
CONSTANT = "1,40\n1,40\n2,40\n2,40\n3,41\n3,41\n"
PARTLY = "1,40\n1,40\n2,40\n2,40\n3,41\n3,41.5\n"


def written(folder: Path, rows: str) -> Path:
    path = folder / "data.csv"
    path.write_text(f"gain,energy_J\n{rows}", encoding="utf-8")
    return path


@pytest.mark.parametrize("command", ["compare", "anova"])
def test_a_family_without_tests_does_not_say_that_none_was_rejected(command: str, tmp_path: Path) -> None:
    none = good(labbook("stats", command, written(tmp_path, CONSTANT), *BY, at=tmp_path)).out
    assert "none rejected" not in none
    says(none, "0.05", "because neither group")
    some = good(labbook("stats", command, written(tmp_path, PARTLY), *BY, at=tmp_path)).out
    says(some, "1 tested", "2")


@pytest.mark.parametrize(
    ("command", "rows"), [("compare", CONSTANT), ("anova", CONSTANT), ("blocked", "1,40\n1,41\n2,42\n2,42.4\n")]
)
def test_an_interval_that_is_not_there_is_not_named_in_the_figure(command: str, rows: str, tmp_path: Path) -> None:
    path = tmp_path / "data.csv"
    days = [f"{line},{'a' if line.startswith('1') else 'b'}" for line in rows.splitlines()]
    path.write_text("\n".join(["gain,energy_J,day", *days]) + "\n", encoding="utf-8")
    good(labbook("stats", command, path, *BY, "--day", "day", "--plot", tmp_path / "plot.svg", at=tmp_path))
    said = re.findall("<!-- (.*?) -->", (tmp_path / "plot.svg").read_text(encoding="utf-8"), re.DOTALL)
    assert "no interval" in said
    assert any("line: mean" in text for text in said)
    assert not [text for text in said if "Interval:" in text or "%" in text]


def test_residuals_without_scatter_are_told_in_words(tmp_path: Path) -> None:
    files = ("--qq", tmp_path / "qq.svg", "--residuals", tmp_path / "residuals.svg")
    good(labbook("stats", "anova", written(tmp_path, CONSTANT), *BY, *files, at=tmp_path))
    for name in ("qq.svg", "residuals.svg"):
        assert "Nothing to draw" in (tmp_path / name).read_text(encoding="utf-8")
