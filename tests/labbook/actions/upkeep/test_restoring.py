"""A restored book is the one that was backed up, row by row, on either engine, however often it was cut off."""

from __future__ import annotations

import shutil
import time
import tomllib
from pathlib import Path

import pytest

from data_schema.engine import postgres_engine, sqlite_engine
from data_schema.errors import BookDamaged, UsageError
from labbook.actions.upkeep.restoring import Place, Restored, restore
from labbook.book.copies.backing_up import back_up
from labbook.book.opening import opened
from labbook.terminal import progress
from tests.helpers.books import ADA, small_book
from tests.helpers.commands import KILLED, Commands
from tests.helpers.databases import Rows, all_rows_by_name
from tests.helpers.folders import contents
from tests.helpers.once import made_once
from tests.helpers.statements import note, notes, said_alike
from tests.helpers.whole_book import copy_of_whole_book
from tests.helpers.wording import refuses

HERE = Place(None)


def finished() -> Path:
    """Return where a book in which everything has happened lies, and its backup; made once."""

    def backed_up(folder: Path) -> Path:
        backup(copy_of_whole_book(folder).folder, folder / "backup")
        return folder

    return made_once("backed-up", backed_up)


@pytest.fixture
def source(tmp_path: Path) -> Path:
    """The backup of that book, of the test's own."""
    shutil.copytree(finished() / "backup", tmp_path / "backup")
    return tmp_path / "backup"


@pytest.fixture
def quick(tmp_path: Path) -> Path:
    """The folder of a book without reports, which is made anew quickly, and of its backup."""

    def backed_up(folder: Path) -> Path:
        backup(small_book(folder).folder, folder / "backup")
        return folder

    return shutil.copytree(made_once("quick-backed-up", backed_up), tmp_path / "quick")


def backup(folder: Path, destination: Path) -> None:
    back_up(folder, destination, lambda total: progress("", total, shown=False))


def restored(source: Path, folder: Path, place: Place | None = None) -> Restored:
    return restore(source, folder, place, lambda _step: None, lambda total: progress("", total, shown=False))


def rows(folder: Path, url: str | None = None) -> dict[str, Rows]:
    engine = postgres_engine(url) if url else sqlite_engine(folder / "labbook.db")
    try:
        return all_rows_by_name(engine)
    finally:
        engine.dispose()


def test_a_restored_book_has_every_row_and_goes_on(source: Path, tmp_path: Path) -> None:
    folder = tmp_path / "restored"
    done = restored(source, folder)
    assert rows(folder) == rows(finished() / "book")
    assert (done.entries, done.moved) == (len((folder / "journal.jsonl").read_text().splitlines()), False)
    assert (folder / "labbook.toml").read_bytes() == (source / "labbook.toml").read_bytes()
    assert list(folder.rglob(".*")) == []
    with opened(folder) as book:
        with book.session(ADA) as session:
            note(session, "afterwards")
        assert notes(book)[-1] == "afterwards"
        said_alike(book)


def test_from_postgresql_and_into_it(tmp_path: Path, postgres_url: str, quick: Path) -> None:
    before, backup_of = rows(quick / "book"), quick / "backup"
    on_server = tmp_path / "on server"
    assert restored(backup_of, on_server, Place(postgres_url)).moved
    assert rows(on_server, postgres_url) == before
    assert not (on_server / "labbook.db").exists()
    with pytest.raises(UsageError, match="is not empty"):
        restored(backup_of, tmp_path / "again", Place(postgres_url))
    backup(on_server, tmp_path / "backup of server")
    with pytest.raises(UsageError, match=r"--database URL .*--sqlite"):
        restored(tmp_path / "backup of server", tmp_path / "back")
    restored(tmp_path / "backup of server", tmp_path / "back", HERE)
    assert rows(tmp_path / "back") == before
    said = (tmp_path / "back" / "labbook.toml").read_text()
    assert "postgresql" not in said
    wanted = (backup_of / "labbook.toml").read_text()
    assert tomllib.loads(said) == tomllib.loads(wanted)


