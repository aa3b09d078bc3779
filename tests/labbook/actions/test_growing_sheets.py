"""A hand-kept sheet grows and comes again; what was voided, lost or miscounted can be told and put right."""

from __future__ import annotations

import hashlib
from pathlib import Path

from data_schema.queries.charges import charges_by_run
from data_schema.queries.imported_files import inbox
from data_schema.vocabulary import RunState
from ingest.store import Store
from labbook.actions.files.assigning import assign
from labbook.actions.files.ingesting import FileOutcome, IngestRequest, ingest_file
from labbook.actions.report_command import state_report
from labbook.actions.runs.charges import state_charge
from labbook.actions.runs.correcting import correct, unvoid, void
from labbook.book.naming import run_named
from labbook.book.opening import Book
from labbook.book.rebuilding import rebuild_database
from tests.helpers.books import ADA, small_book
from tests.helpers.databases import all_rows


def ingest_sheet(book: Book, folder: Path, name: str, text: bytes) -> FileOutcome:
    path = folder / name
    path.write_bytes(text)
    return ingest_file(book, path, IngestRequest(person=ADA))


def rules(outcome: FileOutcome) -> list[str]:
    assert outcome.read is not None
    return [finding.rule for finding in outcome.read.findings]


def test_a_sheet_that_grew_adds_only_what_is_new(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    first, second = sorted((small.instruments / "charger").iterdir())
    with small.open() as book, book.reading() as connection:
        before = {uid: [charge.uid for charge in charges] for uid, charges in charges_by_run(connection).items()}
    grown = first.read_bytes() + b"".join(second.read_bytes().splitlines(keepends=True)[1:])
    with small.open() as book:
        outcome = ingest_sheet(book, tmp_path, "grown.csv", grown)
        assert set(rules(outcome)) >= {"charge_known"}
        with book.reading() as connection:
            after = {uid: [charge.uid for charge in charges] for uid, charges in charges_by_run(connection).items()}
            assert after == before
            assert not inbox(connection)


def test_a_charge_taken_off_its_run_does_not_come_back_with_the_grown_sheet(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    sheet = min((small.instruments / "charger").iterdir())
    with small.open() as book:
        with book.session(ADA) as session:
            assign(session, f"{sheet.name}#1", "none", "it was another pack's")
        with book.reading() as connection:
            run = run_named(connection, sheet.read_text().splitlines()[1].split(",")[0])
            before = inbox(connection)
        grown = sheet.read_bytes() + b"r099,300,20,16.8,A\n"
        ingest_sheet(book, tmp_path, "grown.csv", grown)
        with book.reading() as connection:
            assert run.uid not in charges_by_run(connection)
            assert [item for item in inbox(connection) if item not in before] == inbox(connection)[-1:], "r099 alone"


def test_a_contradicting_row_waits_and_the_run_keeps_its_charge(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    first = min((small.instruments / "charger").iterdir())
    with small.open() as book, book.reading() as connection:
        run = run_named(connection, "r001")
        charge = charges_by_run(connection)[run.uid][0]
    other = f"run,mAh,minutes,end_voltage,pack\nr001,{charge.charge_mah + 7:g},14,15.4,A\n".encode()
    assert first.is_file()
    with small.open() as book:
        outcome = ingest_sheet(book, tmp_path, "other.csv", other)
        assert "charge_contradicts" in rules(outcome)
        with book.reading() as connection:
            assert [item.charge_mah for item in charges_by_run(connection)[run.uid]] == [charge.charge_mah]
            assert [item.stated_run for item in inbox(connection)] == ["r001"]
        rows = all_rows(book.engine)
    rebuild_database(small.folder, lambda _step: None)
    with small.open() as book:
        assert all_rows(book.engine) == rows


def test_void_can_be_taken_back(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    with small.open() as book:
        with book.session(ADA) as session:
            void(session, "r001", "foot came loose")
        with book.session(ADA) as session:
            unvoid(session, "r001", "it was r002")
            assert run_named(session.connection, "r001").state is RunState.COMPLETE
        with book.session(ADA) as session:
            assert "not void" in unvoid(session, "r001", "again")
            assert not session.said


def test_jumps_that_were_not_found_leave_a_finding(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    log = min((small.instruments / "logs").iterdir())
    with small.open() as book:
        with book.session(ADA) as session:
            correct(book, session, "r001", ["jumps_made=9"], "counted again")
        outcome = ingest_file_again(book, tmp_path, log)
        assert "jumps_found_not_made" in rules(outcome)


def ingest_file_again(book: Book, folder: Path, log: Path) -> FileOutcome:
    """The same log with one more line is another file; its name states the run."""
    lines = log.read_bytes().splitlines(keepends=True)
    path = folder / log.name
    path.write_bytes(b"".join(lines[:-1]))
    return ingest_file(book, path, IngestRequest(run="r001", person=ADA))


def test_a_lost_or_changed_raw_copy_is_put_back(tmp_path: Path) -> None:
    store, data = Store(tmp_path), b"time [s],h [m]\n0,1\n"
    sha256 = hashlib.sha256(data).hexdigest()
    path = tmp_path / store.put_raw(data, sha256)
    assert not store.restore_raw(data, sha256)
    path.unlink()
    assert store.restore_raw(data, sha256)
    path.chmod(0o644)
    path.write_bytes(b"rubbish")
    assert store.restore_raw(data, sha256)
    assert store.raw(f"raw/{sha256[:2]}/{sha256}.zst", sha256) == data


def test_a_charge_typed_in_later_makes_its_condition_stale(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    with small.open() as book:
        with book.reading() as connection:
            run = run_named(connection, "r001")
            charge = charges_by_run(connection)[run.uid][0]
        with book.session(ADA) as session:
            correct(book, session, f"charge:{charge.uid}", ["run=none"], "belongs elsewhere")
        state_report(book, None, ADA, lambda _step: None)
        with book.session(ADA) as session:
            state_charge(session, book.configuration, "r001", charge.charge_mah, None, None)
            stale = session.stale
    assert any(kind == "condition_summary" and run.condition_key in scope for kind, scope in stale)
