"""Timing of pieces of work in turns, so that what else the machine does falls on all of them alike."""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True, slots=True)
class Work:
    """One thing to time: `run` is given what `prepare` made; preparing and clearing are not timed."""

    run: Callable[[Any], object]
    prepare: Callable[[], Any] = lambda: None
    clear: Callable[[Any], object] = lambda _prepared: None


@dataclass(frozen=True, slots=True)
class Times:
    """Wall times of the repeats of one work, seconds."""

    seconds: tuple[float, ...]

    @property
    def minimum(self) -> float:
        """The least disturbed repeat."""
        return min(self.seconds)

    @property
    def median(self) -> float:
        """What the machine gave in the middle of its day."""
        return statistics.median(self.seconds)


def in_turns(works: Mapping[str, Work], repeats: int, warm_ups: int = 1) -> dict[str, Times]:
    """Time every work `repeats` times, one after the other, round by round; the first rounds do not count."""
    seconds: dict[str, list[float]] = {name: [] for name in works}
    for turn in range(warm_ups + repeats):
        for name, work in works.items():
            taken = once(work)
            if turn >= warm_ups:
                seconds[name].append(taken)
    return {name: Times(tuple(found)) for name, found in seconds.items()}


def once(work: Work) -> float:
    """Time one work once."""
    prepared = work.prepare()
    gc.collect()
    start = time.perf_counter()
    work.run(prepared)
    taken = time.perf_counter() - start
    work.clear(prepared)
    return taken
