"""docs/export.md: what it has people write works, on a book of the name that it has."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cli.shell import good, labbook
from tests.helpers.books import small_book

PAGE = (Path(__file__).parents[2] / "docs" / "export.md").read_text(encoding="utf-8")


def block(language: str) -> str:
    found = re.search(rf"```{language}\n(.+?)```", PAGE, re.DOTALL)
    assert found is not None
    return found[1]


def test_its_python_runs(tmp_path: Path) -> None:
    book = small_book(tmp_path).folder
    code = block("python").replace('"k_gain=300"', '"k_gain=400"')  # a level of this book
    (tmp_path / "mybook").symlink_to(book)
    done = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "joule" in done.stdout or "energy" in done.stdout


def test_its_commands_and_its_r_run(tmp_path: Path) -> None:
    book = small_book(tmp_path).folder
    commands = re.findall(r"^    labbook (.+)$", PAGE, re.MULTILINE)
    assert len(commands) == 3
    for words in commands:
        good(labbook(*(word.strip('"') for word in words.split()), at=book))
    assert (book / "tables" / "runs.csv").is_file()
    assert (book / "r001.mcap").is_file()
    assert (book / "tables_2021" / "runs.parquet").is_file()
    if shutil.which("Rscript") is None:
        pytest.skip("R is not installed: its example is not run")
    done = subprocess.run(["Rscript", "-e", block("r")], cwd=book, capture_output=True, text=True, check=True)
    assert "joules_J" in done.stdout
