"""A file's bytes are kept for good; how they are read is a statement, and can be made again."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from data_schema.errors import UsageError
from data_schema.queries.files import ReadingRow, last_reading, parts_of_reading, readings_of
from data_schema.queries.history import list_reports
from data_schema.queries.signals import signals_of_runs
from data_schema.vocabulary import IngestStatus
from labbook.actions.files.assigning import assign
from labbook.actions.files.ingesting import FileOutcome, IngestRequest, ingest_file
from labbook.actions.files.rereading import RereadRequest
from labbook.actions.files.stored_files import files_to_reread, reread_named
from labbook.actions.upkeep.tracing import find_number, trace
from labbook.book.report_numbers import read_numbers
from tests.helpers.books import ADA, SmallBook, reported_book, small_book
from tests.helpers.databases import all_rows_by_name
from tests.helpers.desk import Desk, Options
from tests.helpers.statements import said_alike
from tests.helpers.upkeep import rebuilt_alike
from tests.helpers.wording import refuses, says

MM = {"columns": {"z": {"channel": "body_height", "unit": "mm"}}}
LOG = "LOG001.csv"


def home_made(small: SmallBook, run: str = "r001") -> bytes:
    """The log of a run as a home-made logger would write it: its own column names, no unit of the height."""
    lines = small.log(run).read_text().splitlines()
    height = lines[0].split(",").index("body_height [m]")
    rows = [(line.split(",")[0], float(line.split(",")[height])) for line in lines[1:]]
    return "".join(["t [ms],z\n", *(f"{t},{1000 * z:.4f}\n" for t, z in rows)]).encode()


def take(desk: Desk, options: Options | None = None, **more: Any) -> FileOutcome:
    """Ingest a log that its reader reads without knowing what the column is."""
    return desk.take(LOG, home_made(desk.small), options, **more)


def row_of(desk: Desk, outcome: FileOutcome) -> ReadingRow:
    with desk.book.reading() as connection:
        row = last_reading(connection, outcome.sha256)
    assert row is not None
    return row


def test_reading_again_what_reads_the_same_states_nothing(desk: Desk) -> None:
    outcome = take(desk, run="r001")
    stated = said_alike(desk.book)
    for options in ({}, MM, MM, {}):
        before = len(said_alike(desk.book))
        done = reread_named(desk.book, row_of(desk, outcome).file_uid or "", RereadRequest(options, ADA, "to see"))
        assert not done.read.refused
        added = said_alike(desk.book)[before:]
        assert len(added) == (options == MM and before == len(stated))
        assert done.runs == ("r001",)


def test_a_log_that_came_in_with_nothing_declared_is_mended_in_its_book(desk: Desk) -> None:
    first = take(desk, run="r001")
    assert first.read is not None
    assert [channel.name for channel in first.read.parts[0].channels] == ["z"]
    again = take(desk, MM)
    assert again.status is IngestStatus.DUPLICATE
    says(again.changes, "body_height", "[m]")
    says(again.changes, "3 jumps found")
    with desk.book.reading() as connection:
        (part,) = parts_of_reading(connection, row_of(desk, first).uid)
    assert part.channels == (("body_height", "m"),)
    assert take(desk, MM).changes is None  # the same declared again is no other reading
    assert take(desk).changes is None  # nothing declared changes nothing
    entries = [entry for entry in said_alike(desk.book) if entry.reads and entry.old]
    assert [entry.new["settings"]["declared"]["columns"]["z"]["unit"] for entry in entries if entry.new] == ["mm"]


def test_a_reading_needs_no_labbook_toml(tmp_path: Path) -> None:
    """The profile that read a file stands in the journal, whatever becomes of labbook.toml."""
    small = small_book(tmp_path, ingested=False)
    toml = small.toml.read_text()
    profile = '\n[profiles.bench]\nrecognise = ["t", "z"]\ncolumns = { z = { channel = "body_height", unit = "mm" } }\n'
    small.toml.write_text(toml + profile)
    with small.open() as book:
        first = take(Desk(small, book, tmp_path), run="r001")
    small.toml.write_text(toml + profile.replace('"mm"', '"mm", sign = -1') + "no_robot_check = true\n")
    with small.open() as book:
        desk = Desk(small, book, tmp_path)
        (line,) = take(desk).messages
        says(line, "labbook files reread --all")
        (row,) = files_to_reread(book, lambda _name: None)
        mended = reread_named(book, row.name, RereadRequest({}, ADA, "it hangs upside down"))
        says(mended.changes, "values differ", "0 jumps", "was 3")
        assert files_to_reread(book, lambda _name: None) == []
        assert take(desk, MM).changes is not None
    small.toml.write_text(toml)
    with small.open() as book, book.reading() as connection:
        kept = json.loads(readings_of(connection, first.sha256)[0].settings_json or "")
        (used,) = kept["declared"]["profiles"]
        assert used["columns"]["z"]["unit"] == "mm"
    rebuilt_alike(small)


def test_a_new_reading_that_is_refused_changes_nothing(desk: Desk) -> None:
    take(desk, MM, run="r001")
    before = all_rows_by_name(desk.book.engine)
    outcome = take(desk, {"columns": {"z": {"channel": "body_height", "unit": "parsec-ish"}}})
    assert outcome.status is IngestStatus.REFUSED
    after = all_rows_by_name(desk.book.engine)
    for table in ("signal", "channel", "run_file", "charge", "jump"):
        assert after[table] == before[table]
    assert json.loads(row_of(desk, outcome).options_json) == MM


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
        options = {"columns": columns, "no_robot_check": True}
        again = ingest_file(book, small.log("r001"), IngestRequest(options=options, person=ADA))
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
        for path, column, said in (
            (small.log("r001"), "body_height [m]", {"channel": "body_height", "unit": "m"}),
            (sheet, "mAh", {"channel": "charge", "unit": "mAh"}),
        ):
            again = ingest_file(book, path, IngestRequest(options={"columns": {column: said}}, person=ADA))
            says(again.changes, "nothing comes out")
            assert "report" not in " ".join(again.messages)


def test_a_dry_run_says_what_would_change_and_changes_nothing(desk: Desk) -> None:
    take(desk, run="r001")
    before, kept = all_rows_by_name(desk.book.engine), sorted(desk.small.folder.rglob("*.parquet"))
    says(take(desk, MM, dry_run=True).changes, "body_height")
    assert all_rows_by_name(desk.book.engine) == before
    assert sorted(desk.small.folder.rglob("*.parquet")) == kept


def test_parts_of_a_file_are_given_to_runs_one_by_one(desk: Desk) -> None:
    """A logger that was started twice without a new file: the clock begins again, and each part is another run's."""
    first, second = (desk.small.log(run).read_bytes() for run in ("r001", "r002"))
    row = row_of(desk, desk.take("both.csv", first + second.split(b"\n", 1)[1]))
    with desk.book.reading() as connection:
        one, other = (f"both.csv#{part.part}" for part in parts_of_reading(connection, row.uid))
    for part, run, loose in ((one, "r001", [other]), (other, "r002", [])):
        desk.say(assign, part, run, None)
        assert desk.inbox() == loose
    with desk.book.reading() as connection:
        samples = {item.run_name: item.n_samples for item in signals_of_runs(connection)}
    assert samples == {"r001": first.count(b"\n") - 1, "r002": second.count(b"\n") - 1}
    with refuses(UsageError, "--why", "to move it"):
        desk.say(assign, one, "r003", None)
    says(desk.say(assign, one, "r003", "it was the third"), "moved to run r003")
    with refuses(UsageError, "not a known"):
        desk.say(assign, "both.csv#nothing", "r003", None)


def test_a_column_that_the_file_lacks_is_refused_when_named_and_noted_in_a_batch(desk: Desk) -> None:
    absent = {"columns": {**MM["columns"], "nosuch": {"channel": "leg_length", "unit": "mm"}}}
    take(desk, MM)
    for request, refused in (
        (RereadRequest(absent, ADA), True),
        (RereadRequest(absent, ADA, batch="b"), False),
        (RereadRequest({}, ADA), False),
    ):
        assert reread_named(desk.book, LOG, request).read.refused is refused
