"""The lists of the page are the same from a book on PostgreSQL."""

from __future__ import annotations

from pathlib import Path

from data_schema.queries.files import refused_files
from labbook.actions.upkeep.journal_view import newest_commands
from tests.cli.shell import good, labbook
from tests.helpers.books import small_book


def test_refused_files_and_the_journal(postgres_url: str, tmp_path: Path) -> None:
    log = tmp_path / "words.csv"
    log.write_text("no numbers\nat all\n")
    found = []
    for name, url in (("sqlite", None), ("postgresql", postgres_url)):
        book = small_book(tmp_path / name, database_url=url)
        assert labbook("ingest", log, at=book.folder).code == 2
        good(labbook("note", "r003", "a remark", at=book.folder))
        with book.open() as opened, opened.reading() as connection:
            refused = [(one.name, one.why) for one in refused_files(connection, 5)]
            commands = [(one.first, one.last, one.what, one.run) for one in newest_commands(connection, 5)]
        found.append((refused, commands))
    assert found[0] == found[1]
    assert found[0][0]
