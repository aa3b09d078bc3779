"""Measures every budget but the longest, or those of the benchmarks named, and writes `docs/performance.md`.

python benchmarks/run.py [NAME...]
"""

from __future__ import annotations

import sys
from pathlib import Path

from benchmarks import (
    apexes,
    campaign,
    channel_back,
    help_start,
    ingest_log,
    large_files,
    load,
    machine,
    report_costs,
    runs_list,
    stance,
    studies,
    sweep_million,
    watch,
    web,
)
from benchmarks.document import document, section_text, table_text, verdict_line
from benchmarks.section import Benchmark

BENCHMARKS: dict[str, Benchmark] = {
    benchmark.name: benchmark
    for benchmark in (
        ingest_log.BENCHMARK,
        watch.BENCHMARK,
        large_files.BENCHMARK,
        channel_back.BENCHMARK,
        runs_list.BENCHMARK,
        *load.BENCHMARKS,
        help_start.BENCHMARK,
        stance.BENCHMARK,
        sweep_million.BENCHMARK,
        apexes.BENCHMARK,
        *campaign.BENCHMARKS,
        *report_costs.BENCHMARKS,
        studies.BENCHMARK,
        web.BENCHMARK,
    )
}
"""In the order of the document."""
DOCUMENT = Path(__file__).resolve().parent.parent / "docs" / "performance.md"


def main(names: list[str]) -> None:
    """Run the benchmarks named, or all that are not long; the exit code says nothing about budgets."""
    unknown = [name for name in names if name not in BENCHMARKS]
    if unknown:
        sys.exit(f"there is no benchmark {unknown[0]!r}: there are {', '.join(BENCHMARKS)}.")
    for name in names or [name for name, benchmark in BENCHMARKS.items() if not benchmark.long]:
        measured_on = machine.measured_on()
        print(f"== {name} ({measured_on})", flush=True)
        section = BENCHMARKS[name].measure(lambda what: print(f"   {what}", flush=True))
        for table in section.tables:
            print(f"\n{table_text(table)}\n{table.shows}\n")
        for budget in section.budgets:
            print(verdict_line(budget), flush=True)
        known = DOCUMENT.read_text(encoding="utf-8")
        DOCUMENT.write_text(document(known, {name: section_text(section, measured_on)}, BENCHMARKS), encoding="utf-8")
        print(f"wrote its section of {DOCUMENT}")


if __name__ == "__main__":
    main(sys.argv[1:])
