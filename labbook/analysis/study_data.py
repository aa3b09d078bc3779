"""What an analysis looks at: the facts of the selected runs, read once.

Also which files were read with a profile that labbook.toml has otherwise now; no file is read to tell.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import sqlalchemy as sa

from data_schema.errors import UsageError
from data_schema.grouping import grouped
from data_schema.queries.charges import ChargeOfRun, charges_by_run, charges_of_runs
from data_schema.queries.detections import DecisionRow, jump_decisions
from data_schema.queries.files import WaitingFile, configurations_of_readings, settings_under, waiting_files
from data_schema.queries.runs import RunRow, idle_runs, list_runs, where_columns
from data_schema.queries.signals import CalibratedChannel, SignalRow, calibrated_channels, signals_of_runs
from data_schema.queries.study import FactorRow, StudyRow, factors, the_study
from data_schema.vocabulary import FileRole, RunKind, RunState, Undefined
from data_schema.where import compile_where
from labbook.analysis.outcomes.charger_step import with_display_step
from labbook.analysis.outcomes.detection import BODY_HEIGHT
from labbook.config.parsing import Configuration, parse_configuration

VERTICAL_FORCE = "force_z"


@dataclass(frozen=True, slots=True)
class StudyData:
    """Facts for one analysis. `runs` are the selected jump runs, `idle` all idle runs of the book, void ones left out.

    `beside` are jump runs that count, of conditions of which none is selected.
    `void` holds what was left out: the selected jump runs and all idle runs that are void.
    By a run's uid, `logs` holds the signals with a body height, `forces` those with a vertical force on a plate, and
    `charges` what was put back after it; `calibrated` has the calibrated channels by the signal's uid. `waiting` are
    the files that give nothing until something is declared about them, `outdated` the names of those that were read
    with a profile that labbook.toml has otherwise now.
    """

    study: StudyRow
    configuration: Configuration
    selection: str
    factors: tuple[FactorRow, ...]
    selected: tuple[RunRow, ...]
    runs: tuple[RunRow, ...]
    beside: tuple[RunRow, ...]
    idle: tuple[RunRow, ...]
    void: tuple[RunRow, ...]
    charges: Mapping[str, list[ChargeOfRun]]
    logs: Mapping[str, list[SignalRow]]
    forces: Mapping[str, list[SignalRow]]
    decisions: Mapping[str, list[DecisionRow]]
    waiting: tuple[WaitingFile, ...] = ()
    calibrated: Mapping[str, tuple[CalibratedChannel, ...]] = field(default_factory=dict)
    outdated: tuple[str, ...] = ()

    @property
    def labels(self) -> dict[str, list[str]]:
        """The labels of each factor's levels, in their order."""
        return {row.name: [level.label for level in row.levels] for row in self.factors}

    def reasons(self, missing: Mapping[str, Undefined], role: FileRole) -> dict[str, Undefined]:
        """Return why runs lack a number; a waiting file of theirs comes before other reasons."""
        waiting = {run_uid: self.waits(run_uid, role) for run_uid in missing}
        return {run_uid: missing[run_uid] if why is None else why for run_uid, why in waiting.items()}

    def waits(self, run_uid: str, role: FileRole) -> Undefined | None:
        """Return why a run's logs, or its charge, cannot be used: a file of it waits; None where none does."""
        return waits(self.waiting, run_uid, role)


def waits(waiting: Iterable[WaitingFile], run_uid: str, role: FileRole) -> Undefined | None:
    """Return why files of a role cannot be used for a run: one of these waits; None where none does.

    Whose charges a charger's sheet holds is not known while it waits.
    """
    for item in waiting:
        if item.role == role and (run_uid in item.runs or (role is FileRole.CHARGE and not item.runs)):
            return item.why
    return None