@pytest.mark.soak
def test_a_store_elsewhere_is_brought_into_the_book_and_left_alone_there(tmp_path: Path) -> None:
    book = small_book(tmp_path)
    shared = tmp_path / "shared"
    shared.mkdir()
    for name in ("raw", "signals", "journal.jsonl"):
        shutil.move(book.folder / name, shared / name)
    text = book.toml.read_text()
    book.toml.write_text(f"[store]  # on the shared drive\npath = '{shared}'\n\n{text}")
    backup(book.folder, tmp_path / "backup")
    before = contents(shared)
    restored(tmp_path / "backup", tmp_path / "restored")
    assert contents(shared) == before
    assert (tmp_path / "restored" / "labbook.toml").read_text().strip() == text.strip()
    assert len(list((tmp_path / "restored").glob("raw/*/*.zst"))) == 14
    assert rows(tmp_path / "restored") == rows(book.folder)


def test_a_folder_that_holds_anything_else_is_left_alone(quick: Path, tmp_path: Path) -> None:
    source = quick / "backup"
    theirs = tmp_path / "theirs"
    theirs.mkdir()
    (theirs / "thesis.tex").write_text("all of it")
    begun = tmp_path / "begun"
    lost = min(source.glob("raw/*/*.zst"))
    kept = lost.read_bytes()
    lost.unlink()
    with refuses(BookDamaged, "1", "raw copies", lost.name, "another backup"):
        restored(source, begun)
    other = shutil.copytree(source, tmp_path / "other")
    for place, of, said in (
        (theirs, source, "is not empty"),
        (begun, other, "unfinished restore of another backup"),
        (source / "inside", source, "lies in the backup itself"),
    ):
        before = contents(place)
        with pytest.raises(UsageError, match=said):
            restored(of, place)
        assert contents(place) == before
    lost.write_bytes(kept)
    restored(source, begun)
    assert rows(begun) == rows(quick / "book")


def test_what_is_no_complete_backup_is_refused(source: Path, tmp_path: Path) -> None:
    (source / "journal.jsonl").unlink()
    with pytest.raises(UsageError, match="was never completed"):
        restored(source, tmp_path / "restored")
    with pytest.raises(UsageError, match="is no backup"):
        restored(tmp_path, tmp_path / "restored")
    assert not (tmp_path / "restored").exists()


def test_damage_in_a_backup_is_told_before_anything_is_made(source: Path, tmp_path: Path) -> None:
    journal = source / "journal.jsonl"
    journal.write_text(journal.read_text().replace("Nwosu", "Nwoso", 1))
    with refuses(BookDamaged, "the backup", "is damaged", "restore from another"):
        restored(source, tmp_path / "restored")
    assert not (tmp_path / "restored").exists()


def test_a_journal_cut_after_the_backup_is_refused(source: Path, tmp_path: Path) -> None:
    journal = source / "journal.jsonl"
    lines = journal.read_text().splitlines(keepends=True)
    journal.write_text("".join(lines[:-1]))
    with refuses(BookDamaged, "ends at entry", len(lines) - 1, "not the one", len(lines), "entries"):
        restored(source, tmp_path / "restored")
    assert not (tmp_path / "restored").exists()


# --- cut off


def test_killed_after_a_sync_the_same_command_completes_it(quick: Path, tmp_path: Path, commands: Commands) -> None:
    words = ["restore", quick / "backup", tmp_path / "restored"]
    for number in (2, 20, 60, 80):
        code, said = commands.run(*words, die_after_sync=number)
        assert code in (0, KILLED), said
        if code == 0:
            break
    assert number > 3
    assert code == 0 or commands.run(*words)[0] == 0
    assert rows(tmp_path / "restored") == rows(quick / "book")
    assert list((tmp_path / "restored").glob(".*")) == []


@pytest.mark.soak
def test_killed_on_the_way_into_postgresql_the_same_command_completes_it(
    quick: Path, tmp_path: Path, commands: Commands, postgres_url: str
) -> None:
    words = ["restore", quick / "backup", tmp_path / "restored", "--database", postgres_url]
    code = KILLED
    for moment_s in (0.2, 0.6):
        if code == KILLED:
            running = commands.start(*words)
            time.sleep(moment_s)
            running.kill()
            code = running.wait()
            assert code in (0, KILLED), running.output.read_text()
    if code == KILLED:
        code, said = commands.run(*words)
        assert code == 0, said
    assert rows(tmp_path / "restored", postgres_url) == rows(quick / "book")
