"""The section on speed: every function beside what others take for the same fields, as ratios of one run."""

from __future__ import annotations

import gc

from benchmarks import machine
from benchmarks.document import verdict_line
from benchmarks.section import Budget, Table
from benchmarks.stats_evidence.prose import filled, table_lines
from benchmarks.stats_evidence.speed import fits, several_groups, two_groups
from benchmarks.stats_evidence.speed.case import BARE, PINGOUIN, SCIPY, STATSMODELS, Case
from benchmarks.stats_evidence.speed.measuring import LABBOOK, ROUNDS, Timed, all_timed

CASES: tuple[Case, ...] = (*two_groups.CASES, *several_groups.CASES, *fits.CASES)
SIZES = (25, 100, 1000, 10_000)
LIMIT = 5.0

INTRODUCTION = """\
Least time of {rounds} rounds in which all programs take turns, on samples of 25 to 10 000 values each; the tables show
labbook's time over the other's, so that less than 1 is faster. Compared is what gives the same fields: where scipy has
no function for them, several of its and numpy's calls together. Effect-size intervals, which labbook computes when they
are first asked for, are a row of their own. Load at the start: {load:.1f} (processes that wanted a core, on {cores}).
"""

OF_BARE = """\
Calls that give fewer fields, shown for those who need no more: a bare solver has neither standard errors nor p, and
polyfit no intervals, p or R squared.
"""


def section() -> list[str]:
    """Time everything and return the section as lines of Markdown."""
    load = machine.load()
    gc.freeze()  # collections between the rounds need not walk through the libraries
    found = all_timed(CASES, lambda what: print(f"   {what}", flush=True))
    described = machine.described()
    cores = dict(described)["cores"]
    return [
        "## Speed",
        "",
        *filled(INTRODUCTION.format(rounds=ROUNDS, load=load, cores=f"{cores} cores")),
        "",
        *table_lines(Table(("", ""), tuple(described), "")),
        "",
        *_verdicts(found),
        "",
        "### Over scipy and numpy, the same fields",
        "",
        *table_lines(_ratios(found, SCIPY)),
        "",
        "### Over statsmodels and pingouin",
        "",
        *table_lines(_ratios(found, STATSMODELS)),
        "",
        *table_lines(_ratios(found, PINGOUIN)),
        "",
        "### Over bare calls",
        "",
        *filled(OF_BARE),
        "",
        *table_lines(_ratios(found, BARE)),
        "",
        "### labbook's own times, in µs",
        "",
        *table_lines(_times(found)),
    ]


def _verdicts(found: list[Timed]) -> list[str]:
    """Return met or missed, and every ratio over the limit by name."""
    ratios = [(one.ratio(peer), one) for one in found for peer in one.case.peers if peer.program == SCIPY]
    largest, where = max(ratios, key=lambda pair: pair[0])
    functions = len({one.case.name for _ratio, one in ratios})
    what = f"labbook over scipy, the slowest of {functions} functions at 4 sizes ({where.case.name} at n = {where.n})"
    over = [f"{one.case.name} at n = {one.n} ({ratio:.1f})" for ratio, one in ratios if ratio > LIMIT]
    listed = filled(f"Over the limit: {', '.join(over)}.") if over else []
    return [f"- {verdict_line(Budget(what, LIMIT, '×', largest))}", *(["", *listed] if listed else [])]


def _ratios(found: list[Timed], program: str) -> Table:
    rows = []
    for case in CASES:
        for peer in case.peers:
            if peer.program == program:
                cells = {one.n: f"{one.ratio(peer):.2g}" for one in found if one.case is case}
                rows.append((case.name, peer.what, *(cells.get(n, "") for n in SIZES)))
    return Table(("labbook", program, *map(str, SIZES)), tuple(rows), "")


def _times(found: list[Timed]) -> Table:
    rows = []
    for case in CASES:
        cells = {one.n: f"{one.seconds[LABBOOK] * 1e6:.0f}" for one in found if one.case is case}
        rows.append((case.name, *(cells.get(n, "") for n in SIZES)))
    return Table(("", *map(str, SIZES)), tuple(rows), "")
