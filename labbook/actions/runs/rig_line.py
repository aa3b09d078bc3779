"""One line for the person at the rig, before the foot is changed: is this run as it should be?"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from data_schema.queries.runs import RunRow
from data_schema.queries.signals import SignalRow
from data_schema.vocabulary import GapKind, Undefined
from ingest.model import ReadFile
from labbook.analysis.outcomes.detections import Detections
from labbook.analysis.outcomes.energy import joules_per_jump
from labbook.analysis.outcomes.passive_drain import drain_lines
from labbook.analysis.outcomes.run_apexes import jumps_found_in_run
from labbook.analysis.outcomes.run_energy import usable_charge
from labbook.analysis.study_data import StudyData
from labbook.statements.importing import PreparedImport
from stats.compare.summary import describe
from stats.lines.passive_drain import PassiveDrain

LIMIT_SDS = 3.0
"""Control limits lie three standard deviations from the mean of the condition's earlier runs (Shewhart 1931)."""
LIMITS_FROM_RUNS = 5
"""Fewer earlier runs than this give no limits: their standard deviation is too uncertain."""
_RIG_GAPS = (GapKind.DROPPED, GapKind.HELD)
"""The gaps that say something of the radio or the sensor: a pause was made, and rejected rows are findings."""

Lines: TypeAlias = Mapping[str, PassiveDrain | Undefined]


@dataclass(frozen=True, slots=True)
class RigLine:
    """What is said of a run; `jumps_off` is by how many the jumps found differ from those made.

    `charge_odd`: its charge is one that the pack cannot have taken after it; `outside`: its joules are out of their
    control limits.
    """

    text: str
    jumps_off: int = 0
    logs_do_not_count: bool = False
    charge_odd: bool = False
    outside: bool = False


def rig_lines(
    detections: Detections, files: Mapping[str, Sequence[PreparedImport]], evidence: StudyData
) -> dict[str, RigLine]:
    """Say of every run how many jumps and gaps it has and whether its joules are in control, by its name.

    `files` has what one command read for each run, logs and charges, told in one line; the book may hold more of a run.
    """
    drains = drain_lines(evidence)
    return {
        run.name: _line(run, detections, files[run.name], evidence, drains)
        for run in evidence.runs
        if run.name in files
    }


def _line(
    run: RunRow, detections: Detections, files: Sequence[PreparedImport], evidence: StudyData, drains: Lines
) -> RigLine:
    parts = [f"run {run.name}:"]
    found: int | str = run.jumps_made
    if any(stored.detection is not None for prepared in files for stored in prepared.parts):
        in_book = evidence.logs.get(run.uid, [])
        found = jumps_found_in_run(detections, run, in_book, evidence.configuration.protocol.detector)
        parts.append(f"{_jumps(run, found, in_book)},")
    logs = [prepared.read for prepared in files if prepared.parts]
    if logs:
        parts.append(f"{_gaps(logs)}{_where(files, evidence.logs.get(run.uid, []))},")
    joules, outside = _joules(run, evidence, drains)
    if isinstance(found, str):
        return RigLine(" ".join([*parts, joules]), logs_do_not_count=True, outside=outside)
    return RigLine(" ".join([*parts, joules]), abs(found - run.jumps_made), outside=outside)


def _jumps(run: RunRow, found: int | str, logs: Sequence[SignalRow]) -> str:
    """Say how many jumps all logs of a run in the book have: where it was started again, some may have come before."""
    if isinstance(found, str):
        return f"its jumps do not count ({found})"
    several = len({log.sha256 for log in logs})
    where = "" if several == 1 else f" in {several} logs"
    return f"{found} of {run.jumps_made} jumps found{where}{_mismatch(found, run.jumps_made)}"


def _mismatch(found: int, made: int) -> str:
    if found == made:
        return ""
    return f" ({made - found} missing)" if found < made else f" ({found - made} too many)"


def _gaps(logs: Sequence[ReadFile]) -> str:
    gaps = [gap for log in logs for part in log.parts for gap in part.gaps if gap.kind in _RIG_GAPS]
    if not gaps:
        return "no gaps"
    missing = sum(gap.samples_missing for gap in gaps)
    held = sum(gap.samples_missing for gap in gaps if gap.kind is GapKind.HELD)
    said = f", {held} of them held" if held else ""
    return f"{len(gaps)} gap{'' if len(gaps) == 1 else 's'} ({missing} samples{said})"


def _where(files: Sequence[PreparedImport], in_book: Sequence[SignalRow]) -> str:
    """Say that gaps are those of the logs just read, where the book has others of the run, whose jumps count too."""
    if {log.file_sha256 for log in in_book} <= {prepared.sha256 for prepared in files}:
        return ""
    return " in the log just read" if sum(bool(prepared.parts) for prepared in files) == 1 else " in the logs just read"


def _joules(run: RunRow, evidence: StudyData, drains: Lines) -> tuple[str, bool]:
    """Say a run's joules a jump beside those of its condition before, and whether they are out of the limits."""
    joules = joules_of(run, evidence, drains)
    if isinstance(joules, str):
        return f"joules unknown: {joules}", False
    now = (run.day, run.position_in_day)
    earlier = [
        value
        for other in evidence.runs
        if other.condition_key == run.condition_key and (other.day, other.position_in_day) < now
        for value in [joules_of(other, evidence, drains)]
        if not isinstance(value, str)
    ]
    if not earlier:
        return f"{joules:.1f} J a jump, the first of its condition", False
    about = describe(earlier)
    if about.n < LIMITS_FROM_RUNS or isinstance(about.mean, Undefined) or isinstance(about.sd, Undefined):
        runs = "run" if about.n == 1 else "runs"
        return f"{joules:.1f} J a jump, n = {about.n} {runs} so far, no limits yet", False
    low, high = about.mean - LIMIT_SDS * about.sd, about.mean + LIMIT_SDS * about.sd
    outside = not low <= joules <= high
    verdict = "OUTSIDE" if outside else "within"
    return f"{joules:.1f} J a jump, {verdict} the control limits {low:.1f} to {high:.1f} J (n = {about.n})", outside


def joules_of(run: RunRow, evidence: StudyData, drains: Lines) -> float | str:
    """Return a run's joules a jump, or why there are none."""
    charge = usable_charge(run, evidence.charges.get(run.uid, []))
    if isinstance(charge, str):
        return charge
    drain = drains[run.robot_uid]
    if isinstance(drain, Undefined):
        return "no passive-drain fit yet"
    passive = drain.at(run.duration_s or 0.0).charge_mah
    joules = joules_per_jump(charge.charge_mah, passive, evidence.study.reference_voltage_v, run.jumps_made)
    return joules.reason if isinstance(joules, Undefined) else joules
