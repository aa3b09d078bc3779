"""Each study of the thesis from nothing: its demonstration, its page, and what the simulator predicts of it."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

from benchmarks.processes import LABBOOK, run_process
from benchmarks.section import Benchmark, Budget, Section, Table

MOST_S = 90.0
STUDIES = {
    "compaction": ("flasks.csv", "--grain", "3.4"),
    "field": ("walks.csv",),
    "characterisation": ("trials.csv",),
    "force-plate": (),
    "emulator": (),
}
"""By study: its sheet below the demonstration's folder with what else its command takes; nothing for one in a book."""


def measure(say: Callable[[str], None]) -> Section:
    """Run `labbook demo --study`, `labbook study --page`, and `labbook compare` where there is a book."""
    rows, budgets = [], []
    with tempfile.TemporaryDirectory(prefix="labbook-bench-") as name:
        for study, sheet in STUDIES.items():
            say(f"labbook demo --study {study}, its page and its comparison")
            folder = Path(name) / study
            taken = [run_process([LABBOOK, "demo", "--study", study, folder]).wall_s]
            page: tuple[str | Path, ...] = ("--page", Path(name) / f"{study}.html")
            if sheet:
                taken.append(run_process([LABBOOK, "study", study, folder / sheet[0], *sheet[1:], *page]).wall_s)
            else:
                book = ("--book", folder / "book")
                taken.append(run_process([LABBOOK, "study", study, *book, *page]).wall_s)
                taken.append(run_process([LABBOOK, "compare", *book]).wall_s)
            rows.append((study, *(f"{seconds:.1f}" for seconds in taken), *("",) * (3 - len(taken))))
            budgets.append(Budget(f"{study}: demonstration, page and comparison", MOST_S, "s", sum(taken)))
    return Section(
        "Studies",
        "Whole processes, one after the other, each study once: `labbook demo --study NAME`, `labbook study NAME "
        "--page`, and, where it is in a book, `labbook compare`.",
        tuple(budgets),
        (Table(("study", "demonstration (s)", "page (s)", "comparison (s)"), tuple(rows), ""),),
    )


BENCHMARK = Benchmark("studies", measure)