def gather(connection: sa.Connection, configuration: Configuration, where: str | None) -> StudyData:
    """Read the facts of the runs that fulfil `where` (all of them without one)."""
    study = the_study(connection)
    if study is None:
        raise UsageError("the book has no study yet: describe it under [study] in labbook.toml and import its runs.")
    expression = compile_where(where, where_columns(connection)) if where else None
    selected = list_runs(connection, expression)
    everything = selected if expression is None else list_runs(connection)
    runs = tuple(run for run in selected if run.kind is RunKind.JUMPS and run.state is not RunState.VOID)
    taken = {run.condition_key for run in runs}
    waiting, signals = tuple(waiting_files(connection)), signals_of_runs(connection)
    return StudyData(
        study=study,
        configuration=configuration,
        selection=where or "",
        factors=factors(connection),
        selected=tuple(selected),
        runs=runs,
        beside=tuple(
            run
            for run in everything
            if run.kind is RunKind.JUMPS and run.state is not RunState.VOID and run.condition_key not in taken
        ),
        idle=tuple(run for run in everything if run.kind is RunKind.IDLE and run.state is not RunState.VOID),
        void=tuple(
            run
            for kind, several in ((RunKind.JUMPS, selected), (RunKind.IDLE, everything))
            for run in several
            if run.kind is kind and run.state is RunState.VOID
        ),
        charges=with_display_step(charges_by_run(connection), configuration.protocol.charger_resolution_mah),
        logs=_signals(signals, FileRole.LOG, waiting),
        forces=_signals(signals, FileRole.FORCE, waiting),
        decisions=jump_decisions(connection),
        waiting=waiting,
        calibrated=calibrated_channels(connection),
        outdated=outdated_files(connection, configuration),
    )


def records(signal: SignalRow, what: FileRole) -> bool:
    """Tell whether a signal is a log of body height, or a record of force; a log may hold both."""
    if what is FileRole.FORCE:
        return signal.role in (FileRole.FORCE, FileRole.LOG) and VERTICAL_FORCE in signal.channels
    return signal.role == FileRole.LOG and BODY_HEIGHT in signal.channels


def _signals(
    signals: Iterable[SignalRow], what: FileRole, waiting: Sequence[WaitingFile]
) -> dict[str, list[SignalRow]]:
    """Return the logs, or the records of force, by their run, but for runs of which a file of their role waits."""
    incomplete = {(file.role, run_uid) for file in waiting for run_uid in file.runs}
    usable = [one for one in signals if records(one, what) and (one.role, one.run_uid) not in incomplete]
    return grouped(usable, [signal.run_uid for signal in usable])


def gather_about(
    connection: sa.Connection, configuration: Configuration, about: Sequence[RunRow], beside: Sequence[RunRow] = ()
) -> StudyData:
    """Read what `gather` does of some runs alone, of runs `beside` them only the charges, and all idle runs.

    A book may have a hundred thousand others.
    """
    study = the_study(connection)
    assert study is not None, "a book with runs has a study"  # noqa: S101
    every = {run.uid: run for run in (*beside, *about)}.values()
    runs = [run for run in every if run.kind is RunKind.JUMPS and run.state is not RunState.VOID]
    idle = [run for run in idle_runs(connection) if run.state is not RunState.VOID]
    waiting = tuple(waiting_files(connection))
    signals = signals_of_runs(connection, run_uids=[run.uid for run in about])
    logs = _signals(signals, FileRole.LOG, waiting)
    return StudyData(
        study=study,
        configuration=configuration,
        selection="",
        factors=factors(connection),
        selected=tuple(runs),
        runs=tuple(runs),
        beside=(),
        idle=tuple(idle),
        void=(),
        charges=charges_of_runs(connection, [run.uid for run in (*runs, *idle)]),
        logs=logs,
        forces=_signals(signals, FileRole.FORCE, waiting),
        decisions=jump_decisions(connection, [signal.sha256 for several in logs.values() for signal in several]),
        waiting=waiting,
        calibrated={uid: found for run in about for uid, found in calibrated_channels(connection, run.uid).items()},
    )


def outdated_files(connection: sa.Connection, configuration: Configuration) -> tuple[str, ...]:
    """Return the names of the files in use whose reading used a profile that `configuration` lacks or has otherwise."""
    found = []
    for key, text in configurations_of_readings(connection).items():
        then, now = parse_configuration(text, "the book's configuration").profiles, configuration.profiles
        changed = {name for name, profile in then.items() if profile != now.get(name)}
        if not changed:
            continue
        for file_name, settings in settings_under(connection, key):
            used = {profile["name"] for profile in json.loads(settings)["declared"]["profiles"]}
            found += [file_name] if used & changed else []
    return tuple(found)


def outdated_sentence(files: tuple[str, ...]) -> str:
    """Say how many files are outdated and what reads them again."""
    named = f"{', '.join(files[:3])}{', ...' if len(files) > 3 else ''}"
    was = "1 file was" if len(files) == 1 else f"{len(files)} files were"
    return (
        f"{was} read with a profile that labbook.toml has otherwise now ({named}), and count as they were read: "
        "`labbook files reread --all` reads them again"
    )
