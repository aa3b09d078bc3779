"""Frames of a book have what its commands and its report say of the same runs, with units, types and reasons."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pandas as pd
import pytest

from data_schema.errors import UsageError
from labbook.actions.runs.correcting import void
from labbook.analysis.study import analyse
from labbook.export.tables import TABLES, Selection
from reports.page.writing import report_files
from tests.cli.shell import good, labbook
from tests.helpers.books import SmallBook, small_book
from tests.helpers.statements import state


@contextmanager
def selected(small: SmallBook, where: str | None = None) -> Iterator[Selection]:
    with small.open() as book, book.reading() as connection:
        yield Selection(connection, book.store, book.configuration, where)


def frame(small: SmallBook, name: str, where: str | None = None) -> pd.DataFrame:
    with selected(small, where) as selection:
        return TABLES[name](selection).frame()


def test_runs_have_the_numbers_of_the_report(book: SmallBook) -> None:
    runs = frame(book, "runs")
    with book.open() as opened, opened.reading() as connection:
        made = analyse(connection, opened.store, opened.configuration, where=None, made_at="2021-07-01T00:00:00Z")
    text = report_files(made.results)["tables/each_run.csv"].decode()
    for row in csv.DictReader(io.StringIO(text)):
        assert runs.loc[row["run"], "joules_J"] == float(row["joules_J"])
        assert runs.loc[row["run"], "apex_m"] == float(row["apex_m"])
        assert runs.loc[row["run"], "jumps_counted"] == int(row["jumps_analysed"])
    conditions = frame(book, "conditions")
    for condition in made.results.conditions:
        key = " ".join(f"{level.factor}={level.label}" for level in condition.levels)
        for outcome, summary in condition.summaries.items():
            assert conditions.loc[key, f"{outcome.key}_mean_{outcome.unit}"] == summary.mean.value
            assert conditions.loc[key, f"{outcome.key}_ci_low_{outcome.unit}"] == summary.mean.ci_low
            shared = conditions.loc[key, f"{outcome.key}_shared_se_{outcome.unit}"]
            assert shared == summary.mean.shared_se or (pd.isna(shared) and summary.mean.shared_se is None)


def test_notes_are_a_table(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    good(labbook("note", "r001", 'a "cable",\ncame loose', at=small.folder))
    notes = frame(small, "notes")
    assert list(notes.loc[["r001"], "text"])[-1] == 'a "cable",\ncame loose'
    assert set(notes["person"]) == {"Ada Nwosu"}


def test_each_column_has_its_type_and_is_described(book: SmallBook) -> None:
    runs = frame(book, "runs")
    assert runs["day"].dtype.kind == "M"
    assert str(runs["started_utc"].dt.tz) == "UTC"
    assert runs["jumps_made"].dtype == "Int64"
    assert runs["is_control"].dtype == "boolean"
    assert runs["b_ad_gain"].dtype == "float64"
    with selected(book) as selection:
        for name, make in TABLES.items():
            table = make(selection)
            found = table.frame()
            assert [*found.index.names, *found.columns] == list(table.columns), name
            assert set(found.attrs["columns"]) == set(table.columns)
            for column, about in table.columns.items():
                values = found.reset_index()[column]
                assert about.missing or not values.isna().any(), (name, column)
                assert about.source, (name, column)


def test_what_is_missing_has_its_reason(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    good(labbook("files", "withdraw", "r003.csv", "--why", "a copy", at=small.folder))
    with small.open() as book:
        state(book, void, "r002", "a slip")
    runs = frame(small, "runs")
    assert pd.isna(runs.loc["r003", "apex_m"])
    assert "log" in runs.loc["r003", "why_no_apex"]
    assert pd.isna(runs.loc["r001", "why_no_apex"])
    assert "void" in runs.loc["r002", "why_no_joules"]
    assert runs.loc["r002", "why_void"] == "a slip"
    idle = runs[runs["kind"] == "idle"]
    assert idle["why_no_joules"].str.contains("idle").all()
    assert runs["why_void"].isna().sum() == len(runs) - 1
    assert pd.isna(runs.loc["r003", "jumps_found"])


def test_jumps_say_which_count_and_by_whose_verdict(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    good(labbook("jumps", "reject", "r001", "2", "--reason", "misfire", at=small.folder))
    listed = good(labbook("jumps", "list", "r001", "--json", at=small.folder)).json["jumps"]
    jumps = frame(small, "jumps").loc["r001"]
    assert list(jumps.index) == [one["jump"]["number"] for one in listed]
    assert list(jumps["apex_height_m"]) == [one["jump"]["apex_height_m"] for one in listed]
    assert [not counted for counted in jumps["counted"]] == [one["excluded"] is not None for one in listed]
    assert tuple(jumps.loc[2, ["verdict", "reason", "person"]]) == ("reject", "misfire", "Ada Nwosu")


def test_a_selection_has_its_runs_alone(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    names = set(frame(small, "runs", "b_ad_gain=0").index)
    assert 0 < len(names) < len(frame(small, "runs"))
    for name in ("jumps", "charges", "signals"):
        found = frame(small, name, "b_ad_gain=0")
        assert set(found.index.get_level_values("run")) <= names
        assert len(found) < len(frame(small, name))
    with pytest.raises(UsageError, match="b_ad_gain"):
        frame(small, "runs", "b_ad_gain=7")
