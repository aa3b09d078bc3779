"""Who may only read a book: a PostgreSQL role with SELECT and nothing else, and a folder that others own."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import psycopg
import pytest
import sqlalchemy as sa

from labbook.actions.report_command import state_report
from labbook.book.opening import open_book
from tests.cli.shell import LABBOOK, Answer, environment, good, labbook, refused, unchanged
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.databases import all_rows
from tests.helpers.postgres import Cluster

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


def test_who_may_only_read_a_sqlite_book_makes_the_same_report_elsewhere(stated: SmallBook, tmp_path: Path) -> None:
    mine, stored = tmp_path / "mine", tmp_path / "stored"
    paths = (stated.folder, *stated.folder.rglob("*"))
    rights = [path.stat().st_mode for path in paths]
    for path in paths:
        path.chmod(0o555 if path.is_dir() else 0o444)
    with unchanged(stated.folder):
        refused(labbook("report", "--unsaved", at=stated.folder), 2, "add --out DIR")
        bound = _bound_by_rights("report", "--out", tmp_path / "x", at=stated.folder)
        refused(bound, 3, "cannot be written", "--unsaved --out DIR")
        said = good(_bound_by_rights("report", "--unsaved", "--out", mine, at=stated.folder)).out
    for path, mode in zip(paths, rights, strict=True):
        path.chmod(mode)
    good(labbook("report", "--out", stored, at=stated.folder))
    assert "nothing was stored" in said
    assert "<dd>no: " in (mine / "report.html").read_text()
    assert "<dd>no: " not in (stored / "report.html").read_text()
    tables = sorted(path.name for path in (mine / "tables").iterdir())
    assert tables
    for name in tables:
        assert (mine / "tables" / name).read_bytes() == (stored / "tables" / name).read_bytes()


def _bound_by_rights(*words: str | Path, at: Path) -> Answer:
    """Give a command in a process that what files permit holds for, also where root gives it."""
    less = "-dac_override,-dac_read_search"
    bound = ["setpriv", f"--bounding-set={less}", f"--inh-caps={less}"] if os.geteuid() == 0 else []
    done = subprocess.run(
        [*bound, LABBOOK, *words], cwd=at, env=environment(), capture_output=True, text=True, timeout=120, check=False
    )
    return Answer(done.returncode, done.stdout, done.stderr)
