"""Groups that are numbers stand by size in every command of `labbook stats`: 9 before 10."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from tests.cli.shell import good, labbook

BY = ("--value", "energy_J", "--by", "gain", "--day", "day")
OTHERS = ["gain 2", "gain 9", "gain 10"]


def table(folder: Path) -> Path:
    rows = [
        f"{gain},{40 + 0.3 * int(gain) + 0.7 * day + 0.1 * (day * int(gain) % 7)},{day}"
        for gain in ("10", "9", "2", "1")
        for day in range(4)
        for _turn in range(2)
    ]
    path = folder / "data.csv"
    path.write_text("\n".join(["gain,energy_J,day", *rows]) + "\n", encoding="utf-8")
    return path


def found(path: Path, command: str) -> Any:
    return good(labbook("stats", command, path, *BY, "--json", at=path.parent)).json


def test_all_commands_have_one_order(tmp_path: Path) -> None:
    path = table(tmp_path)
    assert [one["a"] for one in found(path, "compare")["comparisons"]] == OTHERS
    assert [one["treatment"] for one in found(path, "anova")["dunnett"]["comparisons"]] == OTHERS
    blocked = found(path, "blocked")["blocked"]
    assert [one["condition"] for one in blocked["conditions"]] == ["gain 1", *OTHERS]
    for contrasts in (blocked["contrasts"], blocked["exact"]["contrasts"]):
        assert [one["condition"] for one in contrasts] == OTHERS
    said = good(labbook("stats", "blocked", path, *BY, at=tmp_path)).out.splitlines()[0]
    places = [said.index(f"{name} minus gain 1") for name in OTHERS]
    assert places == sorted(places)
