"""A backup holds all that its journal speaks of, whenever it was taken and whenever it was cut off."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from data_schema.errors import BookDamaged, UsageError
from data_schema.journal_file import JournalFile
from ingest.store import Store, raw_path
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.book.copies.backing_up import last_backup
from labbook.book.copies.copying import raw_of
from tests.helpers.books import SmallBook, small_book
from tests.helpers.commands import KILLED, Commands
from tests.helpers.databases import server_in_a_soak
from tests.helpers.folders import contents
from tests.helpers.statements import in_file, note, state
from tests.helpers.upkeep import backed_up
from tests.helpers.wording import refuses, says


@pytest.fixture
def whole(tmp_path: Path) -> SmallBook:
    return small_book(tmp_path)


def check_backup(destination: Path) -> int:
    """Check journal and raw copies of a backup; returns how many entries it holds."""
    entries = list(JournalFile(destination / "journal.jsonl").entries())
    for sha256 in raw_of(entries):
        assert Store(destination).raw(raw_path(sha256), sha256)
    return len(entries)


def say(book: SmallBook, text: str) -> None:
    with book.open() as standing:
        state(standing, note, text)


def test_a_backup_holds_the_journal_the_raw_copies_and_the_configuration(book: SmallBook, tmp_path: Path) -> None:
    destination = tmp_path / "stick" / "backup"
    with book.open() as standing:
        assert last_backup(standing.store) is None
        done = backed_up(book.folder, destination)
        assert last_backup(standing.store) == done.last
        assert (done.last.entries, done.remarks) == (len(in_file(standing)), ())
    assert check_backup(destination) == done.last.entries
    assert (destination / "journal.jsonl").read_bytes() == book.journal.read_bytes()
    assert (destination / "labbook.toml").read_bytes() == book.toml.read_bytes()
    assert contents(destination / "raw") == contents(book.folder / "raw")
    assert (done.raw.raw_copies, done.raw.written) == (14, 14)


def test_a_backup_of_a_book_on_postgresql_holds_no_password(tmp_path: Path, postgres_url: str) -> None:
    shared = small_book(tmp_path, database_url=postgres_url)
    with_password = shared.toml.read_text(encoding="utf-8").replace("labbook@", "labbook:s3cr3t@")
    shared.toml.write_text(with_password, encoding="utf-8")
    assert "s3cr3t" in with_password
    with shared.open() as book:
        state(book, note, "said with the password in use")
    destination = tmp_path / "backup"
    backed_up(shared.folder, destination)
    held = [path for path in destination.rglob("*") if path.is_file()]
    assert not any(b"s3cr3t" in path.read_bytes() for path in held)
    assert check_backup(destination)


def test_the_second_backup_writes_only_what_is_new_and_mends_what_it_cannot_trust(
    whole: SmallBook, tmp_path: Path
) -> None:
    destination = tmp_path / "backup"
    backed_up(whole.folder, destination)
    (destination / "raw" / "kept by hand").write_text("mine")
    first, second, third = sorted(destination.glob("raw/*/*.zst"))[:3]
    inode = third.stat().st_ino
    first.unlink()
    second.chmod(0o644)
    second.write_bytes(third.read_bytes())
    say(whole, "after the first backup")
    done = backed_up(whole.folder, destination)
    assert (done.raw.written, done.raw.replaced) == (2, 1)
    assert third.stat().st_ino == inode
    assert check_backup(destination) == done.last.entries
    assert (destination / "raw" / "kept by hand").read_text() == "mine"
    assert backed_up(whole.folder, destination).raw.written == 0


def test_what_the_book_lacks_is_named_and_the_backup_before_stays(whole: SmallBook, tmp_path: Path) -> None:
    destination = tmp_path / "backup"
    backed_up(whole.folder, destination)
    before = check_backup(destination)
    say(whole, "later")
    lost = min(whole.folder.glob("raw/*/*.zst"))
    lost.unlink()
    done = backed_up(whole.folder, destination)
    assert done.raw.problems == ()  # the copy in the backup is whole: nothing is missing there
    says(done.remarks, lost.name)
    (destination / lost.relative_to(whole.folder)).unlink()
    say(whole, "later still")
    other = tmp_path / "other"
    for place in (destination, other):
        with refuses(BookDamaged, "14 raw", "copies", lost.name, "ingest the original"):
            backed_up(whole.folder, place)
        kept = list(JournalFile(place / "journal.jsonl.of-damaged-book").entries())
        assert len(kept) == before + 2
        assert len(list(place.glob("raw/*/*.zst"))) == 13
    assert len(list(JournalFile(destination / "journal.jsonl").entries())) == before + 1
    assert not (other / "journal.jsonl").exists()


def test_a_folder_that_is_no_backup_of_this_book_is_left_alone(whole: SmallBook, tmp_path: Path) -> None:
    other = small_book(tmp_path / "other", ingested=False, two_people=True)
    backed_up(other.folder, tmp_path / "of other")
    theirs = tmp_path / "theirs"
    theirs.mkdir()
    (theirs / "thesis.tex").write_text("all of it")
    longer = tmp_path / "longer"
    text = whole.journal.read_bytes()
    say(whole, "in the other copy of the book")
    backed_up(whole.folder, longer)
    whole.journal.write_bytes(text)
    whole.database.unlink()
    for place, said in (
        (tmp_path / "of other", "backup of another book"),
        (theirs, "holds other things than a backup"),
        (longer, "holds entries that this book does not have"),
        (whole.folder, "in the book itself"),
        (whole.folder / "raw" / "backup", "in the book itself"),
    ):
        before = contents(place)
        with pytest.raises(UsageError, match=said):
            backed_up(whole.folder, place)
        assert contents(place) == before


def test_a_scene_of_ones_own_is_in_the_backup(whole: SmallBook, tmp_path: Path) -> None:
    scene = "base = 'bed'\n"
    for name in ("scenes/gravel.toml", "../elsewhere.toml"):
        (whole.folder / name).parent.mkdir(exist_ok=True)
        (whole.folder / name).write_text(scene)
    text = whole.toml.read_text()
    whole.toml.write_text(f'{text}\n[simulation]\nscene = "scenes/gravel.toml"\n')
    assert backed_up(whole.folder, tmp_path / "backup").remarks == ()
    assert (tmp_path / "backup" / "scenes" / "gravel.toml").read_text() == scene
    whole.toml.write_text(f'{text}\n[simulation]\nscene = "../elsewhere.toml"\n')
    (remark,) = backed_up(whole.folder, tmp_path / "backup").remarks
    says(remark, "elsewhere.toml")


def test_a_damaged_journal_of_a_backup_is_told_and_written_anew(whole: SmallBook, tmp_path: Path) -> None:
    backed_up(whole.folder, tmp_path / "backup")
    journal = tmp_path / "backup" / "journal.jsonl"
    journal.write_bytes(journal.read_bytes().replace(b"Nwosu", b"Nwoso", 1))
    (remark,) = backed_up(whole.folder, tmp_path / "backup").remarks
    assert "is written anew" in remark
    assert journal.read_bytes() == whole.journal.read_bytes()


# --- while others write, and cut off


def finish(book: SmallBook, destination: Path, commands: Commands) -> None:
    code, said = commands.run("backup", destination, "--book", book.folder)
    assert code == 0, said
    check_backup(destination)
    assert (destination / "journal.jsonl").read_bytes() == book.journal.read_bytes()
    assert list(destination.rglob(".*")) == []


@pytest.mark.parametrize("moments", [(2, 5, 12, 40), pytest.param((1, 2, 3, 5, 8, 12, 20, 40), marks=pytest.mark.soak)])
def test_killed_after_each_sync_the_next_backup_completes_it(
    tmp_path: Path, commands: Commands, moments: tuple[int, ...]
) -> None:
    book = small_book(tmp_path, ingested=False)
    with book.open() as standing:
        for run in ("r001", "r002"):
            ingest_file(standing, book.log(run), IngestRequest())
    destination = tmp_path / "backup"
    for number in moments:
        code, said = commands.run("backup", destination, "--book", book.folder, die_after_sync=number)
        assert code in (0, KILLED), said
        if (destination / "journal.jsonl").exists():
            check_backup(destination)
        if code == 0:
            break
    assert number > 5
    finish(book, destination, commands)


@server_in_a_soak("database_url")
def test_a_backup_during_eight_ingesting_programs_is_whole(
    tmp_path: Path, database_url: str | None, commands: Commands
) -> None:
    book = small_book(tmp_path, ingested=False, database_url=database_url)
    logs = sorted((book.instruments / "logs").iterdir())
    running = [commands.start("ingest", log, "--book", book.folder) for log in logs[:8]]
    seen = []
    for number in range(2):
        code, said = commands.run("backup", tmp_path / f"backup {number}", "--book", book.folder)
        assert code == 0, said
        seen.append(check_backup(tmp_path / f"backup {number}"))
    assert [one.wait() for one in running] == [0] * 8
    finish(book, tmp_path / "backup 0", commands)
    assert seen == sorted(seen)
    assert seen[0] < len(list(JournalFile(book.journal).entries()))  # the first was taken while others wrote
    record = json.loads((book.folder / "last-backup.json").read_text())
    assert record["where"] == str(tmp_path / "backup 0")


def test_two_backups_at_once_are_one_after_the_other(whole: SmallBook, tmp_path: Path, commands: Commands) -> None:
    both = [commands.start("backup", tmp_path / "backup", "--book", whole.folder) for _ in range(2)]
    codes = sorted(running.wait() for running in both)
    said = [running.output.read_text() for running in both]
    assert codes in ([0, 0], [0, 3]), said
    if codes == [0, 3]:
        assert any("another program" in text for text in said)
    finish(whole, tmp_path / "backup", commands)
