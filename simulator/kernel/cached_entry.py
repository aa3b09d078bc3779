"""Compiled entries beside the kernel's own, cached on disk with it and removed with it."""

from __future__ import annotations

import functools
import hashlib
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from simulator.compiled import compiled
from simulator.effects.effect import Function
from simulator.kernel.cache import compiling_alone, give_unique_symbols, keep_on_disk


def cached_entry(function: Function, types: tuple[Any, ...], what: str, effects: Iterable[str]) -> Function:
    """Compile a function that Python calls with arguments of these numba types, or load it from disk.

    It is composed for `effects`; `what` distinguishes it from other entries for them. The fingerprint of the kernels
    does not include the module that defines it, so the name includes that module's hash.
    """
    name = (what, _source_hash(function.__module__), *effects)
    entry = compiled(function)
    if hasattr(entry, "compile"):  # with NUMBA_DISABLE_JIT=1 it is the plain function
        give_unique_symbols(name)
        keep_on_disk(entry, name)
        with compiling_alone(name):
            entry.compile(types)
    return entry


@functools.cache
def _source_hash(module: str) -> str:
    return hashlib.sha256(Path(str(sys.modules[module].__file__)).read_bytes()).hexdigest()[:20]
