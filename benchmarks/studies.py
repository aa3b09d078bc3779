"""Each study of the thesis from nothing: its demonstration, its page, and what the simulator predicts of it."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

from benchmarks.processes import LABBOOK, run_process
from benchmarks.section import Benchmark, Budget, Section, Table
from labbook.cli.views import NOT_MET
from labbook.config.studies import STUDIES

MOST_S = 90.0
OF_RUNS = ("force-plate", "emulator", "bed")
"""Studies whose book has runs, which are simulated too."""


def measure(say: Callable[[str], None]) -> Section:
    """Run `labbook demo --study`, `labbook study --page`, and `labbook compare` where there are runs."""
    rows, budgets = [], []
    with tempfile.TemporaryDirectory(prefix="labbook-bench-") as name:
        for study in STUDIES:
            say(f"labbook demo --study {study}, its page and its comparison")
            folder = Path(name) / study
            book = ("--book", folder / "book")
            commands: list[tuple[str | Path, ...]] = [
                ("demo", "--study", study, folder),
                ("study", study, *book, "--page", Path(name) / f"{study}.html"),
                *([("compare", *book)] if study in OF_RUNS else ()),
            ]
            # of the comparison a hypothesis may fail
            taken = [
                run_process([LABBOOK, *words], (0, NOT_MET) if words[0] == "compare" else (0,)).wall_s
                for words in commands
            ]
            rows.append((study, *(f"{seconds:.1f}" for seconds in taken), *("",) * (3 - len(taken))))
            budgets.append(Budget(f"{study}: demonstration, page and comparison", MOST_S, "s", sum(taken)))
    return Section(
        "Studies",
        "Whole processes, one after the other, each study once: `labbook demo --study`, a page by `labbook study`, and "
        "`labbook compare` where its book has runs.",
        tuple(budgets),
        (Table(("study", "demonstration (s)", "page (s)", "comparison (s)"), tuple(rows), ""),),
    )


BENCHMARK = Benchmark("studies", measure)
