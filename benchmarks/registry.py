"""All benchmarks in the order of the document."""

from __future__ import annotations

from benchmarks import (
    apexes,
    campaign,
    channel_back,
    help_start,
    ingest_log,
    large_files,
    load,
    report_costs,
    runs_list,
    stance,
    studies,
    sweep_million,
)
from benchmarks.section import Benchmark

BENCHMARKS: dict[str, Benchmark] = {
    benchmark.name: benchmark
    for benchmark in (
        ingest_log.BENCHMARK,
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
    )
}
