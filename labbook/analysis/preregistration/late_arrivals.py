"""Charges and logs that came to a run after it had what counts, and those that came to it after a report was made.

A second charge, or a log more than the run has starts, leaves a run without the number that it had: that acts as an
exclusion, whoever meant it. What one command brings together, however many files it takes in, took nothing away from
anybody who had seen a number. A first charge or log that was in the book when a report was made, and was given to its
run only afterwards, takes the run in after others were seen; inboxes have to be emptied, so that it is told and not
labelled.
"""

from __future__ import annotations

from collections.abc import Sequence

import sqlalchemy as sa

from data_schema.outcomes import Outcome
from data_schema.queries.arrivals import Arrival
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import FileRole, RunKind, RunState
from labbook.analysis.preregistration.departures import Analysable, Departure
from labbook.analysis.preregistration.late_replacements import replacements
from labbook.analysis.preregistration.study_history import StudyHistory


def late_arrivals(_connection: sa.Connection, study_history: StudyHistory, now: Analysable) -> list[Departure]:
    """List what came to runs later than it should have, to be seen to make no difference."""
    replacing = {arrival for item in replacements(study_history, now) for arrival in item.came}
    found = []
    for quantity in study_history.arrivals:
        for run in now.runs:
            if run.state is not RunState.VOID:
                several = study_history.that_count(quantity, run.uid)
                found += _further(now, run, quantity, several)
                first = [item for item in several if item not in replacing]
                found += _taken_in(now, run, quantity, first, study_history.reports)
    return found


def _further(now: Analysable, run: RunRow, quantity: Outcome, several: Sequence[Arrival]) -> list[Departure]:
    """Tell what came when the run had all that it can have, and took its number away."""
    most = max(run.starts, 1) if quantity.source is FileRole.LOG else 1
    if len(several) <= most or quantity in now.given(run) or quantity not in _with_only(now, run, several[:most]):
        return []
    had, taken = several[most - 1], f"which leaves run {run.name} without {quantity}"
    return [
        Departure(
            f"{_named(item, quantity)} came to run {run.name} when it had its {quantity.source} ({item.person}, "
            f"{item.at_utc[:10]}), {taken}",
            (quantity,),
            None if run.kind is RunKind.IDLE else (run.condition_key,),
        )
        for item in several[most:]
        # What was taken from another run is told as a correction.
        if item.command != had.command and not item.moved
    ]


def _with_only(now: Analysable, run: RunRow, few: Sequence[Arrival]) -> frozenset[Outcome]:
    """Return what the run gives where it has nothing but these."""
    uids, files = {item.uid for item in few}, {item.file_sha256 for item in few}
    charges = [item for item in now.charges.get(run.uid, []) if item.uid in uids]
    logs = [item for item in now.logs.get(run.uid, []) if item.file_sha256 in files]
    return Analysable((run,), {run.uid: charges}, {run.uid: logs}).given(run)


def _named(item: Arrival, quantity: Outcome) -> str:
    if quantity.source is FileRole.LOG:
        return str(item.name)
    return "a further charge" if item.name is None else f"a further charge of {item.name}"


def _taken_in(
    now: Analysable, run: RunRow, quantity: Outcome, several: Sequence[Arrival], reports: Sequence[int]
) -> list[Departure]:
    """Tell what was read before a report and given to its run after it."""
    if quantity not in now.given(run):
        return []
    return [
        Departure(
            f"the {quantity.source} of run {run.name} was in the book when a report was made, and was given to it only "
            f"afterwards ({item.person}, {item.at_utc[:10]})"
        )
        for item in several
        if not item.moved and any(item.read_seq < made < item.seq and not item.belonged(made) for made in reports)
    ]
