"""What tests of books share: readings of the same files, and reports of small books, each made once."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from ingest.formats import registry
from ingest.formats.format import Format
from ingest.model import Declarations, ReadFile, SignalPart
from ingest.read import read_file
from labbook.actions.report_command import state_report
from labbook.analysis.outcomes.detection import Detection, detect_part
from labbook.analysis.study import Analysis
from stats.apexes.detectors import DETECTORS, Detector
from tests.helpers.books import ADA, DAYS, SmallBook, import_sheet, ingest_all, small_book
from tests.helpers.decided import decided_book
from tests.helpers.desk import Desk, desk_at
from tests.helpers.whole_book import copy_of_judged_book, copy_of_whole_book

Reports = Callable[..., Analysis]
CONFOUNDED = f"b_ad_gain == 0 and day == {DAYS[0]} or b_ad_gain == 100 and day == {DAYS[1]}"
"""Runs of the control on one day and of active damping on the other."""


MOST = 512
"""So many are remembered: more than the files of any test."""
_READERS = (
    "labbook.actions.files.ingesting",
    "labbook.actions.files.rereading",
    "labbook.statements.importing",
    "labbook.statements.ingesting",
)


@dataclass(frozen=True, slots=True)
class _Asked:
    """All that a reading depends on."""

    data: bytes
    declared: Declarations = field(hash=False)
    formats: tuple[Format, ...] = field(hash=False)


@pytest.fixture(scope="session", autouse=True)
def _files_are_read_once() -> Iterator[None]:
    """Let books have what was read of the same bytes under the same declarations before, and the jumps found in it.

    Samples cannot be written to, so that no book changes those of another. Processes of their own read each file anew;
    `tests/ingest` looks at readings.
    """

    @functools.lru_cache(MOST)
    def read(asked: _Asked) -> ReadFile:
        found = read_file(asked.data, asked.declared)
        for part in found.parts:
            for values in (part.time_s, *(channel.values for channel in part.channels)):
                values.flags.writeable = False
        return found

    @functools.lru_cache(MOST)
    def detected(part: SignalPart, algorithm: str, rest_length_m: float | None, _by: Detector) -> Detection | None:
        return detect_part(part, algorithm, rest_length_m)

    with pytest.MonkeyPatch.context() as patch:
        for module in _READERS:
            patch.setattr(
                f"{module}.read_file", lambda data, declared: read(_Asked(data, declared, registry.all_formats()))
            )
        patch.setattr(
            "labbook.statements.importing.detect_part",
            lambda part, algorithm, rest_length_m: detected(part, algorithm, rest_length_m, DETECTORS[algorithm]),
        )
        yield


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    with desk_at(tmp_path) as desk:
        yield desk


@pytest.fixture
def honest(tmp_path: Path) -> SmallBook:
    """A book whose analysis was decided before everything was ingested."""
    return decided_book(tmp_path)


@pytest.fixture
def whole(tmp_path: Path) -> SmallBook:
    """A book in which everything has happened."""
    return copy_of_whole_book(tmp_path)


@pytest.fixture
def judged(tmp_path: Path) -> SmallBook:
    """The same without reports, for what needs none: it is rebuilt in a quarter of the time."""
    return copy_of_judged_book(tmp_path)


@pytest.fixture(scope="session")
def reports(tmp_path_factory: pytest.TempPathFactory) -> Reports:
    """Reports of small books by what `[analysis]` says (`in_time`: before the first measurement), and by selection."""

    @functools.cache
    def made(analysis: str = "", where: str | None = None, *, in_time: bool = False) -> Analysis:
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
