"""Runs of jumps that have no joules or no apex height, each with the reason."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence

from data_schema.queries.runs import RunRow
from labbook.actions.runs.rig_line import joules_of
from labbook.analysis.outcomes.detecting import BODY_HEIGHT
from labbook.analysis.outcomes.detections import Detections, rest_length_m
from labbook.analysis.outcomes.judging import judge
from labbook.analysis.outcomes.passive_drain import drain_lines
from labbook.analysis.outcomes.run_apexes import as_protocol, usable_logs
from labbook.analysis.study_data import StudyData


def without_joules(evidence: StudyData, runs: Sequence[RunRow]) -> dict[str, str]:
    """Return why runs have no joules a jump, by name."""
    drains = drain_lines(evidence) if runs else {}
    said = {run.name: joules_of(run, evidence, drains) for run in runs}
    return {name: why for name, why in said.items() if isinstance(why, str)}


def without_apexes(
    detections: Detections, evidence: StudyData, runs: Sequence[RunRow], with_log: Collection[str]
) -> dict[str, str]:
    """Return why runs have no apex height, by name; `with_log` are the uids of runs that have a log of any kind."""
    found = {run.name: _why_no_apex(detections, evidence, run, run.uid in with_log) for run in runs}
    return {name: why for name, why in found.items() if why is not None}


def _why_no_apex(detections: Detections, evidence: StudyData, run: RunRow, has_log: bool) -> str | None:
    heights = evidence.logs.get(run.uid, [])
    if not heights:
        declare = f'`labbook ingest FILE --column "COLUMN={BODY_HEIGHT}:UNIT"`'
        return f"the log has no {BODY_HEIGHT}: {declare}" if has_log else "no log"
    logs = usable_logs(run, heights)
    if isinstance(logs, str):
        return logs
    variant = as_protocol(evidence)
    found = detections.of({run.uid: logs}, variant.detector, rest_length_m(detections.connection, run.robot_uid))
    judged = judge(found[run.uid], evidence.decisions, variant.rules)
    if judged.counted:
        return None
    excluded = Counter(str(item.excluded) for item in judged.jumps)
    return f"no jump counts: {', '.join(excluded)}" if excluded else "no jump was found in the log"
