"""What only a process of its own meets: a closed pipe, Ctrl-C, another writer, a disk that refuses, missing rights."""

from __future__ import annotations

import contextlib
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import psycopg
import pytest
import sqlalchemy as sa

from data_schema import engine as engines
from labbook.actions.report_command import state_report
from labbook.book.opening import open_book
from tests.cli.shell import LABBOOK, contents, environment, good, labbook, process, refused, rows, unchanged
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.databases import all_rows
from tests.helpers.postgres import Cluster
from tests.helpers.statements import note

NOBODY = 65534


@pytest.fixture
def open_to_all() -> Iterator[Path]:
    """A folder that users other than the one who tests can reach."""
    folder = Path(tempfile.mkdtemp(prefix="labbook-open-"))
    folder.chmod(0o755)
    yield folder
    shutil.rmtree(folder)


def test_exit_codes_and_sentences_are_those_of_the_installed_command(stated: SmallBook) -> None:
    refused(process("shw", at=stated.folder), 2, "no such command 'shw'")
    with stated.database.open("r+b") as handle:
        handle.write(b"not a database at all")
    refused(process("show", "r001", at=stated.folder), 3, "labbook rebuild")


def test_reader_that_has_seen_enough_is_no_error(whole: SmallBook) -> None:
    listing = subprocess.Popen(
        [LABBOOK, "jumps", "list", "r001"],
        cwd=whole.folder,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert listing.stdout is not None
    listing.stdout.close()  # `| head -0`: nobody reads what comes
    _nothing, said = listing.communicate(timeout=60)
    assert said == b""
    assert listing.returncode == 0


def test_output_to_a_full_disk_is_told(whole: SmallBook) -> None:
    with Path("/dev/full").open("w") as full, unchanged(whole.folder):
        done = subprocess.run(
            [LABBOOK, "runs", "list"], cwd=whole.folder, stdout=full, stderr=subprocess.PIPE, check=False, timeout=60
        )
    assert done.returncode == 3
    assert b"full" in done.stderr
    assert b"Traceback" not in done.stderr


def _slow_and_interruptible() -> None:
    """On a busy machine whoever waits for the first file comes before the one that reads the others."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    os.nice(19)


def test_ctrl_c_keeps_whole_files_and_the_same_command_goes_on(stated: SmallBook, tmp_path: Path) -> None:
    logs, spare = sorted((stated.instruments / "logs").iterdir()), tmp_path / "spare"
    spare.mkdir()
    for number, log in enumerate(logs * 4):  # twelve logs alone can be read before the signal arrives
        lines = log.read_text().splitlines(keepends=True)
        (spare / f"spare_{chr(97 + number // 26)}{chr(97 + number % 26)}.csv").write_text("".join(lines[: -1 - number]))
    total = 5 * len(logs)
    running = subprocess.Popen(
        [LABBOOK, "ingest", str(stated.instruments / "logs"), str(spare), "--json"],
        cwd=stated.folder,
        env=environment(),
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=_slow_and_interruptible,
    )
    deadline = time.monotonic() + 60
    while not rows(stated.folder, "SELECT uid FROM file") and time.monotonic() < deadline:
        time.sleep(0.01)
    running.send_signal(signal.SIGINT)
    out, err = running.communicate(timeout=60)
    kept = len(rows(stated.folder, "SELECT uid FROM file"))
    assert running.returncode == 130
    assert out == ""
    assert err.startswith("labbook: interrupted")
    assert 1 <= kept < total
    for count in ("count(*) FROM ingest", "count(DISTINCT file) FROM signal"):
        assert rows(stated.folder, f"SELECT {count}") == [(kept,)]
    assert rows(stated.folder, "PRAGMA integrity_check") == [("ok",)]
    assert {path.name for path in stated.folder.rglob(".*")} <= {".whole.journal.jsonl"}
    again = good(labbook("ingest", stated.instruments / "logs", spare, "--json", at=stated.folder)).json
    assert [item["status"] for item in again] == ["duplicate"] * kept + ["imported"] * (total - kept)
    assert rows(stated.folder, "SELECT count(*) FROM file") == [(total,)]


LOCK = """
import sqlite3, sys
connection = sqlite3.connect(sys.argv[1], isolation_level=None)
connection.execute("BEGIN IMMEDIATE")
print("locked", flush=True)
sys.stdin.read()
"""


def test_another_writer_makes_the_book_busy_and_reading_goes_on(
    stated: SmallBook, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = engines.sqlite_engine.__kwdefaults__
    assert settings is not None
    monkeypatch.setitem(settings, "busy_timeout_s", 0.1)
    with subprocess.Popen(
        [sys.executable, "-c", LOCK, stated.database], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as other:
        assert other.stdout is not None
        assert other.stdin is not None
        assert other.stdout.readline() == "locked\n"
        with unchanged(stated.folder):
            for words in ("note r001 x", "void r001 --reason x", "check rail_angle", "assign a r001"):
                refused(labbook(*words.split(), at=stated.folder), 3, "another program", "try again")
            assert "r001" in good(labbook("runs", "list", at=stated.folder)).out
        refused(labbook("ingest", stated.instruments / "logs", at=stated.folder), 3, "another program", "try again")
        assert rows(stated.folder, "SELECT count(*) FROM ingest") == [(0,)]
        other.stdin.close()
    good(labbook("ingest", stated.log("r001"), at=stated.folder))


@contextlib.contextmanager
def without_rights() -> Iterator[None]:
    """Be somebody who may read what all may read, and write nothing."""
    os.setegid(NOBODY)
    os.seteuid(NOBODY)
    try:
        yield
    finally:
        os.seteuid(0)
        os.setegid(0)


def lock(book: SmallBook) -> None:
    """Let nobody write to a book's files."""
    for path in (book.folder, *book.folder.rglob("*")):
        path.chmod(0o555 if path.is_dir() else 0o444)


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can become somebody without rights")
def test_book_that_may_only_be_read_is_said_to_be_so(open_to_all: Path) -> None:
    book = small_book(open_to_all, ingested=False)
    open_to_all.chmod(0o755)
    secret = open_to_all / "secret.csv"
    secret.write_text("t,h\n")
    secret.chmod(0o000)
    good(labbook("ingest", book.log("r001"), at=book.folder))  # as its owner
    questions = ("runs list", "show r001", "today", "runs inbox", "jumps list r001", "db status", "db check")
    for words in (*questions, "rebuild"):
        good(labbook(*words.split(), at=book.folder))  # who has no rights may not be let to the interpreter's modules
    lock(book)
    with unchanged(book.folder), without_rights():
        for question in questions:
            assert good(labbook(*question.split(), at=book.folder)).out
        refused(labbook("why", "0123", at=book.folder), 2, "no number's id begins with '0123'")
        for statement in ("note r001 x", "void r001 --reason x", "correct r001 foot=large --why x"):
            refused(labbook(*statement.split(), at=book.folder), 3, "cannot be written", "permissions of the book's")
        refused(labbook("ingest", book.log("r002"), at=book.folder), 2, "Permission denied", "check the path")
        refused(labbook("rebuild", at=book.folder), 2, "Permission denied", "check the path")
        plan = labbook("plan", "--seed", "3", "--n", "2", "--dry-run", "--out", "../plan.csv", at=book.folder)
        new = labbook("init", "..", "--as", "Ada Nwosu", at=book.folder)
        for told, name in ((plan, "plan.csv"), (new, "labbook.toml")):  # and not that of a part, ".plan.csv.part"
            refused(told, 2, name, "Permission denied")
            assert "/." not in told.err
    for path in (book.folder, *book.folder.rglob("*")):
        path.chmod(0o777 if path.is_dir() else 0o666)
    with without_rights():
        answer = labbook("ingest", secret, book.log("r002"), at=book.folder)
    assert answer.code == 2
    assert "secret.csv: refused (unknown), nothing stored:\n  file: not_readable: The file cannot be read" in answer.out
    assert answer.out.startswith("2 files: 1 imported, 0 there already, 1 refused.\n")


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can become somebody without rights")
def test_who_may_only_read_sees_what_its_owner_is_just_writing(open_to_all: Path) -> None:
    book = small_book(open_to_all, ingested=False)
    open_to_all.chmod(0o555)
    lock(book)
    with book.open() as own:
        with own.session(None) as session:
            note(session, "squeaks since noon")
        assert (book.folder / "labbook.db-wal").stat().st_size > 0  # not in the database's own file yet
        with without_rights():
            assert "squeaks since noon" in good(labbook("show", "r001", at=book.folder)).out
            refused(labbook("note", "r001", "x", at=book.folder), 3, "cannot be written")
    with without_rights():
        assert "squeaks since noon" in good(labbook("show", "r001", at=book.folder)).out


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can become somebody without rights")
def test_who_may_only_read_makes_the_same_report_elsewhere(open_to_all: Path) -> None:
    book, stored, mine = small_book(open_to_all, ingested=False), open_to_all / "stored", open_to_all / "mine"
    good(labbook("report", "--out", stored, at=book.folder))
    open_to_all.chmod(0o777)
    lock(book)
    with unchanged(book.folder), without_rights():
        refused(labbook("report", "--unsaved", at=book.folder), 2, "add --out DIR")
        told = labbook("report", "--out", open_to_all / "x", at=book.folder)
        refused(told, 3, "cannot be written", "--unsaved --out DIR")
        said = good(labbook("report", "--unsaved", "--out", mine, at=book.folder)).out
    assert "nothing was stored" in said
    assert "<dd>no: " in (mine / "report.html").read_text()
    assert "<dd>no: " not in (stored / "report.html").read_text()
    tables = sorted(path.name for path in (mine / "tables").iterdir())
    assert tables
    for name in tables:
        assert (mine / "tables" / name).read_bytes() == (stored / "tables" / name).read_bytes()


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can make a small disk")
def test_full_disk_leaves_the_book_as_it_was(open_to_all: Path) -> None:
    disk = open_to_all / "disk"
    disk.mkdir()
    if subprocess.run(
        ["mount", "-t", "tmpfs", "-o", "size=8M", "none", disk], capture_output=True, check=False
    ).returncode:
        pytest.skip("no disk can be mounted here")
    try:
        book = small_book(disk, ingested=False)
        with (disk / "ballast").open("wb") as ballast:
            ballast.write(bytes(shutil.disk_usage(disk).free - 40_960))
        before = contents(book.folder)
        answer = labbook("ingest", book.log("r001"), at=book.folder)
        assert answer.code in (2, 3)
        assert answer.err.startswith("labbook: ")
        assert contents(book.folder) == before
        (disk / "ballast").unlink()
        good(labbook("ingest", book.log("r001"), at=book.folder))
    finally:
        subprocess.run(["umount", disk], check=True)


QUESTIONS = ("runs list", "files list", "show r001", "today", "jumps list r001", "stats compare", "db check")
STATEMENTS = ("note r001 x", "void r001 --reason x", "correct r001 foot=large --why x", "assign r001.csv none --why x")


@pytest.fixture
def guest(tmp_path: Path, postgres_url: str, cluster: Cluster) -> Iterator[SmallBook]:
    """A book on PostgreSQL, with a report, as seen by a role that has SELECT only."""
    book = small_book(tmp_path, database_url=postgres_url)
    with book.open() as opened_book:
        state_report(opened_book, None, ADA, lambda _step: None)
    name = sa.make_url(postgres_url).database
    with psycopg.connect(host=str(cluster.socket_folder), user="labbook", dbname=name, autocommit=True) as owner:
        owner.execute("DROP ROLE IF EXISTS guest")
        owner.execute("CREATE ROLE guest LOGIN")
        owner.execute("GRANT USAGE ON SCHEMA labbook TO guest")
        owner.execute("GRANT SELECT ON ALL TABLES IN SCHEMA labbook TO guest")
        book.toml.write_text(book.toml.read_text().replace("://labbook@", "://guest@"))
        yield book
        owner.execute("DROP OWNED BY guest")
        owner.execute("DROP ROLE guest")


def test_a_role_that_may_only_read_asks_everything_and_states_nothing(guest: SmallBook, tmp_path: Path) -> None:
    engine = open_book(guest.folder).engine
    before = all_rows(engine)
    journal = guest.journal.read_bytes()
    for question in QUESTIONS:
        assert good(labbook(*question.split(), at=guest.folder)).out
    uid = good(labbook("reports", "show", "last", "--json", at=guest.folder)).json["numbers"][0]["id"]
    assert uid in good(labbook("why", uid, at=guest.folder)).out
    another = guest.instruments / "another.csv"
    another.write_bytes(b"".join(guest.log("r001").read_bytes().splitlines(keepends=True)[:70]))
    for statement in (*STATEMENTS, f"ingest {another}", "init . --as AN", "rebuild --journal"):
        answer = labbook(*statement.split(), at=guest.folder)
        refused(answer, 3, "permission denied for table journal", "a role that has it")
    refused(labbook("report", at=guest.folder), 3, "permission denied", "--unsaved --out DIR")
    good(labbook("report", "--unsaved", "--out", tmp_path / "mine", at=guest.folder))
    assert (tmp_path / "mine" / "report.html").stat().st_size > 0
    assert all_rows(engine) == before
    assert guest.journal.read_bytes() == journal
    engine.dispose()
