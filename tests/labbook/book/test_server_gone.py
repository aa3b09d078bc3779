"""PostgreSQL that goes away in the middle of a command: one sentence, and what was said is said once."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import psycopg
import pytest

from data_schema.errors import BookError
from data_schema.journal_file import JournalFile
from labbook.book.rebuilding import rebuild_database
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.postgres import Cluster, cluster_of
from tests.helpers.statements import note


def end_all(cluster: Cluster, database: str) -> None:
    """Have the server end every connection to a database, as an administrator does."""
    with psycopg.connect(
        host=str(cluster.socket_folder), user="labbook", dbname="postgres", autocommit=True
    ) as connection:
        connection.execute("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = %s", [database])


@pytest.mark.parametrize("after_journal", [False, True])
def test_a_connection_that_is_ended_is_a_sentence(
    tmp_path: Path, postgres_url: str, monkeypatch: pytest.MonkeyPatch, after_journal: bool
) -> None:
    small = small_book(tmp_path, database_url=postgres_url)
    cluster, database = cluster_of(postgres_url)
    append = JournalFile.append

    def then_end(self: JournalFile, entries: Any) -> None:
        append(self, entries)
        end_all(cluster, database)

    with small.open() as book:

        def speak() -> None:
            with book.session(ADA) as session:
                if not after_journal:
                    end_all(cluster, database)
                note(session, "a cable came loose")

        if after_journal:
            monkeypatch.setattr(JournalFile, "append", then_end)
        with pytest.raises(BookError) as raised:
            speak()
        monkeypatch.undo()
        assert ("do not say it again" in str(raised.value)) is after_journal
        assert "\n" not in str(raised.value)
        with book.session(ADA):
            pass
        with book.reading() as connection:
            notes = connection.exec_driver_sql("SELECT count(*) FROM note WHERE text = 'a cable came loose'").scalar()
        assert notes == int(after_journal)


def test_a_rebuild_whose_connection_is_ended_is_a_sentence(tmp_path: Path, postgres_url: str) -> None:
    small: SmallBook = small_book(tmp_path, database_url=postgres_url)
    cluster, database = cluster_of(postgres_url)
    steps: list[str] = []

    def step(what: str) -> None:
        steps.append(what)
        if len(steps) == 5:
            end_all(cluster, database)

    with pytest.raises(BookError) as raised:
        rebuild_database(small.folder, step)
    assert "\n" not in str(raised.value)
    rebuild_database(small.folder, lambda _step: None)
