"""Kernels that nothing has compiled yet, in plain Python, for those who want a few jumps.

A kernel takes some 20 s to compile; a jump takes a fraction of a second in plain Python, which is the same code and
gives the same bits (`NUMBA_DISABLE_JIT=1`). numba reads that variable when it is loaded, so it is another process that
simulates (`python -m simulator.kernel.interpreter`), one for all kernels.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import os
import pickle
import subprocess
import sys
import time
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from threading import Lock
from typing import IO, Any, cast

import numpy as np

from simulator.kernel.build import Kernel, composed, is_compiled, kernel_for

PATIENCE_S = 10.0
"""Time in plain Python after which a kernel is compiled."""
_ENTRY = "simulator.kernel.interpreter"


def kernel_for_few(effects: Iterable[str]) -> Kernel:
    """Return the kernel for a few jumps: compiled where it is already, else in plain Python while that is quick.

    Its arrays are filled as by the compiled one, bit for bit. After `PATIENCE_S` it is compiled after all.
    """
    chosen = frozenset(effects)
    return kernel_for(chosen) if is_compiled(chosen) else _interpreted(chosen)


def lost_time_s(kernel: Kernel) -> float:
    """Return how long answers of the interpreted kernel were waited for that did not come."""
    return kernel.batch.lost_s if isinstance(kernel.batch, _Interpreted) else 0.0


@functools.lru_cache(maxsize=64)
def _interpreted(effects: frozenset[str]) -> Kernel:
    return Kernel(composed(effects)[0], _Interpreted(effects, PATIENCE_S), compile_time_s=0.0, interpreted=True)


@dataclass(slots=True)
class _Interpreted:
    """A kernel's entry, `(table, limits, rows, counts, changes, trace)`, and how long it may still be interpreted.

    `lost_s` is the time of an answer that was not waited for.
    """

    effects: frozenset[str]
    left_s: float
    lost_s: float = 0.0

    def __call__(self, *arguments: Any) -> None:
        started = time.perf_counter()
        filled = _interpreter.ask(self.effects, arguments, self.left_s) if self.left_s > 0.0 else None
        spent_s = time.perf_counter() - started
        self.left_s -= spent_s
        if filled is None:
            self.left_s, self.lost_s = 0.0, self.lost_s + spent_s
            kernel_for(self.effects).batch(*arguments)
            return
        for array, found in zip(arguments[-len(filled) :], filled, strict=True):
            array[...] = found


class Interpreter:
    """The other process, started when it is first asked, and the thread that waits for its answers."""

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Start without a process, as after a fork: it answers the one that started it."""
        self.process: subprocess.Popen[bytes] | None = None
        self.waiting, self.alone = ThreadPoolExecutor(1), Lock()

    def ask(self, effects: frozenset[str], arguments: tuple[Any, ...], patience_s: float) -> list[Any] | None:
        """Return the arrays that the kernel fills; None without an answer in time, and the process has ended."""
        with self.alone:
            process = self.process or self._start()
            try:
                pickle.dump((effects, arguments), cast(IO[bytes], process.stdin))
                cast(IO[bytes], process.stdin).flush()
                answer = self.waiting.submit(pickle.load, cast(IO[bytes], process.stdout)).result(patience_s)
            except (TimeoutError, EOFError, OSError, pickle.UnpicklingError):  # it takes long, or it was killed
                self.end()
                return None
            except BaseException:  # Ctrl-C is for this process, which ends the other
                self.end()
                raise
            filled: list[Any] = answer
            return filled

    def _start(self) -> subprocess.Popen[bytes]:
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-m", _ENTRY],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, "NUMBA_DISABLE_JIT": "1"},
            start_new_session=True,
        )
        return self.process

    def end(self) -> None:
        """End the process at once."""
        if self.process is not None:
            self.process.kill()
            with contextlib.suppress(OSError):
                self.process.communicate()
            self.process = None


_interpreter = Interpreter()
atexit.register(_interpreter.end)
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_interpreter.forget)


def main() -> None:
    """Answer calls of kernels until there are no more."""
    calls, answers = sys.stdin.buffer, sys.stdout.buffer
    with np.errstate(all="ignore"), contextlib.suppress(EOFError):  # as compiled code, which has no warnings
        while True:
            effects, (table, limits, *filled) = pickle.load(calls)  # noqa: S301 - from the process that started this
            kernel_for(effects).batch(table, limits, *filled)
            pickle.dump(filled, answers)
            answers.flush()


if __name__ == "__main__":
    main()
