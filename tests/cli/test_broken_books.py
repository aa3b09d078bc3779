"""A book that is not there, not finished, damaged, or another labbook's: said in one sentence, nothing made worse."""

from __future__ import annotations

import contextlib
import shutil
import sqlite3
from pathlib import Path

import pytest

from tests.cli.shell import good, labbook, refused, rows, unchanged
from tests.helpers.books import SmallBook

READING = (
    "runs list",
    "runs inbox",
    "today",
    "attention",
    "show r001",
    "jumps list r001",
    "why 0123",
    "plot r001",
    "db status",
)
WRITING = ("note r001 x", "ingest labbook.toml", "void r001 --reason x", "report", "plan --seed 1", "check rail_angle")


def test_where_no_book_is_it_says_how_to_make_one(tmp_path: Path) -> None:
    for words in (*READING, *WRITING, "rebuild"):
        refused(labbook(*words.split(), at=tmp_path), 2, "no book", "--book DIR", "labbook init DIR")
    assert list(tmp_path.iterdir()) == []


def test_a_book_is_found_from_a_folder_inside_it_and_by_name(stated: SmallBook, tmp_path: Path) -> None:
    inside = stated.folder / "notes" / "2021"
    inside.mkdir(parents=True)
    expected = good(labbook("runs", "list", at=stated.folder)).out
    assert good(labbook("runs", "list", at=inside)).out == expected
    assert good(labbook("runs", "list", "--book", stated.folder, at=tmp_path)).out == expected


def test_a_new_book_is_described_first_and_then_only_corrected(tmp_path: Path) -> None:
    good(labbook("init", "mybook", "--as", "Ada Nwosu", at=tmp_path))
    book = tmp_path / "mybook"
    toml = book / "labbook.toml"
    described = toml.read_text().replace('name = "mybook"', 'name = "granular bed"').replace("#checks", "checks")
    toml.write_text(described)
    good(labbook("check", "rail_angle", at=book))
    assert rows(book, "SELECT name, reference_voltage_v FROM study") == [("granular bed", 15.4)]
    toml.write_text(described.replace("= 15.4", "= 16.8").replace('"granular bed"', '"soft bed"'))
    with unchanged(book):
        answer = labbook("check", "lubrication", at=book)
        refused(answer, 2, "labbook correct study 'name=soft bed'", "labbook correct study reference_voltage_v=16.8")
    for said in ("name=soft bed", "reference_voltage_v=16.8"):
        good(labbook("correct", "study", said, "--why", "typed wrong", at=book))
    good(labbook("check", "lubrication", at=book))
    assert rows(book, "SELECT name, reference_voltage_v FROM study") == [("soft bed", 16.8)]


def test_configuration_that_is_no_text_is_named(stated: SmallBook) -> None:
    stated.toml.write_bytes(b"[study]\nname = '\xe9'")
    with unchanged(stated.folder):
        for words in ("runs list", "note r001 x", "db status", "rebuild"):
            refused(labbook(*words.split(), at=stated.folder), 2, "labbook.toml", "is not UTF-8 text (byte 16)")


def test_a_lost_configuration_is_named_by_every_command_with_the_command_that_writes_it(stated: SmallBook) -> None:
    text = stated.toml.read_bytes()
    below = stated.folder / "logs"
    below.mkdir()
    stated.toml.unlink()
    for root in (stated.folder, below):
        with unchanged(stated.folder):
            for words in (*READING, *WRITING, "db check", "rebuild", "backup ../copy", "files list"):
                refused(labbook(*words.split(), at=root), 2, "labbook.toml", f"labbook init {stated.folder}")
    good(labbook("init", stated.folder, "--as", "Ada Nwosu", at=stated.folder))
    assert stated.toml.read_bytes() == text


@pytest.mark.parametrize("left", ["journal.jsonl", "labbook.db"])
def test_a_book_without_configuration_does_not_write_to_one_above_it(left: str, stated: SmallBook) -> None:
    inner = stated.folder / "field"
    inner.mkdir()
    shutil.copy(stated.folder / left, inner)
    with unchanged(stated.folder):
        refused(labbook("note", "r001", "x", at=inner), 2, "labbook.toml", "from a backup")
    (inner / left).unlink()
    good(labbook("note", "r001", "x", at=inner))


def test_missing_database_is_named_with_the_command_that_makes_it(stated: SmallBook) -> None:
    kept = rows(stated.folder, "SELECT name FROM run ORDER BY name")
    for piece in stated.folder.glob("labbook.db*"):
        piece.unlink()
    for words in (*READING, *WRITING):
        refused(labbook(*words.split(), at=stated.folder), 2, "labbook.db is missing", "labbook rebuild")
    assert not stated.database.exists()
    good(labbook("rebuild", at=stated.folder))
    assert rows(stated.folder, "SELECT name FROM run ORDER BY name") == kept


@pytest.mark.parametrize("statement", ["DROP TABLE journal", "DELETE FROM labbook"])
def test_database_of_another_making_is_refused(statement: str, stated: SmallBook) -> None:
    with contextlib.closing(sqlite3.connect(stated.database, isolation_level=None)) as connection:
        connection.execute("PRAGMA foreign_keys = off")
        connection.execute(statement)
    with unchanged(stated.folder):
        for words in ("runs list", "note r001 x", "ingest labbook.toml"):
            refused(labbook(*words.split(), at=stated.folder), 3, "was not made by labbook")


@pytest.mark.parametrize("where", ["header", "pages", "end"])
def test_damaged_database_is_told_and_left_to_rebuild(where: str, stated: SmallBook) -> None:
    content = stated.database.read_bytes()
    half = len(content) // 2
    damaged = {
        "header": b"not a database at all" + content[21:],
        "pages": content[:4096] + b"\xa5" * half + content[4096 + half :],
        "end": content[:half],
    }[where]
    stated.database.write_bytes(damaged)
    with unchanged(stated.folder):
        for words in ("runs list", "note r001 x", "report"):
            refused(labbook(*words.split(), at=stated.folder), 3, "database", "labbook rebuild")
    good(labbook("rebuild", at=stated.folder))
    assert len(rows(stated.folder, "SELECT uid FROM run")) == 16
    (aside,) = stated.folder.glob("labbook.db.before-rebuild.*Z")
    assert aside.read_bytes() == damaged


def test_journal_that_was_changed_is_told(stated: SmallBook) -> None:
    good(labbook("note", "r001", "left rail squeaked", at=stated.folder))
    stated.journal.write_text(stated.journal.read_text().replace("left rail squeaked", "right rail squeaked"))
    with unchanged(stated.folder):
        refused(labbook("note", "r001", "x", at=stated.folder), 3, "was changed after it was written", "backup")
        refused(labbook("rebuild", at=stated.folder), 3, "was changed after it was written")


def test_empty_book_answers_every_question(fresh: SmallBook) -> None:
    with unchanged(fresh.folder):
        for words, said in (("runs list", "no runs"), ("runs inbox", "empty"), ("today", "0 runs")):
            assert said in good(labbook(*words.split(), at=fresh.folder)).out
        refused(labbook("show", "r001", at=fresh.folder), 2, "there is no run yet")
        refused(labbook("why", "0123", at=fresh.folder), 2, "0123")
