"""What nothing needs is removed, and all that a book needs stays: real leftovers, of real commands that were killed."""

from __future__ import annotations

import os
import random
import shutil
import time
from pathlib import Path

import pytest

from data_schema.engine import writing
from data_schema.errors import BookBusy, UsageError
from labbook.actions.files import ingesting
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.upkeep.pruning import Leftover, leftovers, prune
from labbook.book.opening import Book
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.commands import KILLED, Commands
from tests.helpers.databases import all_rows_by_name, server_in_a_soak
from tests.helpers.folders import contents
from tests.helpers.upkeep import health, rebuilt, untold
from tests.helpers.wording import refuses, says

SHA256 = "ab" + "01" * 31
TEMPORARY = f"raw/ab/.{SHA256}.zst.12345678"
ORPHAN = f"signals/ab/{SHA256}.parquet"


def listed(book: Book) -> dict[str, Leftover]:
    with book.reading() as connection:
        return {one.name: one for one in leftovers(book, connection)}


def pruned(book: Book, *names: str) -> set[str]:
    return {one.name for one in prune(book, names, untold)}


def rebuild(book: SmallBook) -> str:
    old = rebuilt(book).old
    assert old is not None
    return old


def lay(book: SmallBook, name: str, age_s: float = 7200) -> Path:
    """Put a file where a command that was killed left one, so long ago."""
    path = book.folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(b"half a file")
    os.utime(path, (time.time() - age_s,) * 2)
    return path


def test_old_databases_and_what_was_cut_off_go_and_the_book_stays(book: SmallBook) -> None:
    with book.open() as standing:
        assert listed(standing) == {}
        rows = all_rows_by_name(standing.engine)
        old = {rebuild(book)}
        left = {TEMPORARY, ".labbook.db.rebuild.0123abcd", "reports/20210601/.report.html.x1.part"}
        left.add(ORPHAN)
        aside = {"journal.jsonl.cut-off.20210601T000000000000Z", "journal.jsonl.before-rebuild.20210601T000000000000Z"}
        for name in left | aside:
            lay(book, name)
        lay(book, TEMPORARY.replace("ab", "cd"), age_s=60)  # of a command at work
        mine = {lay(book, name) for name in ("raw.txt", "labbook.db.mine", "reports/2021/.mine", ".notes")}
        before = contents(book.folder)
        assert set(listed(standing)) == old | left | aside
        assert contents(book.folder) == before
        assert pruned(standing) == old | left
        assert set(listed(standing)) == aside
        assert all(path.exists() for path in mine)
        assert health(book).problems == ()
        assert all_rows_by_name(standing.engine) == rows
        assert pruned(standing, *aside) == aside
        assert listed(standing) == {}


FOREIGN = (
    "raw/README.txt",
    "raw/2024-03/only_copy.csv",
    f"raw/ab/{SHA256}.csv",
    f"raw/cd/{SHA256}.zst",
    "signals/ab/.DS_Store",
    "numbers/notes.json",
)


def test_files_that_are_not_labbooks_are_named_and_never_removed(book: SmallBook) -> None:
    mine = [lay(book, name) for name in FOREIGN]
    outside = book.folder.parent / "thesis.txt"
    outside.write_text("years of work")
    (book.folder / "raw" / "link.zst").symlink_to(outside)
    lay(book, "labbook.db.before-rebuild.mine")
    lay(book, ORPHAN)
    with book.open() as standing:
        found = listed(standing)
        assert {name for name, one in found.items() if one.foreign} == {*FOREIGN, "raw/link.zst"}
        with refuses(UsageError, FOREIGN[1], "not labbook's"):
            pruned(standing, FOREIGN[1])
        assert pruned(standing) == {ORPHAN}
        assert pruned(standing) == set()
    assert all(path.exists() for path in mine)
    assert outside.read_text() == "years of work"
    assert (book.folder / "raw" / "link.zst").is_symlink()


def test_what_the_journal_speaks_of_stays_also_without_a_row(tmp_path: Path, commands: Commands) -> None:
    """An ingest cut off between journal and commit: its files belong to no row yet."""
    book = small_book(tmp_path, ingested=False)
    words = ["ingest", book.log("r001"), "--book", book.folder]
    code, _said = commands.run(*words, die_after_sync=1, of="journal.jsonl")
    assert code == KILLED
    lay(book, TEMPORARY)
    for path in book.folder.rglob("*"):
        os.utime(path, (1e9, 1e9))
    with book.open() as standing:
        assert len(health(book).orphans) == 3
        assert pruned(standing) == {TEMPORARY}
        with standing.session(ADA):
            pass
    found = health(book)
    assert (found.orphans, found.problems) == ((), ())


