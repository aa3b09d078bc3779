from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from tests.helpers.books import SmallBook, small_book


@pytest.fixture(autouse=True)
def _nobody_speaks_by_default(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("LABBOOK_AS", raising=False)
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("NO_COLOR", "1")


@pytest.fixture
def fresh(tmp_path: Path) -> SmallBook:
    """A book without runs and files, and the instruments' files beside it."""
    return small_book(tmp_path, runs=False, ingested=False)


@pytest.fixture
def stated(tmp_path: Path) -> SmallBook:
    """A book whose runs are stated; no file is ingested."""
    return small_book(tmp_path, ingested=False)


@pytest.fixture
def changed(book: Path, tmp_path: Path) -> Path:
    """A copy of the book that tests of a file only read, whose labbook.toml may be changed."""
    return shutil.copytree(book, tmp_path / "book")


@pytest.fixture
def whole(tmp_path: Path) -> SmallBook:
    """A book with runs, logs and charges."""
    return small_book(tmp_path)
