"""The numbers of a report as files: read as they were written, kept whatever becomes of the page, and copied along."""

from __future__ import annotations

from pathlib import Path

import pytest

from data_schema.queries.history import list_reports
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.report_command import state_report, write
from labbook.actions.runs.correcting import correct
from labbook.actions.upkeep.tracing import find_number, recompute
from labbook.analysis.outcomes.detection import FOUND
from labbook.book.report_numbers import (
    NUMBERS,
    ReportNumbers,
    numbers_bytes,
    numbers_of_report,
    numbers_path,
    read_numbers,
)
from stats.apexes.detectors import DETECTORS
from tests.cli.shell import good, labbook, refused
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.statements import state
from tests.helpers.upkeep import backed_up
from tests.helpers.wording import says


@pytest.fixture
def book(tmp_path: Path) -> SmallBook:
    return small_book(tmp_path)


def test_numbers_come_back_as_they_were_written(book: SmallBook) -> None:
    with book.open() as standing:
        made = state_report(standing, None, ADA, lambda _step: None)
        with standing.reading() as connection:
            (report,) = list_reports(connection)
        read = read_numbers(standing.store.root, report)
    assert read == numbers_of_report(made)
    assert isinstance(read, ReportNumbers)
    assert set(read.numbers) == set(made.shown)
    assert report.numbers == len(read.numbers) > 100
    assert all(one.value is not None or one.undefined for one in read.numbers.values())
    assert {"signal", "charge"} <= {row.input_kind for one in read.numbers.values() for row in read.leaves_of(one)}
    data = numbers_bytes(read)
    assert (book.folder / report.folder / NUMBERS).read_bytes() == data
    assert numbers_path(book.folder, report.files[NUMBERS]).read_bytes() == data


def test_two_reports_within_one_second_have_two_folders(book: SmallBook, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("labbook.actions.report_command.now_utc", lambda: "2026-01-02T03:04:05.678Z")
    with book.open() as standing:
        for _ in range(2):
            state_report(standing, "foot=small", ADA, lambda _step: None)
        with standing.reading() as connection:
            folders = [report.folder for report in list_reports(connection)]
    assert folders == ["reports/20260102T030405Z", "reports/20260102T030405Z-2"]
    assert all((book.folder / folder / NUMBERS).exists() for folder in folders)


def test_numbers_of_a_page_that_was_written_over_and_of_a_restored_book_are_there(
    book: SmallBook, tmp_path: Path
) -> None:
    paper = tmp_path / "paper"
    with book.open() as standing:
        first = write(standing, "foot=small", paper, ADA, lambda _step: None)
        state(standing, correct, "r002", ["duration_s=700"], "typed")
        again = write(standing, "foot=small", paper, ADA, lambda _step: None)
    assert again.folder == first.folder
    Path(again.page).unlink()  # no page is compared, whatever lies where it was
    moved = good(labbook("reports", "diff", "1", "2", "--json", at=book.folder)).json["moved"]
    assert moved
    backed_up(book.folder, tmp_path / "backup")
    good(labbook("restore", tmp_path / "backup", tmp_path / "restored", at=tmp_path))
    at = tmp_path / "restored"
    assert good(labbook("reports", "diff", "1", "2", "--json", at=at)).json["moved"] == moved
    good(labbook("why", moved[0]["was"]["id"], "--check", at=at))


def test_a_backup_mends_damaged_numbers_and_names_lost_ones_and_restores_without(
    book: SmallBook, tmp_path: Path
) -> None:
    with book.open() as standing:
        for _ in range(2):
            state_report(standing, None, ADA, lambda _step: None)
        state_report(standing, "foot=small", ADA, lambda _step: None)
        with standing.reading() as connection:
            hashes = [report.files[NUMBERS] for report in list_reports(connection)]

    assert backed_up(book.folder, tmp_path / "backup").remarks == ()
    damaged = numbers_path(tmp_path / "backup", hashes[0])
    whole = damaged.read_bytes()
    damaged.write_bytes(whole[:-1])
    numbers_path(book.folder, hashes[2]).unlink()
    assert backed_up(book.folder, tmp_path / "backup").remarks == ()
    assert damaged.read_bytes() == whole
    numbers_path(tmp_path / "backup", hashes[2]).unlink()
    (remark,) = backed_up(book.folder, tmp_path / "backup").remarks
    says(remark, "report 3 of", numbers_path(book.folder, hashes[2]))
    said = good(labbook("restore", tmp_path / "backup", tmp_path / "restored", at=tmp_path)).out
    says(said, "report 3 of", "not in")
    assert "the book is whole" in good(labbook("db", "check", at=tmp_path / "restored")).out


@pytest.mark.parametrize("out", [".", "numbers", "reports", "raw"])
def test_a_report_is_not_written_among_other_things_of_a_book(book: SmallBook, out: str) -> None:
    refused(labbook("report", "--out", out, at=book.folder), 2, out, "--out")
    assert not (book.folder / "report.html").exists()


def test_a_report_does_not_replace_one_that_the_book_made(book: SmallBook) -> None:
    with book.open() as standing:
        folder = Path(write(standing, None, None, ADA, lambda _step: None).folder)
    page = (folder / "report.html").read_bytes()
    refused(labbook("report", "--foot", "small", "--out", folder, at=book.folder), 2, "another report")
    assert (folder / "report.html").read_bytes() == page
    for _time in range(2):  # a folder that a person named is that person's
        good(labbook("report", "--out", book.folder / "reports" / "20300101T000000Z-draft", at=book.folder))


def test_a_check_computes_all_of_a_number_whatever_the_caches_hold(
    book: SmallBook, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LABBOOK_CACHE", str(tmp_path / "cache"))
    with book.open() as standing:
        made = state_report(standing, None, ADA, lambda _step: None)
        assert FOUND.folder is not None
        found = list(FOUND.folder.iterdir())
        assert found
        for path in found:
            FOUND.write(path.name, b"never to be read")
        with standing.reading() as connection:
            asked = [find_number(standing, connection, uid) for uid in made.shown]
        assert {one.stands for one in recompute(standing, asked, lambda _step: None)} == {True}


def test_what_other_detectors_find_is_there_after_an_ingest_and_the_same_as_a_report_finds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LABBOOK_CACHE", str(tmp_path / "cache"))
    book = small_book(tmp_path, ingested=False)
    logs = sorted((book.instruments / "logs").iterdir())
    with book.open() as standing:
        for log in logs:
            ingest_file(standing, log, IngestRequest(person=ADA))
        assert FOUND.folder is not None
        found = {path.name: path.read_bytes() for path in FOUND.folder.iterdir()}
        assert len(found) == len(logs) * (len(DETECTORS) - 1) > 0
        for path in FOUND.folder.iterdir():
            path.unlink()
        state_report(standing, None, ADA, lambda _step: None)
        assert {path.name: path.read_bytes() for path in FOUND.folder.iterdir()} == found
