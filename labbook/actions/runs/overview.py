"""Every run in a line: condition, joules, apex height, jumps found, counted and reviewed, and what is odd about it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.queries.runs import RunRow
from data_schema.vocabulary import FileRole, RunKind, RunState, Undefined
from ingest.store import Store
from labbook.analysis.outcomes.control_limits import runs_outside
from labbook.analysis.outcomes.detection import Detections, jumps_found
from labbook.analysis.outcomes.run_apexes import Judgement, as_protocol, run_apexes
from labbook.analysis.outcomes.run_energy import RunEnergy, drain_lines, energies_with_drains, usable_charge
from labbook.analysis.results import Results
from labbook.analysis.study_data import StudyData, gather
from labbook.config.model import Configuration


@dataclass(frozen=True, slots=True)
class RunSummary:
    """A run as a list shows it: energy in J a jump, mean apex height in m, jumps by number; None where there is none.

    `detected` are the jumps and misfires of the logs, `found` the flights with an apex, `counted` the jumps that count,
    `reviewed` those with a person's verdict.
    `flags` say in few words what is odd.
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
    detected: int | None
    found: int | None
    counted: int | None
    reviewed: int | None
    flags: tuple[str, ...]


def overview(
    connection: sa.Connection, store: Store, configuration: Configuration, where: str | None = None
) -> list[RunSummary]:
    """Return the runs that fulfil `where`, all without one, in the order of the book."""
    evidence = gather(connection, configuration, where)
    every = gather(connection, configuration, None) if where else evidence
    energies = energies_with_drains(every.runs, every.charges, drain_lines(every), every.study.reference_voltage_v)
    apexes = run_apexes(Results(), Detections(connection, store), evidence, as_protocol(evidence))
    joules = {uid: energy.joules_per_jump.value for uid, energy in energies.items()}
    outside = {
        run.uid
        for run in runs_outside(every.runs, {uid: value for uid, value in joules.items() if isinstance(value, float)})
    }
    return [
        _summary(
            run,
            evidence,
            energies.get(run.uid),
            apexes.judgements.get(run.uid),
            apexes.missing.get(run.uid),
            outside=run.uid in outside,
        )
        for run in evidence.selected
    ]


def _summary(
    run: RunRow,
    evidence: StudyData,
    energy: RunEnergy | None,
    judgement: Judgement | None,
    no_apex: Undefined | None,
    *,
    outside: bool,
) -> RunSummary:
    joules = None if energy is None else energy.joules_per_jump.value
    counted = None if judgement is None else judgement.counted
    heights = [jump.apex_height_m for jump in counted or () if jump.apex_height_m is not None]
    found = None if judgement is None else jumps_found(item.jump for item in judgement.jumps)
    return RunSummary(
        name=run.name,
        kind=str(run.kind),
        state=str(run.state),
        day=run.day,
        position_in_day=run.position_in_day,
        condition=run.condition_key,
        levels=run.levels,
        battery=run.battery,
        joules_per_jump=joules if isinstance(joules, float) else None,
        apex_height_m=sum(heights) / len(heights) if heights else None,
        made=run.jumps_made,
        detected=None if judgement is None else len(judgement.jumps),
        found=found,
        counted=None if counted is None else len(counted),
        reviewed=None
        if judgement is None
        else sum(item.decision is not None and item.jump.apex_height_m is not None for item in judgement.jumps),
        flags=tuple(_flags(run, evidence, found, judgement, no_apex, outside=outside)),
    )


def _flags(
    run: RunRow,
    evidence: StudyData,
    found: int | None,
    judgement: Judgement | None,
    no_apex: Undefined | None,
    *,
    outside: bool,
) -> list[str]:
    """Say in few words what is odd about a run that counts."""
    if run.state is RunState.VOID:
        return ["void"]
    flags = ["open"] if run.state is RunState.OPEN else []
    if run.kind is not RunKind.JUMPS:
        return flags
    charge = usable_charge(run, evidence.charges.get(run.uid, []))
    if isinstance(charge, Undefined):
        flags.append(charge.reason)
    if no_apex is not None:
        waiting = evidence.waits(run.uid, FileRole.LOG)
        flags.append((waiting or no_apex).reason)
    if found is not None and found != run.jumps_made:
        flags.append(f"{found} of {run.jumps_made} jumps found")
    if outside:
        flags.append("joules outside the control limits")
    if judgement is not None and judgement.zero_doubtful:
        flags.append("zero doubtful")
    if judgement is not None and judgement.waiting:
        flags.append(f"{len(judgement.waiting)} verdicts wait")
    return flags
