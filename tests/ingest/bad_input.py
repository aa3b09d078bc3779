"""A clean synthetic log of 600 rows with one thing wrong, and the outcome that must come of it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tests.ingest.reading import read
from tests.ingest.synthetic import LOG_HEADER, robot_log, robot_rows, text

LOG = robot_log()
ROWS = robot_rows()
REFUSED = None


@dataclass(frozen=True)
class Case:
    """A file, the rules that must be found, and how many rows must be kept, or `REFUSED`."""

    name: str
    data: bytes
    rules: str = ""
    kept: int | None = len(ROWS)


def counting(cell: str, n: int = 300) -> bytes:
    """A log of one column of the same cell."""
    return text("time [ms];counts", [f"{number};{cell}" for number in range(n)])


def with_column(name: str, cell: str) -> bytes:
    """The log with a further column of the same cell."""
    return text(f"{LOG_HEADER},{name}", [f"{row},{cell}" for row in ROWS])


def with_row(row: str, at: int = 50) -> bytes:
    """The log with another row 50 (line 52)."""
    return text(LOG_HEADER, [*ROWS[:at], row, *ROWS[at + 1 :]])


def with_cell(cell: str, column: int = 1, at: int = 50) -> bytes:
    """The log with another cell in row 50."""
    cells = ROWS[at].split(",")
    cells[column] = cell
    return with_row(",".join(cells), at)


def with_times(change: Callable[[int, int], object], header: str = "time [ms]") -> bytes:
    """The log with each time stamp replaced: `change(row, milliseconds)`."""
    rows = []
    for number, row in enumerate(ROWS):
        stamp, rest = row.split(",", 1)
        rows.append(f"{change(number, int(stamp))},{rest}")
    return text(header + LOG_HEADER.removeprefix("time [ms]"), rows)


def with_heights(change: Callable[[float], object], header: str = "height [m]") -> bytes:
    """The log with each height replaced."""
    rows = [row.split(",") for row in ROWS]
    changed = [",".join([cells[0], str(change(float(cells[1]))), *cells[2:]]) for cells in rows]
    return text(LOG_HEADER.replace("height [m]", header), changed)


def clock(milliseconds: int) -> str:
    seconds, rest = divmod(milliseconds, 1000)
    return f"{seconds // 3600 % 24:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}.{rest:03d}"


def check(case: Case) -> None:
    """Assert that the file has its outcome, and that what is kept whole equals the clean log."""
    result = read(case.data)
    assert set(case.rules.split()) <= {finding.rule for finding in result.findings}
    assert (None if result.refused else result.rows_kept) == case.kept
    if case.kept == len(ROWS):
        (clean,) = read(LOG).parts
        legs = [c.values for part in result.parts for c in part.channels if c.name == "leg_length"]
        assert np.array_equal(np.concatenate(legs), clean.channels[1].values)


def check_one_row_lost(case: Case, kind: str) -> None:
    """Assert that row 50 alone is missing and that a gap of this kind says so."""
    (part,) = read(case.data).parts
    assert len(part.time_s) == len(ROWS) - 1
    lost = [gap for gap in part.gaps if abs(gap.start_s - 0.163) < 1e-9]
    assert [(gap.samples_missing, round(gap.length_s, 9), gap.kind) for gap in lost] == [(1, 0.007, kind)]
