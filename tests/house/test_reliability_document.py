"""docs/reliability.md shows the figures of the last long run, and these are of as many trials as it says."""

from __future__ import annotations

import csv
import importlib.util
from pathlib import Path
from types import ModuleType

PROJECT = Path(__file__).parents[2]


def writer() -> ModuleType:
    spec = importlib.util.spec_from_file_location("reliability", PROJECT / "scripts" / "reliability_document.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_shows_the_figures_of_the_last_run() -> None:
    with (PROJECT / "docs" / "reliability.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    text = (PROJECT / "docs" / "reliability.md").read_text(encoding="utf-8")
    assert writer().with_table(text, rows) == text
    killed = sum(int(row["cut_off"]) for row in rows if row["trial"] == "kill")
    assert killed >= 1000
    assert {row["trial"] for row in rows} == {"kill", "power cut"}
    assert sum(int(row["lost"]) for row in rows) == 0
