"""Measures every budget and writes `docs/performance.md`; with names, only those, and only to the terminal.

python benchmarks/run.py [NAME...]
"""

from __future__ import annotations

import sys
from pathlib import Path

from benchmarks import machine
from benchmarks.document import document, table_text, verdict_line
from benchmarks.registry import BENCHMARKS
from benchmarks.section import Section

DOCUMENT = Path(__file__).resolve().parent.parent / "docs" / "performance.md"


def main(names: list[str]) -> None:
    """Run the benchmarks named, or all; the exit code says nothing about budgets."""
    unknown = [name for name in names if name not in BENCHMARKS]
    if unknown:
        sys.exit(f"there is no benchmark {unknown[0]!r}: there are {', '.join(BENCHMARKS)}.")
    measured: list[tuple[Section, float]] = []
    for name in names or BENCHMARKS:
        load = machine.load()
        print(f"== {name} (load {load:.1f})", flush=True)
        section = BENCHMARKS[name].measure(lambda what: print(f"   {what}", flush=True))
        measured.append((section, load))
        for table in section.tables:
            print(f"\n{table_text(table)}\n{table.shows}\n")
        for budget in section.budgets:
            print(verdict_line(budget), flush=True)
    if names:
        print("only some were run: docs/performance.md is left as it was.")
        return
    DOCUMENT.write_text(document(machine.described(), measured), encoding="utf-8")
    print(f"wrote {DOCUMENT}")


if __name__ == "__main__":
    main(sys.argv[1:])
