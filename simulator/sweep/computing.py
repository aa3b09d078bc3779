"""Who computes the chunks of a sweep: threads on this machine, or the workers of a Dask cluster.

Kernels let the interpreter go while they run, so that threads use all cores. On a cluster the same chunks are sent to
the workers, and the results come back and are stored here: a chunk is a pure function of what is sent, so those of a
worker that is lost are computed again by another. Libraries that only sweeps need may be absent.
"""

from __future__ import annotations

import contextlib
import importlib
from collections.abc import Iterator
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

from data_schema.errors import UsageError
from simulator.sweep.chunks import cores, simulator_here

CHUNKS_A_CORE, FEWEST_WAITING = 4, 32
"""Chunks under way at once: some for every core, and some for workers that join; they bound the memory taken here."""
CONNECT_WITHIN_S = 10


@dataclass(frozen=True, slots=True)
class Computing:
    """What chunks are submitted to, how many at once, and whether this process compiles the kernel for it."""

    executor: Executor
    at_once: int
    here: bool = True


@contextlib.contextmanager
def threads(count: int | None = None) -> Iterator[Computing]:
    """Compute on so many threads, one a core where no number is given."""
    n = count or cores()
    with ThreadPoolExecutor(n) as pool:
        try:
            yield Computing(pool, 2 * n)
        finally:
            pool.shutdown(cancel_futures=True)


@contextlib.contextmanager
def cluster(address: str) -> Iterator[Computing]:
    """Compute on the workers of the scheduler at an address such as tcp://127.0.0.1:8786.

    Raises `UsageError` where there is none, or where a worker has another labbook.
    """
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
        for worker, version in client.run(simulator_here, on_error="return").items():
            if version != simulator_here():
                raise UsageError(
                    f"the worker at {worker} has another simulator ({version}): give it the same labbook, Python and "
                    "numba."
                )
        most = max(FEWEST_WAITING, CHUNKS_A_CORE * sum(client.ncores().values()))
        yield Computing(client.get_executor(pure=False), most, here=False)


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
