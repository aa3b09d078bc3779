"""Compiled entries beside the kernel's own, kept on disk with it and forgotten with it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from simulator.compiled import compiled
from simulator.effects.effect import Function
from simulator.kernel.cache import give_unique_symbols, keep_on_disk


def kept(function: Function, types: tuple[Any, ...], what: str, effects: Iterable[str]) -> Function:
    """Compile a function that Python calls with arguments of these numba types, or load it from disk.

    It is composed for `effects`; `what` tells it from the others that are.
    """
    name = (what, *effects)
    entry = compiled(function)
    if hasattr(entry, "compile"):  # with NUMBA_DISABLE_JIT=1 it is the plain function
        give_unique_symbols(name)
        keep_on_disk(entry, name)
        entry.compile(types)
    return entry
