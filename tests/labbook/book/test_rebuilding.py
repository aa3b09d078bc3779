"""Raw copies and journal are the truth: from them the same database is made again, to the row."""

from __future__ import annotations

import functools
import random
import shutil
import sqlite3
import tempfile
import time
from contextlib import closing
from pathlib import Path

import pyarrow as pa
import pytest
import sqlalchemy as sa

from data_schema import journal
from data_schema.engine import postgres_engine, sqlite_engine, writing
from data_schema.errors import BookBusy, BookDamaged, UsageError
from labbook.book.rebuilding import Rebuilt, rebuild_database
from tests.helpers.books import ADA, SmallBook
from tests.helpers.commands import KILLED, Commands
from tests.helpers.databases import Rows, all_rows, all_rows_by_name
from tests.helpers.postgres import Cluster
from tests.helpers.statements import note, notes, said_alike
from tests.helpers.whole_book import whole_book


@functools.cache
def finished() -> tuple[tempfile.TemporaryDirectory[str], SmallBook]:
    """A book in which everything has happened, made once."""
    hold = tempfile.TemporaryDirectory(prefix="whole-book-")
    return hold, whole_book(Path(hold.name))


@pytest.fixture
def whole(tmp_path: Path) -> SmallBook:
    shutil.copytree(finished()[1].folder, tmp_path / "book")
    return SmallBook(tmp_path / "book", finished()[1].instruments)


def rows_of(book: SmallBook) -> dict[str, Rows]:
    return rows_of_sqlite(book.database)


def rows_of_sqlite(path: Path) -> dict[str, Rows]:
    engine = sqlite_engine(path)
    try:
        return all_rows(engine)
    finally:
        engine.dispose()


def rebuild(book: SmallBook) -> Rebuilt:
    return rebuild_database(book.folder, lambda _step: None)


def test_everything_is_there_again_to_the_row_and_its_keys_and_the_book_goes_on(whole: SmallBook) -> None:
    before = rows_of(whole)
    empty = {name for name, rows in before.items() if not rows}
    assert empty == {"instrument", "calibration", "prediction"}, "a table that nothing is written to proves nothing"
    done = rebuild(whole)
    assert done.entries == len(before["journal"])
    assert rows_of(whole) == before
    assert done.old is not None  # and the old one is kept
    assert rows_of_sqlite(whole.folder / done.old) == before
    with whole.open() as book:
        with book.desk(ADA) as desk:
            note(desk, "afterwards")
        assert notes(book)[-1] == "afterwards"
        said_alike(book)


def test_without_database_and_samples_both_are_made_from_the_raw_copies(whole: SmallBook) -> None:
    before = rows_of(whole)
    whole.database.unlink()
    shutil.rmtree(whole.folder / "signals")
    assert rebuild(whole).old is None
    assert rows_of(whole) == before
    paths = [row[-1] for row in before["signal"]]
    assert all((whole.folder / path).is_file() for path in paths)


def moved(book: SmallBook, old: str, new: str) -> SmallBook:
    """The same book, but its configuration says another database."""
    book.toml.write_text(book.toml.read_text().replace(old, new))
    return book


def by_name(url: str | None, folder: Path) -> dict[str, Rows]:
    engine = postgres_engine(url) if url else sqlite_engine(folder / "labbook.db")
    try:
        return all_rows_by_name(engine)
    finally:
        engine.dispose()


def test_on_postgresql_the_same_rows_come_of_the_same_journal(postgres_url: str, whole: SmallBook) -> None:
    on_sqlite = by_name(None, whole.folder)
    moved(whole, "[files]", f'[database]\nurl = "{postgres_url}"\n\n[files]')
    assert rebuild(whole) == Rebuilt(len(on_sqlite["journal"]), None)
    assert by_name(postgres_url, whole.folder) == on_sqlite


def test_what_was_lived_on_postgresql_is_made_again_there_but_for_its_keys(tmp_path: Path, cluster: Cluster) -> None:
    lived, anew = (cluster.url(cluster.fresh()) for _ in range(2))
    book = whole_book(tmp_path, lived)
    before = by_name(lived, book.folder)
    with pytest.raises(UsageError, match=r"is not empty .*give \[database\] url of an empty one"):
        rebuild(book)
    rebuild(moved(book, lived, anew))
    assert by_name(anew, book.folder) == before


# --- interrupted


