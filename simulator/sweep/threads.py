"""A sweep on all cores of this machine: threads, since kernels let the interpreter go while they run."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed

from simulator.sweep.chunks import Recipe, kernel_of, simulate_rows
from simulator.sweep.compute import Keep, ValuesOf


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Threads:
    """Computes chunks on so many threads, one a core where no number is given."""

    def __init__(self, count: int | None = None) -> None:
        self.count = count or cores()

    def prepare(self, recipe: Recipe) -> float:
        """Compile the kernel; return the seconds that took."""
        return kernel_of(recipe).compile_time_s

    def run(self, recipe: Recipe, values_of: ValuesOf, numbers: Sequence[int], keep: Keep) -> Iterator[int]:
        """Compute the chunks; each thread keeps its own, so that no more of them than threads are in memory."""

        def one(number: int) -> int:
            keep(number, simulate_rows(recipe, values_of(number)))
            return number

        with ThreadPoolExecutor(self.count) as pool:
            try:
                for done in as_completed([pool.submit(one, number) for number in numbers]):
                    yield done.result()
            finally:
                pool.shutdown(cancel_futures=True)
