"""Work that a copy of this process does on another core, while this one goes on."""

from __future__ import annotations

import os
import pickle
import signal
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Generic, TypeVar

T = TypeVar("T")


def has_core() -> bool:
    """Whether a copy of this process can work on a core of its own: elsewhere than on Linux libraries forbid copies."""
    return sys.platform == "linux" and len(os.sched_getaffinity(0)) > 1


@dataclass(frozen=True, slots=True)
class SecondProcess(Generic[T]):
    """A copy of this process at work, to be asked once for its result."""

    process: int
    answer: IO[bytes]

    def result(self) -> T | None:
        """Wait for what the work returned; None where it failed, so that whoever asks does it."""
        with self.answer:
            pickled = self.answer.read()
        os.waitpid(self.process, 0)
        try:
            found: T = pickle.loads(pickled)  # noqa: S301 - from this process's copy
        except (EOFError, pickle.UnpicklingError):  # it was killed, or its work failed
            return None
        return found

    def stop(self) -> None:
        """End the work where its result has not been asked for."""
        if not self.answer.closed:
            self.answer.close()
            os.kill(self.process, signal.SIGKILL)
            os.waitpid(self.process, 0)


def run_in_fork(work: Callable[[], T]) -> SecondProcess[T]:
    """Run some work in a fork of this process; its result is pickled.

    The work may use no connection to a database that this process has opened, and print nothing. SQLite's locks are the
    process', so that it may open one of its own only to a file to which this one has none.
    """
    out, into = os.pipe()
    with warnings.catch_warnings():
        # Python warns of threads: those of the progress bar and of BLAS hold no lock that the work asks for.
        warnings.simplefilter("ignore", DeprecationWarning)
        copy = os.fork()
    if copy:
        os.close(into)
        return SecondProcess(copy, os.fdopen(out, "rb"))
    try:
        os.close(out)
        with Path(os.devnull).open("w") as nothing, os.fdopen(into, "wb") as answer:
            sys.stdout = sys.stderr = nothing
            answer.write(pickle.dumps(work()))
    finally:
        os._exit(0)  # whatever happened: nothing of the process that it is a fork of is closed or printed twice
