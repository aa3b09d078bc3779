"""A journal table that was shortened or emptied hides no altered row: what stands in the tables belongs to no entry."""

from __future__ import annotations

import contextlib
import sqlite3
from pathlib import Path

import pytest

from tests.cli.shell import good, labbook
from tests.helpers.books import small_book
from tests.helpers.upkeep import health


@pytest.mark.parametrize("gone", ["all", "last"])
def test_rows_that_no_entry_of_the_table_accounts_for_are_named(tmp_path: Path, gone: str) -> None:
    small = small_book(tmp_path)
    good(labbook("note", "r001", "a cable came loose", at=small.folder))
    with contextlib.closing(sqlite3.connect(small.folder / "labbook.db")) as connection, connection:
        triggers = connection.execute("SELECT name, sql FROM sqlite_master WHERE type = 'trigger'").fetchall()
        for name, _sql in triggers:
            connection.execute(f"DROP TRIGGER {name}")
        last = "" if gone == "all" else " WHERE seq = (SELECT max(seq) FROM journal)"
        connection.execute(f"DELETE FROM journal{last}")
        connection.execute("UPDATE run SET jumps_made = jumps_made + 1 WHERE name = 'r001'")
        for _name, sql in triggers:
            connection.execute(sql)
    found = health(small)
    assert not found.whole
    (altered,) = (problem for problem in found.problems if "jumps_made is" in problem)
    assert "r001" in altered
    assert len(found.problems) == 2
    good(labbook("rebuild", at=small.folder))
    assert health(small).whole
