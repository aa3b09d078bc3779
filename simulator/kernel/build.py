"""A kernel ready to run for a set of effects, built once a process."""

from __future__ import annotations

import functools
import time
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numba

from simulator.effects.effect import Function
from simulator.kernel.batch import make_batch
from simulator.kernel.cache import compiling_alone, give_unique_symbols, keep_on_disk, on_disk
from simulator.kernel.composition import Composition, compose


@dataclass(frozen=True, slots=True)
class Kernel:
    """A kernel ready to run; `compile_time_s` is what this process spent to compile it or to load it from disk.

    It is `interpreted` where it runs in plain Python, with no time to compile.
    """

    composition: Composition
    batch: Function
    compile_time_s: float
    interpreted: bool = False


def kernel_for(effects: Iterable[str]) -> Kernel:
    """Return the kernel for these effects, composed of them and of no others."""
    return _kernel(frozenset(effects))


@functools.lru_cache(maxsize=64)
def composed(effects: frozenset[str]) -> tuple[Composition, Any]:
    """Compose a kernel; its entry knows its place on disk, and is not compiled yet."""
    composition = compose(effects)
    batch = make_batch(composition)
    if hasattr(batch, "compile"):  # with NUMBA_DISABLE_JIT=1 it is the plain function
        keep_on_disk(batch, composition.effects)
    return composition, batch


def is_kept(effects: frozenset[str]) -> bool:
    """Whether later processes need not compile a kernel: it is on disk, or nothing is ever compiled here."""
    batch = composed(effects)[1]
    return not hasattr(batch, "compile") or on_disk(batch)


def is_compiled(effects: frozenset[str]) -> bool:
    """Whether a kernel is there without compiling: it is kept, or this process has compiled it."""
    return is_kept(effects) or bool(composed(effects)[1].signatures)


@functools.lru_cache(maxsize=64)
def _kernel(effects: frozenset[str]) -> Kernel:
    composition, batch = composed(effects)
    started = time.perf_counter()
    if hasattr(batch, "compile"):
        give_unique_symbols(composition.effects)
        numbers = numba.float64
        with compiling_alone(composition.effects):
            batch.compile(
                (numbers[:, ::1], numbers[::1], numbers[:, :, ::1], numba.int64[::1], numbers[:, ::1], numbers[:, ::1])
            )
    return Kernel(composition, batch, time.perf_counter() - started, interpreted=not hasattr(batch, "compile"))
