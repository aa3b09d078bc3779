"""A report of the book as it stood earlier, and the journal that says when that was."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from data_schema.queries.history import command_ends
from labbook.book.as_of import book_as_of
from labbook.config.local_time import local_text
from tests.cli.shell import good, labbook, refused
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.web import served
from tests.helpers.wording import says

WHY = ("--why", "for this test")


def numbers(folder: Path) -> dict[str, Any]:
    """The numbers of a report by what they are of."""
    found = json.loads((folder / "numbers.json").read_text())["numbers"]
    return {one["path"]: (one["value"], one["se"]) for one in found.values()}


def changed_since(book: SmallBook, folder: Path) -> int:
    """Make a report, then change what it rests on; returns the entry before it was made."""
    before = len(book.journal.read_text().splitlines())
    good(labbook("report", "--out", folder / "first", at=book.folder))
    good(labbook("correct", "r001", "mah=200", *WHY, at=book.folder))
    good(labbook("void", "r002", *WHY, at=book.folder))
    good(labbook("jumps", "reject", "r003", "1", "--reason", "misfire", at=book.folder))
    book.rewrite("exclude_first_jumps = 0", "exclude_first_jumps = 1")
    good(labbook("note", "r004", "a note", at=book.folder))
    return before


def test_a_report_as_of_an_entry_has_the_numbers_of_then(tmp_path: Path) -> None:
    book = small_book(tmp_path)
    before = changed_since(book, tmp_path)
    journal = book.journal.read_bytes()
    good(labbook("report", "--as-of", str(before), "--out", tmp_path / "then", at=book.folder))
    good(labbook("report", "--unsaved", "--out", tmp_path / "now", at=book.folder))
    assert numbers(tmp_path / "then") == numbers(tmp_path / "first") != numbers(tmp_path / "now")
    says((tmp_path / "then" / "report.html").read_text().partition("</header>")[0], f"entry {before},")
    assert book.journal.read_bytes() == journal


def test_a_time_means_what_was_stated_by_then(tmp_path: Path) -> None:
    book = small_book(tmp_path)
    before = changed_since(book, tmp_path)
    at_utc = json.loads(book.journal.read_text().splitlines()[before - 1])["at_utc"]
    for number, asked in enumerate((at_utc, "9999-12-31", "2098-01-01 12:00")):
        good(labbook("report", "--as-of", asked, "--out", tmp_path / str(number), at=book.folder))
    assert numbers(tmp_path / "0") == numbers(tmp_path / "first")
    assert numbers(tmp_path / "1") == numbers(tmp_path / "2") != numbers(tmp_path / "first")


@pytest.mark.parametrize(
    "asked",
    [
        "0",
        "99999",
        "yesterday",
        "1999-01-01",
        "",
        "2021W241",
        "2026-13-01",
        "2026-01-01 25:00",
        "2026-01-01 12:00 XYZ",
    ],
)
def test_what_is_no_entry_and_no_time_is_refused(asked: str, tmp_path: Path) -> None:
    book = small_book(tmp_path)
    refused(labbook("report", "--as-of", asked, "--out", tmp_path / "then", at=book.folder), 2, "--as-of")
    refused(labbook("report", "--as-of", "1", at=book.folder), 2, "--out")


def test_a_time_as_the_journal_lists_it_means_the_end_of_its_second(tmp_path: Path) -> None:
    book = small_book(tmp_path)
    good(labbook("note", "r001", "the last", at=book.folder))
    zone = "America/New_York"
    with book.open() as opened, opened.reading() as connection:
        ends = command_ends(connection)
    (in_second,) = {local_text(end.at_utc, zone) for end in ends[-1:]}
    last = [end.seq for end in ends if local_text(end.at_utc, zone) <= in_second][-1]
    for asked in (in_second, in_second.rpartition(" ")[0], in_second[:16]):
        with book.open() as opened, book_as_of(opened, asked, lambda _step: None) as past:
            assert int(past.called.removeprefix("entry ").partition(",")[0]) >= last


def test_a_journal_that_is_shorter_than_the_database_is_told(tmp_path: Path) -> None:
    book = small_book(tmp_path)
    lines = book.journal.read_bytes().splitlines(keepends=True)
    book.journal.write_bytes(b"".join(lines[:30]))
    refused(labbook("report", "--as-of", "50", "--out", tmp_path / "then", at=book.folder), 3, "journal.jsonl")


def test_the_page_has_the_report_as_of_an_entry(tmp_path: Path) -> None:
    book = small_book(tmp_path)
    before = changed_since(book, tmp_path)
    with served(book.folder, "--as", ADA) as server:
        status, body, headers = server.ask(f"/reports/as-of/{before}")
        assert server.ask("/reports/as-of/99999")[0] == 422
    assert status == 200
    says(body.decode(), f"entry {before},")
    says(headers["Content-Security-Policy"], "sandbox")


def test_the_journal_is_listed_a_line_a_command(tmp_path: Path) -> None:
    book = small_book(tmp_path)
    before = changed_since(book, tmp_path)
    every = good(labbook("journal", "--json", "-n", "1000", at=book.folder)).json
    assert [one["first"] for one in every] == [1, *(one["last"] + 1 for one in every[:-1])]
    assert every[-1]["last"] == len(book.journal.read_text().splitlines())
    last = good(labbook("journal", "-n", "1", at=book.folder)).out
    says(last, "r004", "a note", ADA)
    earlier = good(labbook("journal", "--json", "-n", "2", "--before", str(before + 1), at=book.folder)).json
    assert earlier == [one for one in every if one["last"] <= before][-2:]
