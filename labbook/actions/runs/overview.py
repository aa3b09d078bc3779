"""Every run in a line: condition, joules, apex height, and how many jumps were found, count and are reviewed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.queries.runs import RunRow
from ingest.store import Store
from labbook.actions.runs.rig_line import known_joules
from labbook.analysis.outcomes.detection import Detections, jumps_found
from labbook.analysis.outcomes.run_apexes import JudgedRun, as_protocol, judge_runs, logs_that_count, to_review
from labbook.analysis.outcomes.run_energy import drain_lines
from labbook.analysis.study_data import gather
from labbook.config.model import Configuration


@dataclass(frozen=True, slots=True)
class RunSummary:
    """A run as a list shows it: energy in J a jump, mean apex height in m, jumps by number; None where there is none.

    `found` are the flights with an apex, `counted` the jumps that count; of those `to_review`, `reviewed` have a
    person's verdict.
    """

    name: str
    kind: str
    state: str
    day: str
    position_in_day: int
    condition: str
    levels: Mapping[str, str]
    battery: str
    joules_per_jump: float | None
    apex_height_m: float | None
    made: int
    found: int | None
    counted: int | None
    to_review: int | None
    reviewed: int | None


def overview(
    connection: sa.Connection, store: Store, configuration: Configuration, where: str | None = None
) -> list[RunSummary]:
    """Return the runs that fulfil `where`, all without one, in the order of the book."""
    evidence = gather(connection, configuration, where)
    joules = known_joules(evidence, drain_lines(evidence))
    logs, _missing = logs_that_count(evidence.runs, evidence.logs, evidence.calibrated)
    judged = judge_runs(Detections(connection, store), evidence.runs, logs, evidence.decisions, as_protocol(evidence))
    return [_summary(run, joules.get(run.uid), judged.get(run.uid)) for run in evidence.selected]


def _summary(run: RunRow, joules: float | None, judged: JudgedRun | None) -> RunSummary:
    counted = None if judged is None else judged.judgement.counted
    heights = [jump.apex_height_m for jump in counted or () if jump.apex_height_m is not None]
    jumps = None if judged is None else judged.judgement.jumps
    return RunSummary(
        name=run.name,
        kind=str(run.kind),
        state=str(run.state),
        day=run.day,
        position_in_day=run.position_in_day,
        condition=run.condition_key,
        levels=run.levels,
        battery=run.battery,
        joules_per_jump=joules,
        apex_height_m=sum(heights) / len(heights) if heights else None,
        made=run.jumps_made,
        found=None if jumps is None else jumps_found(one.jump for one in jumps),
        counted=None if counted is None else len(counted),
        to_review=None if jumps is None else len(to_review(jumps)),
        reviewed=None if jumps is None else sum(one.decision is not None for one in jumps),
    )
