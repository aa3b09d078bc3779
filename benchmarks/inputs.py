"""Input of the benchmarks: one 12-minute log, small logs, and a new book to take them in."""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np

from data_schema.vocabulary import RunKind
from labbook.book.making import make_book
from labbook.book.opening import CONFIGURATION
from labbook.demo.campaign import Campaign, make_campaign
from labbook.demo.files import book_toml
from labbook.demo.logger import DECIMALS, RunLog, run_log
from labbook.demo.truth import CHAPTER_5
from labbook.demo.writers import string_pot_log

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
