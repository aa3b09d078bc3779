"""Input of the benchmarks: one 12-minute log, runs by the thousand, and a new book to take them in."""

from __future__ import annotations

import datetime as dt
import functools
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.timing import Work
from data_schema.vocabulary import RunKind
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.book.making import make_book
from labbook.book.opening import CONFIGURATION, Book, open_book
from labbook.demo.campaign import BATTERIES, Campaign, make_campaign
from labbook.demo.files import book_toml
from labbook.demo.logger import DECIMALS, RunLog, run_log
from labbook.demo.truth import CHAPTER_5
from labbook.demo.writers import SheetRun, string_pot_log

SEED = 1
CONVERTER_STEPS = {"body_height [m]": 0.8 / 2**12, "battery_voltage [V]": 0.005}
"""The demonstration's logs show these two channels in whole steps of a converter."""


@functools.cache
def campaign() -> Campaign:
    """Draw the demonstration's campaign."""
    return make_campaign(SEED)


def full_log(number: int = 0) -> RunLog:
    """Record the whole 12 minutes of one of the campaign's runs with jumps."""
    drawn = campaign()
    return run_log(SEED, drawn.truth, drawn.of_kind(RunKind.JUMPS)[number], full=True)


@functools.cache
def big_log() -> bytes:
    """Write a 12-minute log at 300 Hz: time and 8 channels, half of them noisy to the sixth decimal, half held.

    The two channels in converter steps get noise within a step, so that no channel is easier than the others.
    """
    log = full_log()
    rng = np.random.default_rng(SEED)
    noisy = {
        name: log.channels[name] + step * (rng.random(log.time_ms.size) - 0.5) for name, step in CONVERTER_STEPS.items()
    }
    return string_pot_log(log.time_ms, {**log.channels, **noisy}, DECIMALS)


def new_book(folder: Path) -> Path:
    """Make an empty book with the demonstration's configuration."""
    folder.mkdir(parents=True)
    (folder / CONFIGURATION).write_bytes(book_toml(CHAPTER_5))
    make_book(folder, None)
    return folder


def ingest_anew(path: Path) -> Work:
    """Take a file into a new book beside it."""

    def prepare() -> Book:
        return open_book(new_book(path.parent / "book"))

    def clear(book: Book) -> None:
        book.close()
        shutil.rmtree(book.folder)

    return Work(lambda book: ingest_file(book, path, IngestRequest()), prepare, clear)


_FEET = sorted({group.foot for group in CHAPTER_5.groups})
_K_GAINS = sorted({group.k_gain for group in CHAPTER_5.groups})


def run_name(number: int) -> str:
    """Return the name of a run of a large book."""
    return f"r{number:06d}"


def nth_run(number: int, runs_a_day: int, first: dt.date = dt.date(2001, 1, 1), **facts: Any) -> SheetRun:
    """Return a run of a large book, 40 minutes after the one before; conditions and packs take turns."""
    day, position = divmod(number, runs_a_day)
    started = dt.datetime.combine(first, dt.time(7)) + dt.timedelta(days=day, minutes=40 * position)
    levels = {
        "foot": _FEET[number % len(_FEET)],
        "k_gain": _K_GAINS[number // len(_FEET) % len(_K_GAINS)],
        "b_ad_gain": CHAPTER_5.ad_gains[number % len(CHAPTER_5.ad_gains)],
    }
    usual: dict[str, Any] = {"kind": RunKind.JUMPS, "levels": levels, "duration_s": 720, "jumps_made": 25}
    return SheetRun(
        name=run_name(number),
        started=started,
        position=position + 1,
        battery=BATTERIES[number % len(BATTERIES)],
        recharge_ended=started + dt.timedelta(minutes=39),
        **usual | facts,
    )
