"""Items by their keys."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from typing import TypeVar

T = TypeVar("T")
K = TypeVar("K", bound=Hashable)


def grouped(items: Iterable[T], keys: Iterable[K]) -> dict[K, list[T]]:
    """Return items by their keys, one an item, both in the order of first occurrence.

    >>> grouped([17.6, 15.8, 17.2], ["CE", "AD", "CE"])
    {'CE': [17.6, 17.2], 'AD': [15.8]}
    """
    found: dict[K, list[T]] = {}
    for item, key in zip(items, keys, strict=True):
        found.setdefault(key, []).append(item)
    return found