def test_a_rebuild_that_is_killed_leaves_the_old_database(whole: SmallBook, commands: Commands) -> None:
    before, chance = rows_of(whole), random.Random(5)
    died = 0
    for _ in range(4):
        running = commands.start("rebuild", "--book", whole.folder)
        time.sleep(chance.uniform(0, 0.8))
        running.kill()
        died += running.wait() == KILLED
        assert rows_of(whole) == before
    assert died > 1
    code, said = commands.run("rebuild", "--book", whole.folder)
    assert code == 0, said
    assert rows_of(whole) == before
    assert list(whole.folder.glob(".*")) == []


def test_on_postgresql_a_rebuild_that_was_killed_goes_on(
    postgres_url: str, whole: SmallBook, commands: Commands
) -> None:
    on_sqlite = by_name(None, whole.folder)
    moved(whole, "[files]", f'[database]\nurl = "{postgres_url}"\n\n[files]')
    running = commands.start("rebuild", "--book", whole.folder)
    engine = postgres_engine(postgres_url)
    for _ in range(600):
        time.sleep(0.01)
        with engine.connect() as connection:
            begun = sa.inspect(connection).has_table("journal")
            there = journal.head(connection)[0] if begun else 0
        if there > 3:
            break
    engine.dispose()
    running.kill()
    assert running.wait() == KILLED
    assert 3 < len(by_name(postgres_url, whole.folder)["journal"]) < len(on_sqlite["journal"])
    code, said = commands.run("rebuild", "--book", whole.folder)
    assert code == 0, said
    assert by_name(postgres_url, whole.folder) == on_sqlite


# --- what is not as it was


@pytest.mark.parametrize("how", ["changed", "removed", "cut"])
def test_a_raw_copy_that_is_not_what_was_kept_stops_it(whole: SmallBook, commands: Commands, how: str) -> None:
    before, files = rows_of(whole), sorted(whole.folder.rglob("*"))
    raw = sorted((whole.folder / "raw").rglob("*.zst"))[3]
    content = raw.read_bytes()
    raw.unlink()
    if how != "removed":
        raw.write_bytes(content[:-20] if how == "cut" else pa.Codec("zstd").compress(b"other bytes").to_pybytes())
    code, said = commands.run("rebuild", "--book", whole.folder)
    assert code == 3
    assert said.startswith(f"labbook: the raw copy raw/{raw.parent.name}/{raw.name} ")
    assert "restore it from a backup" in said
    assert "Traceback" not in said
    raw.unlink(missing_ok=True)
    raw.write_bytes(content)
    assert rows_of(whole) == before
    assert sorted(whole.folder.rglob("*")) == files


def test_a_journal_that_was_changed_stops_it(whole: SmallBook) -> None:
    lines = whole.journal.read_bytes().splitlines(keepends=True)
    before = whole.database.read_bytes()
    for damaged in ([*lines[:5], *lines[6:]], [lines[0].replace(b"Ada", b"Eve"), *lines[1:]]):
        whole.journal.write_bytes(b"".join(damaged))
        with pytest.raises(BookDamaged, match=r"restore journal\.jsonl from a backup"):
            rebuild(whole)
    whole.journal.write_bytes(b"")
    with pytest.raises(UsageError, match="holds no entry: there is nothing to rebuild from"):
        rebuild(whole)
    whole.journal.unlink()
    with pytest.raises(BookDamaged, match="is missing"):
        rebuild(whole)
    assert whole.database.read_bytes() == before


def test_a_database_that_is_open_elsewhere_is_not_replaced(whole: SmallBook) -> None:
    with closing(sqlite3.connect(whole.database)) as other:
        other.execute("BEGIN")
        other.execute("SELECT count(*) FROM run").fetchone()
        with pytest.raises(
            BookBusy, match=r"another program has .*labbook\.db open: close it and run `labbook rebuild`"
        ):
            rebuild(whole)
    rebuild(whole)


def test_a_database_that_is_no_longer_one_is_set_aside(whole: SmallBook) -> None:
    before = rows_of(whole)
    whole.database.write_bytes(b"not a database " * 1000)
    old = rebuild(whole).old
    assert old is not None
    assert (whole.folder / old).read_bytes() == b"not a database " * 1000
    assert rows_of(whole) == before


def test_the_log_of_a_lost_database_is_not_read_into_the_new_one(whole: SmallBook) -> None:
    """`rm labbook.db` leaves labbook.db-wal, which SQLite would play back into whatever lies beside it next."""
    before, log = rows_of(whole), whole.folder / "labbook.db-wal"
    engine = sqlite_engine(whole.database)
    with writing(engine) as connection:
        connection.exec_driver_sql("UPDATE note SET text = 'never said'")
    kept = log.read_bytes()
    engine.dispose()
    assert kept
    whole.database.unlink()
    log.write_bytes(kept)
    rebuild(whole)
    assert rows_of(whole) == before
