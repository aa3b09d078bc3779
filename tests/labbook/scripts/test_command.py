"""`labbook why ID --script FOLDER`: what is written, what is refused, of which state of the book."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.shell import good, labbook
from tests.helpers.books import SmallBook, reported_book
from tests.helpers.scripts import numbers_of_last_report
from tests.helpers.wording import says


@pytest.fixture
def book(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> SmallBook:
    monkeypatch.setenv("LABBOOK_AS", "Ada Nwosu")
    return reported_book(tmp_path / "book")


def id_of(book: SmallBook, kind: str, name: str, *, undefined: bool = False) -> str:
    with book.open() as opened:
        return next(
            uid
            for uid, one in numbers_of_last_report(opened).items()
            if one.numbers.result_of(one.number).kind == kind and one.number.name == name
            if (one.number.value is None) is undefined
        )


def test_a_script_stands_alone(book: SmallBook, tmp_path: Path) -> None:
    number, folder = id_of(book, "decision", "savings"), tmp_path / "number"
    answer = good(labbook("why", number, "--script", folder, "--json", at=book.folder)).json["script"]
    assert {file.name for file in folder.iterdir()} == {"number.py", "runs.csv"}
    text = (folder / "number.py").read_text(encoding="utf-8")
    value = answer["number"]["value"]
    assert text.count(repr(value)) == 1
    assert text.splitlines()[-1] == f"# the report prints {value!r}"
    imported = [str(node.module) for node in ast.walk(ast.parse(text)) if isinstance(node, ast.ImportFrom)]
    assert not [name for name in imported if name.startswith("labbook")]
    says(text, "thesis 5.1.4")
    says(text, "docs/statistics.md")
    done = subprocess.run(
        [sys.executable, "number.py"], cwd=folder, capture_output=True, text=True, check=True, timeout=60
    )
    assert float(done.stdout.splitlines()[0]) == answer["printed"] == pytest.approx(value, rel=1e-9)
    assert {line.split(" = ")[0] for line in done.stdout.splitlines()[1:]} >= {"se", "ci_low", "ci_high", "df"}


def test_one_of_the_book_as_it_was_before_a_correction(book: SmallBook, tmp_path: Path) -> None:
    number = id_of(book, "condition_summary", "mean")
    good(labbook("correct", "r001", "mah=900", "--why", "read wrongly", at=book.folder))
    said = good(labbook("why", number, "--script", tmp_path / "number", at=book.folder)).out
    says(said, "number.py prints", "as the report does")


def test_a_folder_with_files_is_refused(book: SmallBook, tmp_path: Path) -> None:
    number = id_of(book, "decision", "savings")
    (tmp_path / "note.txt").write_text("mine")
    for given in (tmp_path, tmp_path / "note.txt"):
        refused = labbook("why", number, "--script", given, at=book.folder)
        assert refused.code == 2
        says(refused.err, str(given), "not an empty folder")
    assert {file.name for file in tmp_path.iterdir()} == {"book", "note.txt"}


def test_numbers_without_a_value_are_refused(book: SmallBook, tmp_path: Path) -> None:
    folder = tmp_path / "number"
    undefined = labbook("why", id_of(book, "decision", "p", undefined=True), "--script", folder, at=book.folder)
    says(undefined.err, "is undefined, because")
    assert undefined.code == 2
    assert not folder.exists()


def test_r_goes_with_a_folder(book: SmallBook, tmp_path: Path) -> None:
    number, folder = id_of(book, "decision", "p"), tmp_path / "number"
    alone = labbook("why", number, "--r", at=book.folder)
    assert alone.code == 2
    says(alone.err, "--r", "--script")
    good(labbook("why", number, "--script", folder, "--r", at=book.folder))
    assert {file.name for file in folder.iterdir()} == {"number.py", "number.R", "runs.csv"}


def test_a_script_that_prints_another_number_is_an_error(book: SmallBook, tmp_path: Path) -> None:
    import sqlite3

    with sqlite3.connect(book.database) as connection:
        names = [name for (name,) in connection.execute("SELECT name FROM sqlite_master WHERE type = 'trigger'")]
        for name in names:
            connection.execute(f'DROP TRIGGER "{name}"')
        connection.execute("UPDATE charge SET charge_mah = charge_mah + 50 WHERE run IS NOT NULL")
    connection.close()
    number = id_of(book, "passive_drain", "intercept")
    answer = labbook("why", number, "--script", tmp_path / "number", at=book.folder)
    assert answer.code == 3
    says(answer.out, "number.py prints", "the report", "--check")
