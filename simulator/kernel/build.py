"""A kernel ready to run for a set of effects, built once a process."""

from __future__ import annotations

import functools
import time
from collections.abc import Iterable
from dataclasses import dataclass

import numba

from simulator.effects.effect import Function
from simulator.kernel.batch import make_batch
from simulator.kernel.cache import compiling_alone, give_unique_symbols, keep_on_disk
from simulator.kernel.composition import Composition, compose


@dataclass(frozen=True, slots=True)
class Kernel:
    """A compiled kernel; `compile_time_s` is what this process spent to compile it or to load it from disk."""

    composition: Composition
    batch: Function
    compile_time_s: float


def kernel_for(effects: Iterable[str]) -> Kernel:
    """Return the kernel for these effects, composed of them and of no others."""
    return _kernel(frozenset(effects))


@functools.lru_cache(maxsize=64)
def _kernel(effects: frozenset[str]) -> Kernel:
    composition = compose(effects)
    started = time.perf_counter()
    give_unique_symbols(composition.effects)
    batch = make_batch(composition)
    if hasattr(batch, "compile"):  # with NUMBA_DISABLE_JIT=1 it is the plain function
        keep_on_disk(batch, composition.effects)
        numbers = numba.float64
        with compiling_alone(composition.effects):
            batch.compile(
                (numbers[:, ::1], numbers[::1], numbers[:, :, ::1], numba.int64[::1], numbers[:, ::1], numbers[:, ::1])
            )
    return Kernel(composition, batch, time.perf_counter() - started)
