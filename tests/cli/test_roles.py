"""Who may only read a book on PostgreSQL: a role with SELECT and nothing else; of SQLite, see `test_processes.py`."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import psycopg
import pytest
import sqlalchemy as sa

from labbook.actions.report_command import state_report
from labbook.book.opening import open_book
from tests.cli.shell import good, labbook, refused
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
