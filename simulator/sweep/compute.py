"""Who computes the chunks of a sweep: threads on this machine, or the workers of a Dask cluster.

Kernels let the interpreter go while they run, so that threads use all cores. On a cluster the same chunks are sent to
the workers, and the results come back and are stored here: a chunk is a pure function of what is sent, so those of a
worker that is lost are computed again by another. Libraries that only sweeps need may be absent.
"""

from __future__ import annotations

import contextlib
import importlib
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor, as_completed
from typing import Any, Protocol

import numpy as np

from data_schema.errors import UsageError
from simulator.sweep.chunks import Block, Flags, Recipe, check_simulator, kernel_of, simulate_rows, simulator_here


def optional(module: str, what_for: str) -> Any:
    """Import a library; raises `UsageError` with the command that installs it where it is absent."""
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name is not None and error.name.partition(".")[0] != module.partition(".")[0]:
            raise
        raise UsageError(
            f"{what_for} needs {module}, which is not installed: run `pip install 'robot-labbook[sweeps]'`."
        ) from error


ValuesOf = Callable[[int], tuple[Block, Flags]]
"""Gives the swept values of a chunk, shape (rows, axes), and which of its rows have error bars, shape (rows,)."""
Keep = Callable[[int, Block], None]
"""Takes a chunk that is done, shape (rows, jumps, outputs)."""
CHUNKS_A_CORE, FEWEST_WAITING = 4, 32
"""Chunks under way at once: some for every core, and some for workers that join; they bound the memory taken here."""
CONNECT_WITHIN_S = 10


class Compute(Protocol):
    """Computes chunks, in any order."""

    def prepare(self, recipe: Recipe) -> float:
        """Make ready, so that compiling is not part of the sweep's time; return the seconds that compiling took."""
        ...

    def run(self, recipe: Recipe, values_of: ValuesOf, numbers: Sequence[int], keep: Keep) -> Iterator[int]:
        """Compute the chunks with these numbers, hand each to `keep`, and yield its number when that is done."""
        ...


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def simulate_on_all_cores(recipe: Recipe, values: Block) -> Block:
    """Return what `simulate_rows` does, a part of the rows a core: compiled code does not hold Python's lock."""
    parts = np.array_split(values, cores())
    with ThreadPoolExecutor(len(parts)) as pool:
        return np.concatenate(list(pool.map(lambda part: simulate_rows(recipe, part), parts)))


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
            keep(number, simulate_rows(recipe, *values_of(number)))
            return number

        with ThreadPoolExecutor(self.count) as pool:
            try:
                for done in as_completed([pool.submit(one, number) for number in numbers]):
                    yield done.result()
            finally:
                pool.shutdown(cancel_futures=True)


class Cluster:
    """Computes chunks on the workers of a cluster, through a client of it."""

    def __init__(self, client: Any) -> None:
        self._client = client

    def prepare(self, recipe: Recipe) -> float:
        """Ask the workers for their simulators; each compiles with its first chunk, so that takes no time here."""
        for worker, version in self._client.run(simulator_here, on_error="return").items():
            if not isinstance(version, str):
                raise UsageError(f"the worker at {worker} has no such labbook ({version}): install this one there.")
            check_simulator(recipe, version)
        return 0.0

    def run(self, recipe: Recipe, values_of: ValuesOf, numbers: Sequence[int], keep: Keep) -> Iterator[int]:
        """Compute the chunks with a bounded number of them under way."""
        distributed = optional("distributed", "--scheduler")
        waiting = iter(numbers)
        under_way: dict[Any, int] = {}

        def submit() -> list[Any]:
            for number in waiting:
                future = self._client.submit(simulate_rows, recipe, *values_of(number), pure=False)
                under_way[future] = number
                return [future]
            return []

        most = max(FEWEST_WAITING, CHUNKS_A_CORE * sum(self._client.ncores().values()))
        first = [future for _ in range(most) for future in submit()]
        completed = distributed.as_completed(first, loop=self._client.loop)
        for future in completed:
            try:
                block = future.result()
            except (distributed.KilledWorker, CancelledError, OSError, RuntimeError, ImportError) as error:
                text = " ".join(str(error).split()).partition(". ")[0].rstrip(".")
                raise UsageError(
                    f"the cluster did not finish a chunk ({text or type(error).__name__}): see that its workers have "
                    "this labbook and look at their logs, then give the same command to go on."
                ) from error
            number = under_way.pop(future)
            keep(number, block)
            future.release()
            completed.update(submit())
            yield number


@contextlib.contextmanager
def connect_cluster(address: str) -> Iterator[Cluster]:
    """Connect to the scheduler at an address such as tcp://127.0.0.1:8786; raises `UsageError` where there is none."""
    distributed = optional("distributed", "--scheduler")
    try:
        # a client that fails on this by itself is closed as Python ends, and complains then of a loop that has gone
        distributed.comm.get_address_host_port(address)
        client = distributed.Client(address, timeout=CONNECT_WITHIN_S, set_as_default=False)
    except (OSError, ValueError) as error:
        raise UsageError(
            f"no Dask scheduler answers at {address}: start one with `dask scheduler`, give its tcp:// address, or "
            "leave --scheduler out to use this machine."
        ) from error
    with client:
        yield Cluster(client)
