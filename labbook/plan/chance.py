"""Chance that is the same for the same seed in every version of every library.

Word `i` (from 0) of a seed is the first 8 bytes, big endian, of the SHA-256 of the ASCII text `labbook {seed} {i}`. A
number below `n` is the first word below the largest multiple of `n`, modulo `n`, so that no number is favoured. Lists
are shuffled from the last place down (Fisher and Yates 1938; Durstenfeld, Communications of the ACM 7, 1964).
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable
from typing import TypeVar

_Item = TypeVar("_Item")
_WORDS = 2**64


class SeededChance:
    """A source of chance; what it gives depends on the seed and on what was asked before, and on nothing else."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._drawn = 0

    def below(self, limit: int) -> int:
        """Draw a whole number from 0 up to, not including, `limit` (1 to 2**64), all equally likely."""
        fair = _WORDS - _WORDS % limit
        while True:
            digest = hashlib.sha256(f"labbook {self._seed} {self._drawn}".encode("ascii")).digest()
            self._drawn += 1
            word = int.from_bytes(digest[:8], "big")
            if word < fair:
                return word % limit

    def shuffled(self, items: Iterable[_Item]) -> list[_Item]:
        """Return the items in random order, every order equally likely."""
        order = list(items)
        for last in range(len(order) - 1, 0, -1):
            other = self.below(last + 1)
            order[last], order[other] = order[other], order[last]
        return order
