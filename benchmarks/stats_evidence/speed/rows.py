"""The rows of `docs/statistics/speed.csv`: every function beside what others take for the same fields.

Least time of several rounds in which all programs take turns, on samples of 25 to 10 000 values each. Compared is what
gives the same fields: where scipy has no function for them, several of its and numpy's calls together. A bare call
gives fewer: a bare solver has neither standard errors nor p, and polyfit no intervals, p or R squared. Effect-size
intervals, which labbook computes when they are first asked for, are a function of their own.
"""

from __future__ import annotations

import gc

from benchmarks import machine
from benchmarks.stats_evidence.speed import fits, several_groups, two_groups
from benchmarks.stats_evidence.speed.case import Case, Peer
from benchmarks.stats_evidence.speed.measuring import LABBOOK, Timed, all_timed

CASES: tuple[Case, ...] = (*two_groups.CASES, *several_groups.CASES, *fits.CASES)


def rows() -> list[dict[str, str]]:
    """Time everything; a row for each function, number of values and other program, with labbook's time over its."""
    gc.freeze()  # collections between the rounds need not walk through the libraries
    found = all_timed(CASES, lambda what: print(f"   {what}", flush=True))
    described = dict(machine.described())
    measured_on = {"date": described["date"], "processor": described["processor"]}
    return [_row(one, peer) | measured_on for one in found for peer in one.case.peers or (None,)]


def _row(one: Timed, peer: Peer | None) -> dict[str, str]:
    return {
        "function": one.case.name,
        "values": str(one.n),
        "labbook_us": f"{one.seconds[LABBOOK] * 1e6:.0f}",
        "program": peer.program if peer else "",
        "calls": peer.what if peer else "",
        "labbook_over_program": f"{one.ratio(peer):.2g}" if peer else "",
    }
