"""Lists too long for one query: an engine takes a limited number of values at once (SQLite: 32766)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TypeVar

Item = TypeVar("Item")

CHUNK = 500


def in_chunks(items: Sequence[Item]) -> Iterator[Sequence[Item]]:
    """Pass a list on in pieces that fit into a query, in order."""
    for start in range(0, len(items), CHUNK):
        yield items[start : start + CHUNK]
