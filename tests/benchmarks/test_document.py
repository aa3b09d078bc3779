"""A benchmark that is run alone replaces its own section of docs/performance.md and its budgets, and nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks import machine, run
from benchmarks.document import document, section_text
from benchmarks.registry import BENCHMARKS
from benchmarks.section import Benchmark, Budget, Section, Table
from tests.helpers.wording import says

NAMES = ("lists", "ingest")
ON = "Measured on 2021-06-01, load at its start 0.3: 2 cores."


def section(title: str, measured: float | None) -> Section:
    budgets = (
        Budget("a run (`runs list`, min): all", 2.0, "s", measured, why="not told by this system"),
        Budget("peer over it", 500.0, "×", 3.0, at_least=True),
    )
    return Section(title, "How.", budgets, (Table(("what", "s"), (("it", "1"),), "What it shows."),))


def test_one_section_is_replaced_and_the_others_stay() -> None:
    lists, ingest = section_text(section("Lists", 1.0), ON), section_text(section("Ingest", 1.5), ON)
    before = document("", {"ingest": ingest, "lists": lists}, NAMES)
    assert before.index(lists) < before.index(ingest)
    says(before, "4 budgets", "2 missed")
    anew = section_text(section("Lists of more", 2.5), "Measured on 2021-06-02.")
    after = document(before, {"lists": anew}, NAMES)
    assert after == document("", {"lists": anew, "ingest": ingest}, NAMES)
    assert lists not in after
    says(after, "4 budgets", "3 missed")
    row = "| a run (`runs list`, min): all | at most 2 s    | 2.5 s    | missed  |"
    assert row in after


def test_a_section_whose_name_has_a_number_behind_it_stays() -> None:
    names = ("lists", "lists-10000")
    texts = {name: section_text(section(name, 1.0), ON) for name in names}
    assert document(document("", texts, names), {"lists": texts["lists"]}, names) == document("", texts, names)


def test_a_budget_that_was_not_measured_says_why() -> None:
    text = document("", {"lists": section_text(section("Lists", None), ON)}, NAMES)
    says(text, "2 budgets", "1 missed")
    says(text, "not measured |")


def test_what_has_no_benchmark_any_more_goes() -> None:
    gone = document("", {"gone": section_text(section("Gone", 1.0), ON)}, ["gone"])
    assert "## Gone" in gone
    assert "## Gone" not in document(gone, {}, NAMES)


def test_a_named_benchmark_writes_its_section(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "performance.md"
    path.write_text(run.DOCUMENT.read_text(encoding="utf-8"), encoding="utf-8")
    monkeypatch.setattr(run, "DOCUMENT", path)
    monkeypatch.setitem(BENCHMARKS, "starting", Benchmark("starting", lambda _say: section("Another", 1.0)))
    run.main(["starting"])
    text = path.read_text(encoding="utf-8")
    assert "## Another\n\nMeasured" in text
    assert machine.measured_on().rpartition(": ")[2].split(", ")[1] in text
    assert "## Starting\n" in text


def test_the_document_is_as_it_would_be_written() -> None:
    text = run.DOCUMENT.read_text(encoding="utf-8")
    assert document(text, {}, BENCHMARKS) == text
