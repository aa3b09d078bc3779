"""Timing of pieces of work in turns, so that what else the machine does falls on all of them alike."""

from __future__ import annotations

import gc
import resource
import statistics
import time
from collections.abc import Callable, Mapping, Sequence
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
    """Wall and processor times of the repeats of one work, seconds; the latter of all threads and ended processes."""

    seconds: tuple[float, ...]
    cpu_seconds: tuple[float, ...]

    @property
    def minimum(self) -> float:
        """The least disturbed repeat."""
        return min(self.seconds)

    @property
    def median(self) -> float:
        """What the machine gave in the middle of its day."""
        return statistics.median(self.seconds)

    @property
    def cpu_minimum(self) -> float:
        """The least processor time of a repeat."""
        return min(self.cpu_seconds)


def in_turns(works: Mapping[str, Work], repeats: int, warm_ups: int = 1) -> dict[str, Times]:
    """Time every work `repeats` times, one after the other, round by round; the first rounds do not count."""
    taken: dict[str, list[tuple[float, float]]] = {name: [] for name in works}
    for turn in range(warm_ups + repeats):
        for name, work in works.items():
            once = _once(work)
            if turn >= warm_ups:
                taken[name].append(once)
    return {name: Times(*zip(*found, strict=True)) for name, found in taken.items()}


def together(parts: Sequence[Times]) -> Times:
    """Add up works that were timed round by round."""
    seconds = tuple(sum(found) for found in zip(*(part.seconds for part in parts), strict=True))
    return Times(seconds, tuple(sum(found) for found in zip(*(part.cpu_seconds for part in parts), strict=True)))


def _once(work: Work) -> tuple[float, float]:
    """Time one work once: wall and processor time."""
    prepared = work.prepare()
    gc.collect()
    start, start_cpu = time.perf_counter(), _cpu()
    work.run(prepared)
    taken, taken_cpu = time.perf_counter() - start, _cpu() - start_cpu
    work.clear(prepared)
    return taken, taken_cpu


def _cpu() -> float:
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(item.ru_utime + item.ru_stime for item in used)
