"""A restored book is the one that was backed up, row by row, on either engine, however often it was cut off."""

from __future__ import annotations

import shutil
import time
import tomllib
from pathlib import Path

import pytest

from data_schema.errors import BookDamaged, UsageError
from labbook.actions.upkeep.restoring import Place, Restored, restore
from labbook.book.opening import opened
from tests.helpers.books import small_book
from tests.helpers.commands import KILLED, Commands
from tests.helpers.folders import contents
from tests.helpers.once import made_once
from tests.helpers.statements import note, notes, said_alike, state
from tests.helpers.upkeep import backed_up, rows_by_name, untold
from tests.helpers.whole_book import copy_of_whole_book
from tests.helpers.wording import refuses

HERE = Place(None)


def finished() -> Path:
    """Return where a book in which everything has happened lies, and its backup; made once."""

    def made(folder: Path) -> Path:
        backed_up(copy_of_whole_book(folder).folder, folder / "backup")
        return folder

    return made_once("backed-up", made)


@pytest.fixture
def source(tmp_path: Path) -> Path:
    """The backup of that book, of the test's own."""
    shutil.copytree(finished() / "backup", tmp_path / "backup")
    return tmp_path / "backup"


@pytest.fixture
def quick(tmp_path: Path) -> Path:
    """The folder of a book without reports, which is made anew quickly, and of its backup."""

    def made(folder: Path) -> Path:
        backed_up(small_book(folder).folder, folder / "backup")
        return folder

    return shutil.copytree(made_once("quick-backed-up", made), tmp_path / "quick")


def restored(source: Path, folder: Path, place: Place | None = None) -> Restored:
    return restore(source, folder, place, lambda _step: None, untold)


def test_a_restored_book_has_every_row_and_goes_on(source: Path, tmp_path: Path) -> None:
    folder = tmp_path / "restored"
    done = restored(source, folder)
    assert rows_by_name(folder) == rows_by_name(finished() / "book")
    assert (done.entries, done.moved) == (len((folder / "journal.jsonl").read_text().splitlines()), False)
    assert (folder / "labbook.toml").read_bytes() == (source / "labbook.toml").read_bytes()
    assert list(folder.rglob(".*")) == []
    with opened(folder) as book:
        state(book, note, "afterwards")
        assert notes(book)[-1] == "afterwards"
        said_alike(book)


def test_from_postgresql_and_into_it(tmp_path: Path, postgres_url: str, quick: Path) -> None:
    before, backup_of = rows_by_name(quick / "book"), quick / "backup"
    on_server = tmp_path / "on server"
    assert restored(backup_of, on_server, Place(postgres_url)).moved
    assert rows_by_name(on_server, postgres_url) == before
    assert not (on_server / "labbook.db").exists()
    with pytest.raises(UsageError, match="is not empty"):
        restored(backup_of, tmp_path / "again", Place(postgres_url))
    backed_up(on_server, tmp_path / "backup of server")
    with pytest.raises(UsageError, match=r"--database URL .*--sqlite"):
        restored(tmp_path / "backup of server", tmp_path / "back")
    restored(tmp_path / "backup of server", tmp_path / "back", HERE)
    assert rows_by_name(tmp_path / "back") == before
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
    backed_up(book.folder, tmp_path / "backup")
    before = contents(shared)
    restored(tmp_path / "backup", tmp_path / "restored")
    assert contents(shared) == before
    assert (tmp_path / "restored" / "labbook.toml").read_text().strip() == text.strip()
    assert len(list((tmp_path / "restored").glob("raw/*/*.zst"))) == 14
    assert rows_by_name(tmp_path / "restored") == rows_by_name(book.folder)


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
    assert rows_by_name(begun) == rows_by_name(quick / "book")


@pytest.mark.parametrize(
    ("how", "said"),
    [
        ("changed", ("the backup", "is damaged", "restore from another")),
        ("cut", ("ends at entry", "not the one", "entries")),
        ("lost", ("was never completed",)),
    ],
)
def test_a_journal_that_is_not_what_was_backed_up_is_told_before_anything_is_made(
    source: Path, tmp_path: Path, how: str, said: tuple[str, ...]
) -> None:
    journal = source / "journal.jsonl"
    text = journal.read_text()
    if how == "lost":
        journal.unlink()
    else:
        last = text.splitlines(keepends=True)[-1]
        journal.write_text(text.removesuffix(last) if how == "cut" else text.replace("Nwosu", "Nwoso", 1))
    with refuses(UsageError if how == "lost" else BookDamaged, *said):
        restored(source, tmp_path / "restored")
    with pytest.raises(UsageError, match="is no backup"):
        restored(tmp_path, tmp_path / "restored")
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
    assert rows_by_name(tmp_path / "restored") == rows_by_name(quick / "book")
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
    assert rows_by_name(tmp_path / "restored", postgres_url) == rows_by_name(quick / "book")
