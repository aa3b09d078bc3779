"""A report of the book as it stood earlier, and the journal that says when that was."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

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
    says((tmp_path / "then" / "report.html").read_text(), f"entry {before},")
    assert book.journal.read_bytes() == journal


def test_a_time_means_what_was_stated_by_then(tmp_path: Path) -> None:
    book = small_book(tmp_path)
    before = changed_since(book, tmp_path)
    lines = [json.loads(line) for line in book.journal.read_text().splitlines()]
    for number, asked in enumerate((lines[before - 1]["at_utc"], "2098-01-01", "2098-01-01 12:00")):
        good(labbook("report", "--as-of", asked, "--out", tmp_path / str(number), at=book.folder))
    assert numbers(tmp_path / "0") == numbers(tmp_path / "first")
    assert numbers(tmp_path / "1") == numbers(tmp_path / "2") != numbers(tmp_path / "first")


@pytest.mark.parametrize("asked", ["0", "99999", "yesterday", "1999-01-01", ""])
def test_what_is_no_entry_and_no_time_is_refused(asked: str, tmp_path: Path) -> None:
    book = small_book(tmp_path)
    refused(labbook("report", "--as-of", asked, "--out", tmp_path / "then", at=book.folder), 2, "--as-of")
    refused(labbook("report", "--as-of", "1", at=book.folder), 2, "--out")


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
