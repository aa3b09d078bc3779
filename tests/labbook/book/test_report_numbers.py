"""The numbers of a report as files: read as they were written, kept whatever becomes of the page, and copied along."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from data_schema.queries.reports import list_reports
from labbook.actions.report_command import state_report, write
from labbook.actions.upkeep.recomputing import recompute
from labbook.actions.upkeep.tracing import find_number
from labbook.analysis.outcomes.detection import FOUND
from labbook.book.copies.backing_up import back_up
from labbook.book.report_numbers import (
    NUMBERS,
    ReportNumbers,
    numbers_bytes,
    numbers_of_report,
    numbers_path,
    read_numbers,
)
from labbook.terminal import progress
from tests.cli.shell import good, labbook, refused
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.wording import says

HEAVY = ("numpy", "scipy", "pandas", "pyarrow", "statsmodels", "stats", "matplotlib")


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
    good(labbook("correct", "r002", "duration_s=700", "--why", "typed", at=book.folder))
    with book.open() as standing:
        assert write(standing, "foot=small", paper, ADA, lambda _step: None).folder == first.folder
    moved = good(labbook("reports", "diff", "1", "2", "--json", at=book.folder)).json["moved"]
    assert moved
    back_up(book.folder, tmp_path / "backup", lambda total: progress("", total, shown=False))
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

    def backed_up() -> tuple[str, ...]:
        return back_up(book.folder, tmp_path / "backup", lambda total: progress("", total, shown=False)).remarks

    assert backed_up() == ()
    damaged = numbers_path(tmp_path / "backup", hashes[0])
    whole = damaged.read_bytes()
    damaged.write_bytes(whole[:-1])
    numbers_path(book.folder, hashes[2]).unlink()
    assert backed_up() == ()
    assert damaged.read_bytes() == whole
    numbers_path(tmp_path / "backup", hashes[2]).unlink()
    (remark,) = backed_up()
    says(remark, "report 3 of", numbers_path(book.folder, hashes[2]))
    said = good(labbook("restore", tmp_path / "backup", tmp_path / "restored", at=tmp_path)).out
    says(said, "report 3 of", "not in")
    assert "the book is whole" in good(labbook("db", "check", at=tmp_path / "restored")).out


def test_restoring_compares_no_pages_whatever_lies_where_they_were(book: SmallBook, tmp_path: Path) -> None:
    with book.open() as standing:
        made = write(standing, None, tmp_path / "paper", ADA, lambda _step: None)
    Path(made.page).unlink()
    back_up(book.folder, tmp_path / "backup", lambda total: progress("", total, shown=False))
    good(labbook("restore", tmp_path / "backup", tmp_path / "restored", at=tmp_path))


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
    for name in ("paper", "20300101T000000Z-draft"):  # a folder that a person named is that person's
        for _time in range(2):
            good(labbook("report", "--out", book.folder / "reports" / name, at=book.folder))


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


def test_asking_where_a_number_came_from_loads_nothing_that_computes() -> None:
    code = "import sys, labbook.actions.upkeep.tracing, labbook.book.opening, labbook.book.report_numbers\n"
    code += f"print([name for name in {HEAVY!r} if name in sys.modules])"
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=Path(__file__).parents[3], capture_output=True, text=True, check=True
    )
    assert done.stdout == "[]\n"
