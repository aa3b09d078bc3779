"""A file's bytes are kept for good; how they are read is a statement, and can be made again."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from data_schema.errors import UsageError
from data_schema.queries.imported_files import find_files, inbox
from data_schema.queries.readings import last_reading, parts_of_reading, readings_of
from data_schema.queries.reports import list_reports
from data_schema.queries.signals import signals_of_runs
from data_schema.vocabulary import Action, IngestStatus
from labbook.actions.files.assigning import assign
from labbook.actions.files.ingesting import FileOutcome, IngestRequest, ingest_file
from labbook.actions.files.rereading import RereadRequest
from labbook.actions.files.stored_files import files_to_reread, reread_named
from labbook.actions.upkeep.tracing import find_number, trace
from labbook.book.opening import Book
from labbook.book.rebuilding import rebuild_database
from labbook.book.report_numbers import read_numbers
from tests.helpers.books import ADA, SmallBook, reported_book, small_book
from tests.helpers.databases import all_rows_by_name
from tests.helpers.statements import said_alike
from tests.helpers.wording import refuses, says

MM = {"columns": {"z": {"channel": "body_height", "unit": "mm"}}}


def home_made(small: SmallBook, run: str = "r001") -> bytes:
    """The log of a run as a home-made logger would write it: its own column names, no unit of the height."""
    lines = small.log(run).read_text().splitlines()
    height = lines[0].split(",").index("body_height [m]")
    rows = [(line.split(",")[0], float(line.split(",")[height])) for line in lines[1:]]
    return "".join(["t [ms],z\n", *(f"{t},{1000 * z:.4f}\n" for t, z in rows)]).encode()


def take(book: Book, path: Path, options: object = None, run: str | None = None, **more: object) -> FileOutcome:
    return ingest_file(book, path, IngestRequest(run=run, options=options, person=ADA, **more))  # type: ignore[arg-type]


@pytest.fixture
def home(tmp_path: Path) -> tuple[SmallBook, Path]:
    """A book with runs, and a log that its reader reads without knowing what the column is."""
    small = small_book(tmp_path, ingested=False)
    path = tmp_path / "LOG001.csv"
    path.write_bytes(home_made(small))
    return small, path


def rebuilt_alike(small: SmallBook) -> None:
    with small.open() as book:
        before = all_rows_by_name(book.engine)
    rebuild_database(small.folder, lambda _step: None)
    with small.open() as book:
        assert all_rows_by_name(book.engine) == before


def test_a_log_that_came_in_with_nothing_declared_is_mended_in_its_book(home: tuple[SmallBook, Path]) -> None:
    """The old answer: "imported before", the flags ignored, exit 0, and a new book as the only way out."""
    small, path = home
    with small.open() as book:
        first = take(book, path, run="r001")
        assert first.read is not None
        assert [channel.name for channel in first.read.parts[0].channels] == ["z"]
        again = take(book, path, MM)
        assert again.status is IngestStatus.DUPLICATE
        assert again.changes is not None
        says(again.changes, "body_height", "[m]")
        assert any("3 jumps found" in text for text in again.changes)
        with book.reading() as connection:
            row = last_reading(connection, first.sha256)
            assert row is not None
            (part,) = parts_of_reading(connection, row.uid)
            assert part.channels == (("body_height", "m"),)
        assert take(book, path, MM).changes is None  # the same declared again is no other reading
        assert take(book, path).changes is None  # nothing declared changes nothing
        entries = [entry for entry in said_alike(book) if entry.action is Action.READ]
        assert [entry.new["settings"]["declared"]["columns"]["z"]["unit"] for entry in entries if entry.new] == ["mm"]
    rebuilt_alike(small)


def test_a_reading_needs_no_labbook_toml(home: tuple[SmallBook, Path]) -> None:
    """The profile that read a file stands in the journal, whatever becomes of labbook.toml."""
    small, path = home
    toml = small.toml.read_text()
    profile = '\n[profiles.bench]\nrecognise = ["t", "z"]\ncolumns = { z = { channel = "body_height", unit = "mm" } }\n'
    small.toml.write_text(toml + profile)
    with small.open() as book:
        first = take(book, path, run="r001")
    small.toml.write_text(toml + profile.replace('"mm"', '"mm", sign = -1') + "no_robot_check = true\n")
    with small.open() as book:
        (line,) = take(book, path).messages
        says(line, "labbook files reread --all")
        (row,) = files_to_reread(book, lambda _name: None)
        mended = reread_named(book, row.name, RereadRequest({}, ADA, "it hangs upside down"))
        says(mended.changes, "values differ", "0 jumps", "was 3")
        assert files_to_reread(book, lambda _name: None) == []
        assert take(book, path, MM).changes is not None
    small.toml.write_text(toml)
    with small.open() as book, book.reading() as connection:
        kept = json.loads(readings_of(connection, first.sha256)[0].settings_json or "")
        (used,) = kept["declared"]["profiles"]
        assert used["columns"]["z"]["unit"] == "mm"
    rebuilt_alike(small)


def test_a_new_reading_that_is_refused_changes_nothing(home: tuple[SmallBook, Path]) -> None:
    small, path = home
    with small.open() as book:
        take(book, path, MM, run="r001")
        before = all_rows_by_name(book.engine)
        wrong = {"columns": {"z": {"channel": "body_height", "unit": "parsec-ish"}}}
        outcome = take(book, path, wrong)
        assert outcome.status is IngestStatus.REFUSED
        after = all_rows_by_name(book.engine)
        for table in ("signal", "channel", "run_file", "charge", "jump"):
            assert after[table] == before[table]
        with book.reading() as connection:
            row = last_reading(connection, outcome.sha256)
            assert row is not None
            assert json.loads(row.options_json) == MM
    rebuilt_alike(small)


@pytest.mark.parametrize("every", [23, pytest.param(1, marks=pytest.mark.soak)])
def test_a_reading_that_gives_other_samples_names_the_report_and_its_ids_still_answer(
    tmp_path: Path, every: int
) -> None:
    small = reported_book(tmp_path)
    with small.open() as book:
        with book.reading() as connection:
            (report,) = list_reports(connection)
            shown = read_numbers(book.store.root, report).numbers
        columns = {"body_height [m]": {"channel": "body_height", "unit": "m", "sign": -1}}
        again = take(book, small.log("r001"), {"columns": columns, "no_robot_check": True})
        assert again.changes is not None
        says(again.messages, f"report {report.called}")
        with book.reading() as connection:
            for uid in sorted(shown)[::every]:
                found = trace(connection, find_number(book, connection, uid))
                assert (found.number, found.shown_in) == (shown[uid], (report,))
    rebuilt_alike(small)


def test_a_reading_that_gives_the_same_names_no_report(tmp_path: Path) -> None:
    small = reported_book(tmp_path)
    sheet = next((small.instruments / "charger").glob("*.csv"))
    with small.open() as book:
        for path, column in ((small.log("r001"), "body_height [m]"), (sheet, "mAh")):
            said = {"channel": "charge", "unit": "mAh"} if column == "mAh" else {"channel": "body_height", "unit": "m"}
            again = take(book, path, {"columns": {column: said}})
            says(again.changes, "nothing comes out")
            assert "report" not in " ".join(again.messages)


def test_a_dry_run_says_what_would_change_and_changes_nothing(home: tuple[SmallBook, Path]) -> None:
    small, path = home
    with small.open() as book:
        take(book, path, run="r001")
        before, kept = all_rows_by_name(book.engine), sorted(small.folder.rglob("*.parquet"))
        outcome = take(book, path, MM, dry_run=True)
        assert any("body_height" in text for text in outcome.changes or ())
        assert all_rows_by_name(book.engine) == before
        assert sorted(small.folder.rglob("*.parquet")) == kept


def test_parts_of_a_file_are_given_to_runs_one_by_one(tmp_path: Path) -> None:
    """A logger that was started twice without a new file: the clock begins again, and each part is another run's."""
    small = small_book(tmp_path, ingested=False)
    first, second = (small.log(run).read_bytes() for run in ("r001", "r002"))
    path = tmp_path / "both.csv"
    path.write_bytes(first + second.split(b"\n", 1)[1])
    with small.open() as book:
        take(book, path)
        with book.reading() as connection:
            row = last_reading(connection, find_files(connection, "both.csv")[0].sha256)
            assert row is not None
            names = [part.part for part in parts_of_reading(connection, row.uid)]
        assert len(names) == 2
        for part, run in zip(names, ("r001", "r002"), strict=True):
            with book.session(ADA) as session:
                assign(session, f"both.csv#{part}", run, None)
            with book.reading() as connection:
                loose = [item.name for item in inbox(connection)]
            assert loose == ([f"both.csv#{names[1]}"] if run == "r001" else [])
        with book.reading() as connection:
            assert {item.run_name: item.n_samples for item in signals_of_runs(connection)} == {
                "r001": first.count(b"\n") - 1,
                "r002": second.count(b"\n") - 1,
            }
        with (
            book.session(ADA) as session,
            refuses(UsageError, "--why", "to move it"),
        ):
            assign(session, f"both.csv#{names[0]}", "r003", None)
        with book.session(ADA) as session:
            says(assign(session, f"both.csv#{names[0]}", "r003", "it was the third"), "moved to run r003")
        with (
            book.session(ADA) as session,
            refuses(UsageError, "not a known"),
        ):
            assign(session, "both.csv#nothing", "r003", None)
    rebuilt_alike(small)


def test_a_column_that_the_file_lacks_is_refused_when_named_and_noted_in_a_batch(home: tuple[SmallBook, Path]) -> None:
    small, path = home
    absent = {"columns": {**MM["columns"], "nosuch": {"channel": "leg_length", "unit": "mm"}}}
    with small.open() as book:
        take(book, path, MM)
        refused = reread_named(book, path.name, RereadRequest(absent, ADA))
        assert refused.read.refused
        in_batch = reread_named(book, path.name, RereadRequest(absent, ADA, batch="b"))
        assert not in_batch.read.refused
        again = reread_named(book, path.name, RereadRequest({}, ADA))
    assert not again.read.refused