def test_what_a_journal_that_was_set_aside_speaks_of_stays_until_that_is_removed(tmp_path: Path) -> None:
    book = small_book(tmp_path, ingested=False)
    raw = f"raw/ab/{SHA256}.zst"
    lay(book, raw)
    aside = lay(book, "journal.jsonl.cut-off.20210601T000000000000Z")
    aside.write_bytes(b'{"action":"ingest","new":{"sha256":"' + SHA256.encode())
    with book.open() as standing:
        assert pruned(standing) == set()
        assert pruned(standing, aside.name) == {aside.name}
        assert pruned(standing) == {raw}


def test_an_ingest_whose_files_are_removed_before_its_rows_are_there_is_not_half_done(
    book: SmallBook, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The orphan of a killed ingest is taken in again, and pruned at that very moment."""
    log = tmp_path / "again.csv"
    log.write_bytes(book.log("r001").read_bytes() + b"\n")
    with book.open() as standing:
        real = ingesting.store_reading

        def then_pruned(*given: object, **named: object) -> object:
            done = real(*given, **named)  # type: ignore[arg-type]
            for path in book.folder.rglob("*"):
                os.utime(path, (1e9, 1e9))
            assert len(pruned(standing)) >= 1
            return done

        monkeypatch.setattr(ingesting, "store_reading", then_pruned)
        with refuses(BookBusy, "raw/", "removed from the", "give the command"):
            ingest_file(standing, log, IngestRequest(person=ADA))
        monkeypatch.undo()
        assert health(book).problems == ()
        assert ingest_file(standing, log, IngestRequest(person=ADA)).status == "imported"
    assert health(book).problems == ()


@pytest.mark.soak
@server_in_a_soak("database_url")
def test_pruning_while_others_ingest_takes_nothing_from_them(
    tmp_path: Path, database_url: str | None, commands: Commands
) -> None:
    book = small_book(tmp_path, ingested=False, database_url=database_url)
    logs = sorted((book.instruments / "logs").iterdir())[:4]
    chance = random.Random(7)
    for log in logs:  # killed, so that old orphans are there for those who come after
        running = commands.start("ingest", log, "--book", book.folder)
        time.sleep(chance.uniform(0, 0.2))
        running.kill()
        running.wait()
    for path in (book.folder / "raw").rglob("*"):
        os.utime(path, (1e9, 1e9))
    running_now = [commands.start("ingest", log, "--book", book.folder) for log in logs]
    for _ in range(2):
        code, said = commands.run("db", "prune", "--yes", "--book", book.folder)
        assert code == 0, said
    for running in running_now:
        code = running.wait()
        assert code == 0 or "command again" in running.output.read_text(), running.output.read_text()
    assert health(book).problems == ()
    code, said = commands.run("ingest", *logs, "--book", book.folder)
    assert code == 0, said
    found = health(book)
    assert (found.problems, found.raw_copies) == ((), len(logs))


def test_old_tables_on_which_a_lab_built_something_stay(tmp_path: Path, postgres_url: str) -> None:
    book = small_book(tmp_path, ingested=False, database_url=postgres_url)
    old = rebuild(book)
    with book.open() as standing:
        with writing(standing.engine) as connection:
            connection.exec_driver_sql(f"CREATE VIEW as_it_was AS SELECT text FROM {old}.note")
        with refuses(UsageError, "as_it_was", old, "nothing was removed"):
            pruned(standing)
        assert set(listed(standing)) == {old}
        with writing(standing.engine) as connection:
            connection.exec_driver_sql("DROP VIEW as_it_was")
        assert pruned(standing) == {old}


def test_a_prune_that_is_killed_leaves_a_whole_book(tmp_path: Path, commands: Commands) -> None:
    book = small_book(tmp_path)
    chance = random.Random(8)
    for number in range(2):
        for name in (TEMPORARY, ORPHAN, f"labbook.db.before-rebuild.2021060{number}T000000000000Z"):
            lay(book, name)
        running = commands.start("db", "prune", "--yes", "--book", book.folder)
        time.sleep(chance.uniform(0, 0.3))
        running.kill()
        assert running.wait() in (0, KILLED), running.output.read_text()
        assert health(book).problems == ()
    code, said = commands.run("db", "prune", "--yes", "--book", book.folder)
    assert code == 0, said
    with book.open() as standing:
        assert listed(standing) == {}
    shutil.rmtree(book.folder)


def test_the_size_of_an_empty_leftover_is_shown_in_the_unit_of_all(tmp_path: Path, commands: Commands) -> None:
    book = small_book(tmp_path, ingested=False)
    lay(book, TEMPORARY).write_bytes(b"")
    os.utime(book.folder / TEMPORARY, (1e9, 1e9))
    code, said = commands.run("db", "prune", "--book", book.folder)
    assert code == 0, said
    says(said, TEMPORARY, "0.0 MB")
