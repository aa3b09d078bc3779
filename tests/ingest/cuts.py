"""Where tests cut files off: every byte takes long, and errors lie where lines and records end."""

from __future__ import annotations

import pytest

EVERY = pytest.mark.parametrize("step", [7, pytest.param(1, marks=pytest.mark.soak)])
"""For tests that cut with a step: each seventh byte in a normal run, each in a soak."""
NEAR, AT_THE_END = 2, 40


def cuts(data: bytes, step: int, edges: range | None = None) -> list[int]:
    """Return lengths to cut data to: each `step` bytes, near edges (line ends where none are given), and at the end."""
    places = [place for place, byte in enumerate(data) if byte in b"\r\n"] if edges is None else edges
    near = {place + beside for place in places for beside in range(-NEAR, NEAR + 1)}
    last = range(len(data) - AT_THE_END, len(data))
    return sorted(length for length in {*range(0, len(data), step), *near, *last} if 0 <= length < len(data))
