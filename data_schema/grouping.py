"""Items by a key of theirs."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from typing import TypeVar

T = TypeVar("T")
K = TypeVar("K", bound=Hashable)


def grouped(items: Iterable[T], key: Callable[[T], K]) -> dict[K, list[T]]:
    """Return items by their keys, both in the order of first occurrence.

    >>> grouped(["r1", "q1", "r2"], lambda name: name[0])
    {'r': ['r1', 'r2'], 'q': ['q1']}
    """
    found: dict[K, list[T]] = {}
    for item in items:
        found.setdefault(key(item), []).append(item)
    return found
