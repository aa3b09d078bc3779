"""A book whose raw copies are lost, in its store or its backup, is made without them; the original files mend it."""

from __future__ import annotations

import shutil
import sqlite3
from collections.abc import Sequence
from pathlib import Path

import pytest

from data_schema.queries.files import find_files, last_reading
from data_schema.vocabulary import FileRole
from ingest.store import raw_path
from labbook.analysis.study_data import gather
from labbook.book.naming import run_named
from tests.cli.shell import good, labbook
from tests.helpers.books import DAYS, SmallBook, small_book
from tests.helpers.folders import contents
from tests.helpers.upkeep import backed_up, health, rows_by_name

CUT, GONE, SHEET = "r003.csv", "r005.csv", f"{DAYS[1]}.csv"
LOST = (CUT, GONE, SHEET)


def original(book: SmallBook, name: str) -> Path:
    return next(book.instruments.rglob(name))


def lose(book: SmallBook, store: Path, names: Sequence[str] = LOST) -> None:
    """Remove or cut the raw copies of some files."""
    with book.open() as opened, opened.reading() as connection:
        shas = {name: find_files(connection, name)[0].sha256 for name in names}
    for name, sha256 in shas.items():
        path = store / raw_path(sha256)
        half = path.read_bytes()[: path.stat().st_size // 2]
        path.unlink()
        if name == CUT:
            path.write_bytes(half)


@pytest.fixture
def judged(tmp_path: Path) -> SmallBook:
    """A book in which something was stated about what is lost."""
    book = small_book(tmp_path)
    for words in (
        ("jumps", "reject", "r003", "1", "--reason", "touched_by_hand"),
        ("assign", f"{SHEET}#2", "none", "--why", "another pack's"),
        ("files", "withdraw", GONE, "--why", "a test"),
        ("files", "restore", GONE),
    ):
        good(labbook(*words, at=book.folder))
    return book


def test_a_book_without_database_is_made_without_lost_copies_and_mended_by_the_originals(judged: SmallBook) -> None:
    before = rows_by_name(judged.folder)
    lose(judged, judged.folder)
    judged.database.unlink()
    lacking = contents(judged.folder)
    refused = labbook("rebuild", at=judged.folder)
    assert refused.code == 3
    assert "--keep-going" in refused.err
    assert contents(judged.folder) == lacking

    said = good(labbook("rebuild", "--keep-going", at=judged.folder)).out
    assert all(name in said for name in LOST)
    for deep in (False, True):
        found = health(judged, deep=deep)
        assert (found.whole, found.problems, len(found.lost_sentences)) == (False, (), 3)
    with judged.open() as book, book.reading() as connection:
        evidence = gather(connection, book.configuration, None)
        why = evidence.waits(run_named(connection, "r003").uid, FileRole.LOG)
        of_sheet = evidence.waits(run_named(connection, "r009").uid, FileRole.CHARGE)
        assert why is not None
        assert of_sheet is not None
        assert (CUT in why.reason, SHEET in of_sheet.reason) == (True, True)
    good(labbook("report", "--unsaved", "--out", judged.folder.parent / "paper", at=judged.folder))
    for words in (("show", "r003"), ("attention",), ("files", "list"), ("today",), ("runs", "list")):
        good(labbook(*words, at=judged.folder))
    no_charge = next(
        line for line in good(labbook("show", "r009", at=judged.folder)).out.splitlines() if "no cha" in line
    )
    assert SHEET in no_charge
    assert "labbook charge" not in no_charge
    for name in (CUT, GONE):
        refused = labbook("files", "reread", name, at=judged.folder)
        assert refused.code == 2
        assert "labbook ingest" in refused.err

    good(labbook("ingest", original(judged, CUT), at=judged.folder))
    assert len(health(judged).lost_sentences) == 2
    good(labbook("ingest", *(original(judged, name) for name in (GONE, SHEET)), at=judged.folder))
    assert health(judged, deep=True).whole
    assert rows_by_name(judged.folder) == before


def test_a_file_given_again_costs_no_other_its_numbers(judged: SmallBook, tmp_path: Path) -> None:
    before = rows_by_name(judged.folder)
    lose(judged, judged.folder, [GONE])
    good(labbook("rebuild", "--keep-going", at=judged.folder))
    lacking = rows_by_name(judged.folder)
    with judged.open() as opened, opened.reading() as connection:
        away = judged.folder / raw_path(find_files(connection, SHEET)[0].sha256)
    away.rename(tmp_path / "away")

    refused = labbook("ingest", original(judged, GONE), at=judged.folder)
    assert refused.code == 3
    assert "labbook rebuild" in refused.out
    assert rows_by_name(judged.folder) == lacking
    (tmp_path / "away").rename(away)
    good(labbook("ingest", original(judged, GONE), at=judged.folder))
    assert rows_by_name(judged.folder) == before


def test_a_file_given_again_says_what_the_rebuild_did(judged: SmallBook) -> None:
    lose(judged, judged.folder, [GONE])
    good(labbook("rebuild", "--keep-going", at=judged.folder))
    with sqlite3.connect(judged.database) as connection:
        connection.execute("UPDATE run SET jumps_made = 7 WHERE name = 'r001'")
    kept = set(judged.folder.glob("labbook.db.before-rebuild.*"))
    told = good(labbook("ingest", original(judged, GONE), at=judged.folder)).out
    (old,) = set(judged.folder.glob("labbook.db.before-rebuild.*")) - kept
    assert old.name in told
    assert "jumps_made" in told


def test_what_is_declared_of_a_lost_file_is_heeded(judged: SmallBook) -> None:
    lose(judged, judged.folder, [GONE])
    good(labbook("rebuild", "--keep-going", at=judged.folder))
    declared = ("--column", "body_height=body_height:m", "--run", "r003")
    told = good(labbook("ingest", original(judged, GONE), *declared, at=judged.folder)).out
    assert "read again" in told
    assert "--run r003" in told
    with judged.open() as opened, opened.reading() as connection:
        reading = last_reading(connection, find_files(connection, GONE)[0].sha256)
    assert reading is not None
    assert "body_height" in reading.options_json
    assert health(judged).whole


@pytest.mark.soak
def test_on_postgresql(tmp_path: Path, postgres_url: str) -> None:
    book = small_book(tmp_path, database_url=postgres_url)
    before = rows_by_name(book.folder, postgres_url)
    lose(book, book.folder)
    assert labbook("rebuild", at=book.folder).code == 3
    assert labbook("rebuild", "--keep-going", at=book.folder).code == 0
    assert len(health(book).lost_sentences) == 3
    good(labbook("ingest", *(original(book, name) for name in LOST), at=book.folder))
    assert health(book).whole
    assert rows_by_name(book.folder, postgres_url) == before


def test_what_was_put_back_by_hand_waits_for_a_rebuild(judged: SmallBook, tmp_path: Path) -> None:
    backed_up(judged.folder, tmp_path / "backup")
    before = rows_by_name(judged.folder)
    lose(judged, judged.folder, [GONE])
    good(labbook("rebuild", "--keep-going", at=judged.folder))
    shutil.copytree(tmp_path / "backup" / "raw", judged.folder / "raw", dirs_exist_ok=True, copy_function=_copy)
    assert not health(judged).whole
    assert labbook("files", "reread", GONE, at=judged.folder).code == 2
    good(labbook("rebuild", at=judged.folder))
    assert health(judged).whole
    assert rows_by_name(judged.folder) == before


def _copy(source: str, target: str) -> None:
    if not Path(target).exists():
        shutil.copyfile(source, target)


def test_a_backup_that_lacks_copies_is_restored_without_them(judged: SmallBook, tmp_path: Path) -> None:
    before, backup = rows_by_name(judged.folder), tmp_path / "backup"
    backed_up(judged.folder, backup)
    lose(judged, backup)
    assert labbook("restore", backup, tmp_path / "none", at=tmp_path).code == 3
    said = good(labbook("restore", backup, tmp_path / "again", "--keep-going", at=tmp_path)).out
    assert all(name in said for name in LOST)
    good(labbook("ingest", *(original(judged, name) for name in LOST), at=tmp_path / "again"))
    assert health(tmp_path / "again").whole
    assert rows_by_name(tmp_path / "again") == before


def test_a_backup_of_a_book_that_lacked_copies_is_restored(judged: SmallBook, tmp_path: Path) -> None:
    lose(judged, judged.folder)
    assert labbook("backup", tmp_path / "backup", at=judged.folder).code == 3
    assert labbook("restore", tmp_path / "backup", tmp_path / "again", at=tmp_path).code == 2
    good(labbook("restore", tmp_path / "backup", tmp_path / "again", "--keep-going", at=tmp_path))
    assert (tmp_path / "again" / "journal.jsonl").read_bytes() == judged.journal.read_bytes()


def test_a_backup_whose_last_run_failed_is_not_whole(judged: SmallBook, tmp_path: Path) -> None:
    backup, first = tmp_path / "backup", tmp_path / "first"
    backed_up(judged.folder, backup)
    complete = judged.journal.read_bytes()
    spare = tmp_path / "spare.csv"
    spare.write_bytes(b"".join(original(judged, GONE).read_bytes().splitlines(keepends=True)[:-1]))
    good(labbook("ingest", spare, at=judged.folder))
    lose(judged, judged.folder, [spare.name])
    for folder in (backup, first):
        assert labbook("backup", folder, at=judged.folder).code == 3
    for refused in (labbook("backup", backup, "--check", at=tmp_path), labbook("restore", first, "no", at=tmp_path)):
        assert refused.code != 0
        assert "--keep-going" in refused.out + refused.err
    assert labbook("backup", first, "--check", at=tmp_path).code != 0
    assert "--keep-going" in good(labbook("restore", backup, tmp_path / "older", at=tmp_path)).out
    assert (tmp_path / "older" / "journal.jsonl").read_bytes() == complete
    good(labbook("restore", backup, tmp_path / "later", "--keep-going", at=tmp_path))
    assert (tmp_path / "later" / "journal.jsonl").read_bytes() == judged.journal.read_bytes()


def test_a_backup_cut_off_at_its_end_is_whole(judged: SmallBook, tmp_path: Path) -> None:
    backup, kept = tmp_path / "backup", tmp_path / "kept"
    shutil.copytree(judged.folder / "raw", kept)
    lose(judged, judged.folder)
    assert labbook("backup", backup, at=judged.folder).code == 3
    left = (backup / "journal.jsonl.of-damaged-book").read_bytes()
    shutil.copytree(kept, judged.folder / "raw", dirs_exist_ok=True, copy_function=_put_back)
    good(labbook("note", "r001", "a cable came loose", at=judged.folder))
    backed_up(judged.folder, backup)
    (backup / "journal.jsonl.of-damaged-book").write_bytes(left)
    assert "whole" in good(labbook("backup", backup, "--check", at=tmp_path)).out
    good(labbook("restore", backup, tmp_path / "again", "--keep-going", at=tmp_path))
    assert (tmp_path / "again" / "journal.jsonl").read_bytes() == judged.journal.read_bytes()


def _put_back(source: str, target: str) -> None:
    Path(target).unlink(missing_ok=True)
    shutil.copyfile(source, target)


def test_a_backup_is_verified_by_itself(judged: SmallBook, tmp_path: Path) -> None:
    good(labbook("report", at=judged.folder))
    backup = tmp_path / "backup"
    backed_up(judged.folder, backup)
    shutil.rmtree(judged.folder)
    whole = contents(backup)
    assert "whole" in good(labbook("backup", backup, "--check", at=tmp_path)).out
    assert contents(backup) == whole
    kept = {path: path.read_bytes() for path in backup.rglob("*") if path.is_file()}
    raw, numbers = min(backup.glob("raw/*/*.zst")), min(backup.glob("numbers/*.json"))
    lines = (backup / "journal.jsonl").read_bytes().splitlines(keepends=True)
    for path, damaged in (
        (raw, b""),
        (numbers, numbers.read_bytes().replace(b"1", b"2", 1)),
        (backup / "journal.jsonl", b"".join(lines[:-1])),
        (backup / "journal.jsonl", b"".join([*lines[:3], lines[3].replace(b"a", b"b", 1), *lines[4:]])),
        (backup / "labbook.toml", b"[study]\n"),
    ):
        path.chmod(0o644)
        path.write_bytes(damaged)
        assert labbook("backup", backup, "--check", at=tmp_path).code != 0, path
        path.write_bytes(kept[path])
