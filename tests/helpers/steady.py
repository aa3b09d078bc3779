"""The published experiments, and every published result judged, simulated once a process."""

from __future__ import annotations

import functools

from simulator.steady.published_results import JudgedResult, judge_results
from simulator.steady.tables import SteadyTables
from simulator.steady.tables import steady_tables as simulated
from simulator.thesis.claims import chapter_3_findings, experiment_findings
from simulator.thesis.readings import met_by_others, set_1_readings
from tests.helpers.thesis import thesis_figures


@functools.cache
def steady_tables() -> SteadyTables:
    """Emulator, force plate and bed as `labbook sim published` has them."""
    return simulated()


@functools.cache
def results() -> tuple[JudgedResult, ...]:
    """Every published result as `labbook sim published` judges it."""
    tables = steady_tables()
    met = met_by_others(set_1_readings(thesis_figures()))
    return judge_results((*chapter_3_findings(thesis_figures()), *experiment_findings(tables)), tables.bed, met)
