"""Chance that never changes: fixed values, fairness, permutations."""

from __future__ import annotations

import hashlib
import itertools
from collections import Counter

from hypothesis import given
from hypothesis import strategies as st

from labbook.plan.drawing import SeededChance


def test_words_are_the_documented_hashes() -> None:
    chance = SeededChance(7)
    for place in range(3):
        digest = hashlib.sha256(f"labbook 7 {place}".encode()).digest()
        assert chance.below(2**64) == int.from_bytes(digest[:8], "big")


def test_the_same_seed_gives_the_same_order_for_ever() -> None:
    assert "".join(SeededChance(2021).shuffled("abcdefghij")) == "jfbdhageic"
    assert SeededChance(1).shuffled(range(50)) != SeededChance(2).shuffled(range(50))


@given(st.integers(0, 2**63 - 1), st.lists(st.integers(), max_size=30))
def test_shuffling_keeps_the_items(seed: int, items: list[int]) -> None:
    before = list(items)
    assert Counter(SeededChance(seed).shuffled(items)) == Counter(before)
    assert items == before


def test_every_order_is_equally_likely() -> None:
    chance = SeededChance(0)
    n = 6000
    counts = Counter(tuple(chance.shuffled("abc")) for _ in range(n))
    assert set(counts) == set(itertools.permutations("abc"))
    # Chi-squared with 5 degrees of freedom stays below 20.5 with probability 0.999; the seed is fixed.
    assert sum((count - n / 6) ** 2 / (n / 6) for count in counts.values()) < 20.5


@given(st.integers(0, 2**63 - 1), st.integers(1, 2**64))
def test_numbers_stay_below_the_limit(seed: int, limit: int) -> None:
    assert 0 <= SeededChance(seed).below(limit) < limit
