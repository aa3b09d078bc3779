"""What tests of books share: readings of the same files, and reports of small books, each made once."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from labbook.actions.report_command import state_report
from labbook.presenting.report.content import MadeReport
from tests.helpers.books import ADA, DAYS, import_sheet, ingest_all, small_book
from tests.helpers.readings import read_once

Reports = Callable[..., MadeReport]
CONFOUNDED = f"b_ad_gain == 0 and day == {DAYS[0]} or b_ad_gain == 100 and day == {DAYS[1]}"
"""Runs of the control on one day and of active damping on the other."""


@pytest.fixture(scope="session", autouse=True)
def _files_are_read_once() -> Iterator[None]:
    """Processes of their own read each file anew; `tests/ingest` looks at readings."""
    with read_once():
        yield


@pytest.fixture(scope="session")
def reports(tmp_path_factory: pytest.TempPathFactory) -> Reports:
    """Reports of small books by what `[analysis]` says (`in_time`: before the first measurement), and by selection."""

    @functools.cache
    def made(analysis: str = "", where: str | None = None, *, in_time: bool = False) -> MadeReport:
        folder: Path = tmp_path_factory.mktemp("comparisons")
        book = small_book(folder, runs=not in_time, ingested=not in_time)
        if analysis:
            book.toml.write_text(f"{book.toml.read_text()}\n[analysis]\n{analysis}\n")
        with book.open() as opened:
            if in_time:
                import_sheet(opened, book.instruments / "runs.csv")
                ingest_all(opened, book.instruments)
            return state_report(opened, where, ADA, lambda _step: None)

    return made
