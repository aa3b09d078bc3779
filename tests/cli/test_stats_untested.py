"""Constant groups on the command line: what was tested and what was not, in words and in figures."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.shell import good, labbook

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
    assert "adjusted by Holm at 0.05: none tested, because neither group has any scatter." in none
    some = good(labbook("stats", command, written(tmp_path, PARTLY), *BY, at=tmp_path)).out
    assert ": 1 tested, none rejected; not tested: gain 2, because neither group has any scatter." in some
