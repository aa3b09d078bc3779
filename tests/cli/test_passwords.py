"""The password of a database stands in no message, whatever is wrong with the address or the command."""

from __future__ import annotations

from pathlib import Path

import pytest

from data_schema.errors import hide_password, without_passwords
from tests.cli.shell import labbook
from tests.helpers.books import SmallBook

SECRET = "s3cr3t"
URL = f"postgresql+psycopg://lab:{SECRET}@no.such.host.invalid/mybook"


@pytest.mark.parametrize(
    "words",
    [
        ["init", "new", "--as", "Ada Nwosu", "--database", URL.replace("postgresql+psycopg", "postgres")],
        ["init", "book", "--database", URL],
        ["rebuild", "--database", URL.replace("postgresql+psycopg", "mysql")],
        ["rebuild", "--database", URL.replace("psycopg", "no_such_driver")],
        ["rebuild", "--database", URL.replace("/mybook", ":x/mybook")],
        ["rebuild", "--book", "book", URL],
        ["rebuild", f"--databse={URL}"],
        ["init", "new", "--as", "Ada Nwosu", "--database", f"postgresql+psycopg://h.invalid/x?password={SECRET}"],
        ["rebuild", "--database", f"postgres:/lab:{SECRET}@h/mybook"],
        ["rebuild", "--database", f"host=h user=lab password={SECRET}"],
    ],
    ids=[
        "of no driver",
        "of another book",
        "mysql",
        "unknown driver",
        "port",
        "argument",
        "option",
        "as an option",
        "one slash",
        "as libpq",
    ],
)
def test_no_message_has_it(fresh: SmallBook, words: list[str]) -> None:
    at = fresh.folder.parent if words[0] == "init" or "--book" in words else fresh.folder
    for more in ([], ["--json"]):
        answer = labbook(*words, *more, at=at)
        assert answer.code in (2, 3)
        assert SECRET not in answer.out + answer.err
        assert "Traceback" not in answer.err


def test_no_fault_of_labbook_toml_has_it(fresh: SmallBook) -> None:
    fresh.toml.write_text(f'{fresh.toml.read_text()}\n[database]\nurl = "{URL.replace("postgresql", "mysql")}"\n')
    answer = labbook("db", "status", at=fresh.folder)
    assert answer.code == 2
    assert SECRET not in answer.out + answer.err


@pytest.mark.parametrize("password", ["pw", "p@w", "p:w/x", "pass word", "p'w", 'p"w'])
def test_a_sentence_keeps_all_but_the_password(password: str) -> None:
    url = f"postgresql+psycopg://ada:{password}@host:5432/labbook"
    assert hide_password(url) == "postgresql+psycopg://ada:***@host:5432/labbook"
    said = without_passwords(f"{url!r} is none, {'postgresql+psycopg://ada@host/x'!r} would be.")
    assert said.endswith("host/x' would be.")
    assert "***" in said
    assert password not in said


def test_a_book_that_was_never_restored_names_its_database_without_it(fresh: SmallBook, tmp_path: Path) -> None:
    assert labbook("backup", tmp_path / "backup", at=fresh.folder).code == 0
    toml = tmp_path / "backup" / "labbook.toml"
    toml.write_text(f'{toml.read_text()}\n[database]\nurl = "{URL}"\n')
    answer = labbook("restore", tmp_path / "backup", tmp_path / "again", at=tmp_path)
    assert answer.code == 2
    assert SECRET not in answer.out + answer.err
