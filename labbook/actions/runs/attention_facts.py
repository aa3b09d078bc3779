"""What is looked at for what needs attention: the facts of a whole book, read once, and what each lost claim lacks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from data_schema.outcomes import Outcome
from data_schema.queries.detections import WaitingVerdict, verdicts_waiting
from data_schema.queries.files import LEG, RefusedFile, inbox, last_imports, refused_files, values_found
from data_schema.queries.history import first_measurement
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import SignalRow, SourceColumn, source_columns
from data_schema.queries.study import checks_by_day, planned_runs
from data_schema.vocabulary import FileRole, RunKind, RunState, Undefined
from labbook.actions.files.stored_files import Waiting, why_waiting
from labbook.actions.runs import remarks
from labbook.actions.runs.rig_line import Lines, known_joules
from labbook.analysis.comparison.deciding import deciding_runs, makes_claim
from labbook.analysis.comparison.pairing import group_label, swept_factor
from labbook.analysis.outcomes.control_limits import runs_outside
from labbook.analysis.outcomes.detection import BODY_HEIGHT, Detections, jumps_found
from labbook.analysis.outcomes.run_apexes import Judgement, as_protocol, judge_runs, logs_that_count
from labbook.analysis.outcomes.run_energy import (
    drain_lines,
    only_charge_missing,
)
from labbook.analysis.study_data import StudyData, gather
from labbook.config.model import Configuration
from labbook.terminal import listed


@dataclass(frozen=True, slots=True)
class Facts:
    """What the checks look at: `runs` and `days` are those asked about, void runs left out.

    `evidence` is of the whole book, `about` of the runs alone. By a run's uid, `no_heights` says why its logs do not
    count, `judgements` has its jumps; `charge_costs` and `log_costs` say which claim a run's missing charge or log
    costs. `outside` are the uids of runs out of their control limits. `zeros` has the zero in m that is too high, by
    the file's SHA-256, `heights` the columns of these files and of those without a jump, by the signal's uid.
    """

    evidence: StudyData
    about: remarks.Facts
    runs: Sequence[RunRow]
    days: Sequence[str]
    drains: Lines
    outside: frozenset[str]
    no_heights: Mapping[str, Undefined]
    judgements: Mapping[str, Judgement]
    charge_costs: Mapping[str, str]
    log_costs: Mapping[str, str]
    checks_made: Mapping[str, frozenset[str]]
    waiting: Sequence[Waiting]
    refused: Sequence[RefusedFile]
    last_imports: Mapping[str, str]
    verdicts_waiting: Sequence[WaitingVerdict]
    planned_not_made: Sequence[str]
    undecided: bool
    zeros: Mapping[str, float]
    heights: Mapping[str, SourceColumn]
    by_name: Mapping[str, RunRow]

    def logs(self, run: RunRow) -> list[SignalRow]:
        """Return the signals of a run's logs, whatever their channels."""
        return [one for one in self.about.signals[run.uid] if one.role == FileRole.LOG]


def gather_facts(
    detections: Detections, configuration: Configuration, asked: Sequence[RunRow], day: str | None
) -> Facts:
    """Read the facts of the book, and find the jumps of the runs asked about; `day` is looked at without runs, too."""
    connection = detections.connection
    runs = [run for run in asked if run.state is not RunState.VOID]
    evidence = gather(connection, configuration, None)
    about = remarks.facts_about(connection, configuration, runs)
    drains = drain_lines(evidence)
    joules = known_joules(evidence, drains)
    of_all, no_heights = logs_that_count(evidence.runs, evidence.logs, evidence.calibrated)
    jumped = [run for run in runs if run.kind is RunKind.JUMPS]
    logs = {run.uid: of_all[run.uid] for run in jumped if run.uid in of_all}
    judged = judge_runs(detections, jumped, logs, evidence.decisions, as_protocol(evidence))
    judgements = {uid: found.judgement for uid, found in judged.items()}
    in_doubt = [
        log.uid
        for uid, judgement in judgements.items()
        if judgement.zero_doubtful or not jumps_found(one.jump for one in judgement.jumps)
        for log in logs[uid]
    ]
    refused = refused_files(connection)
    return Facts(
        evidence=evidence,
        about=about,
        runs=runs,
        days=sorted({run.day for run in runs} | ({day} if day else set())),
        drains=drains,
        outside=frozenset(run.uid for run in runs_outside(evidence.runs, joules)),
        no_heights=no_heights,
        judgements=judgements,
        charge_costs=_claims_lost(evidence, joules, only_charge_missing(evidence.runs, evidence.charges), _CHARGE),
        log_costs=_claims_lost(evidence, of_all, [run for run in evidence.runs if run.uid in no_heights], _LOG),
        checks_made={date: frozenset(one.kind for one in made) for date, made in checks_by_day(connection).items()},
        waiting=why_waiting(connection, inbox(connection)),
        refused=refused,
        last_imports=last_imports(connection) if any(one.stated_run for one in refused) else {},
        verdicts_waiting=verdicts_waiting(connection),
        planned_not_made=[row.name for row in planned_runs(connection) if row.run_name is None],
        undecided=configuration.analysis is None and first_measurement(connection) is None,
        zeros={sha256: float(value) for sha256, value in values_found(connection, LEG[0]).items()},
        heights=source_columns(connection, in_doubt, BODY_HEIGHT),
        by_name={run.name: run for run in evidence.selected},
    )


_CHARGE, _LOG = (Outcome.JOULES, "charge"), (Outcome.APEX, "log")


def _claims_lost(
    evidence: StudyData, having: Iterable[str], lacking: Sequence[RunRow], what: tuple[Outcome, str]
) -> dict[str, str]:
    """Return what each run's missing charge, or log, costs, by its uid: the claim that its group would make with it.

    `having` are the uids of the runs that have the outcome; where none has it, no claim is looked for.
    """
    swept, has, (outcome, source) = swept_factor(evidence.configuration), frozenset(having), what
    if swept is None or not has or not lacking:
        return {}

    def grouped(runs: Iterable[RunRow]) -> dict[str, list[RunRow]]:
        found: dict[str, list[RunRow]] = {}
        for run in runs:
            if swept in run.levels:
                group = {name: label for name, label in run.levels.items() if name != swept}
                found.setdefault(group_label(group), []).append(run)
        return found

    costs: dict[str, str] = {}
    measured = grouped(run for run in evidence.runs if run.uid in has)
    for group, without in grouped(lacking).items():
        known = measured.get(group, [])
        if makes_claim(known):
            continue
        alone = deciding_runs(known, without)
        together = without if not alone and makes_claim([*known, *without]) else []
        sides = [{run.day for run in known if run.is_control is side} for side in (True, False)]
        days = len(sides[0] & sides[1])
        said = f"{group} has {days} shared day{'' if days == 1 else 's'} and makes no claim on {outcome.plural}"
        costs |= {run.uid: f"{said}; with this {source} it would" for run in alone}
        all_of = listed([run.name for run in together], 6)
        costs |= {run.uid: f"{said}; with the {source}s of {all_of} it would" for run in together}
    return costs
