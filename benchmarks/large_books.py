"""Books of any number of runs, made as a lab makes them: run sheets, logs, charger sheets, verdicts, corrections.

Every statement goes through the functions of the commands, so that the journal is a genuine one. The logs are short:
one run of 25 jumps at 300 Hz without the pauses, of its own noise each.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.inputs import new_book, nth_run, run_name
from data_schema.units import STANDARD_GRAVITY_M_S2
from data_schema.vocabulary import IngestStatus, ReasonCode, Verdict
from ingest.tables.sheet import SheetFile
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.runs.correcting import correct
from labbook.actions.runs.jump_review import decide
from labbook.actions.runs.runs_importing import import_runs
from labbook.book.opening import Book, opened
from labbook.book.write_session import new_uid
from labbook.demo.files import FACTORS
from labbook.demo.writers import SheetRun, charger_sheet, run_sheet, string_pot_log

RATE_HZ, JUMPS, RUNS_A_DAY = 300, 25, 12
AT_ONCE = 1000
"""So many runs have a run sheet, a folder of logs and a charger sheet together."""
VERDICT_EVERY, CORRECTION_EVERY = 50, 100
_REST_LENGTH_M, _START_M, _CLAMP_M = 0.27, 0.42, 0.46


@dataclass(frozen=True, slots=True)
class Grown:
    """What taking in some runs took: `ingest_s` of their logs alone."""

    runs: int
    ingest_s: float


def grow_book(folder: Path, first: int, last: int, say: Callable[[str], None]) -> Grown:
    """Add the runs `first` to `last` - 1, at most `AT_ONCE`, to a book, which is made where there is none."""
    if not folder.exists():
        new_book(folder)
    with opened(folder) as book:
        grown = _take_in(book, range(first, last), folder.parent / f"{folder.name}-instruments")
    say(f"{last} runs, {grown.ingest_s / grown.runs * 1e3:.1f} ms a log")
    return grown


def _take_in(book: Book, numbers: range, instruments: Path) -> Grown:
    with book.session(None) as session:
        sheet = run_sheet(FACTORS, map(_row, numbers))
        import_runs(book, session, SheetFile(f"runs-{numbers.start}.csv", sheet))
    instruments.mkdir(exist_ok=True)
    request, taken_s = IngestRequest(batch=new_uid()), 0.0
    for number in numbers:
        taken_s += _ingest(book, instruments / f"{run_name(number)}.csv", log_of(number), request)
    _ingest(book, instruments / f"charges-{numbers.start}.csv", charger_sheet(map(_row, numbers)), request)
    for number in numbers:
        with book.session(None) as session:
            if number % VERDICT_EVERY == 0:
                decide(book, session, run_name(number), [3], Verdict.REJECT, ReasonCode.TOUCHED_BY_HAND, None)
            if number % CORRECTION_EVERY == 0:
                correct(book, session, run_name(number), ["duration_s=719"], "misread the clock")
    return Grown(len(numbers), taken_s)


def _ingest(book: Book, path: Path, data: bytes, request: IngestRequest) -> float:
    path.write_bytes(data)
    start = time.perf_counter()
    outcome = ingest_file(book, path, request)
    taken_s = time.perf_counter() - start
    path.unlink()
    if outcome.status is not IngestStatus.IMPORTED:
        raise RuntimeError(f"{path.name} was not taken in: {outcome.status}")
    return taken_s


def log_of(number: int) -> bytes:
    """Return the log of a run: dropped, stance, flight, caught, lifted, 25 times."""
    rng = np.random.default_rng([1, number])
    pieces = [np.full(RATE_HZ // 5, _CLAMP_M)]
    for apex_m in 0.33 + 0.01 * rng.normal(size=JUMPS):
        falling_s = np.arange(int(RATE_HZ * _fall_s(_START_M - _REST_LENGTH_M))) / RATE_HZ
        stance = np.arange(RATE_HZ // 10) / (RATE_HZ // 10)
        rising_s = _fall_s(apex_m - _REST_LENGTH_M)
        flight_s = np.arange(int(RATE_HZ * 1.6 * rising_s)) / RATE_HZ
        flight_m = apex_m - STANDARD_GRAVITY_M_S2 * (flight_s - rising_s) ** 2 / 2
        lifted_m = np.concatenate([np.linspace(flight_m[-1], _CLAMP_M, 45), np.linspace(_CLAMP_M, _START_M, 20)])
        fallen_m = _START_M - STANDARD_GRAVITY_M_S2 * falling_s**2 / 2
        pieces += [fallen_m, _REST_LENGTH_M - 0.1 * np.sin(np.pi * stance), flight_m, lifted_m]
    height_m = np.concatenate(pieces)
    time_ms = 15_000 + np.arange(height_m.size) * 1000 // RATE_HZ
    name = "body_height [m]"
    return string_pot_log(time_ms, {name: height_m + rng.normal(0, 0.001, height_m.size)}, {name: 4})


def _fall_s(height_m: float) -> float:
    return float(np.sqrt(2 * height_m / STANDARD_GRAVITY_M_S2))


def _row(number: int) -> SheetRun:
    return nth_run(number, RUNS_A_DAY, charge_mah=780 + number * 7919 % 97)
