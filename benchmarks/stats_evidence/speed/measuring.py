"""Times of a case at each size: all programs in turns, short calls many at a time."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from benchmarks.stats_evidence.speed.case import Call, Case, Peer, inputs
from benchmarks.timing import Work, in_turns

ROUNDS = 9
FEW_ROUNDS = 3
CHUNK_S = 0.004
"""Calls are timed together until they take about this long."""
LONG_S = 0.3
"""A call this long is repeated a few times only."""
LABBOOK = "labbook"


@dataclass(frozen=True, slots=True)
class Timed:
    """Least seconds a call, by program, at one size."""

    case: Case
    n: int
    seconds: dict[str, float]

    def ratio(self, peer: Peer) -> float:
        """Return labbook's time over a peer's."""
        return self.seconds[LABBOOK] / self.seconds[peer.program]


def timed(case: Case, n: int) -> Timed:
    """Time labbook and all peers of a case on samples of n values."""
    given = inputs(n)
    calls = {LABBOOK: case.labbook(given), **{peer.program: peer.prepared(given) for peer in case.peers}}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of peers, on convergence and precision
        counts = {program: _calls_in_a_chunk(call) for program, call in calls.items()}
        works = {program: Work(partial(_repeated, call, counts[program][0])) for program, call in calls.items()}
        rounds = FEW_ROUNDS if max(once for _count, once in counts.values()) > LONG_S else ROUNDS
        found = in_turns(works, rounds)
    return Timed(case, n, {program: times.minimum / counts[program][0] for program, times in found.items()})


def all_timed(cases: tuple[Case, ...], say: Callable[[str], None]) -> list[Timed]:
    """Time all cases at all their sizes."""
    found = []
    for case in cases:
        say(case.name)
        found += [timed(case, n) for n in case.sizes]
    return found


def _calls_in_a_chunk(call: Call) -> tuple[int, float]:
    """Return how many calls to time together, and about how long one takes."""
    call()
    start = time.perf_counter()
    call()
    once = time.perf_counter() - start
    return max(1, round(CHUNK_S / once)), once


def _repeated(call: Call, count: int, _prepared: object) -> None:
    for _ in range(count):
        call()
