"""Logs and charges that took the place of others after a report had been made.

The run keeps a number, but another than the one that was seen: it could have been replaced to please, as a run could
have been moved to another condition, and what rests on its condition is exploratory. A charge whose value was corrected
is the same charge, and is told as a correction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sqlalchemy as sa

from data_schema.outcomes import Outcome
from data_schema.queries.arrivals import Arrival
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import FileRole, RunKind, RunState
from labbook.analysis.preregistration.departures import Analysable, Departure
from labbook.analysis.preregistration.study_history import StudyHistory


@dataclass(frozen=True, slots=True)
class Replaced:
    """What a run's number rested on when a report was made and does not now, and what it rests on instead, if any."""

    run: RunRow
    quantity: Outcome
    gone: tuple[Arrival, ...]
    came: tuple[Arrival, ...]


def late_replacements(_connection: sa.Connection, study_history: StudyHistory, now: Analysable) -> list[Departure]:
    """Tell which file or charge replaced which; one that nothing replaced is told as taken off."""
    found = []
    for item in [item for item in replacements(study_history, now) if item.came]:
        last = max(item.came, key=lambda arrival: arrival.seq)
        found.append(
            Departure(
                f"{_named(item.came, item.quantity)} replaced {_named(item.gone, item.quantity)} as the "
                f"{item.quantity.source} of run {item.run.name} after a report had been made ({last.person}, "
                f"{last.at_utc[:10]})",
                (item.quantity,),
                None if item.run.kind is RunKind.IDLE else (item.run.condition_key,),
            )
        )
    return found


def replacements(study_history: StudyHistory, now: Analysable) -> list[Replaced]:
    """List the runs that have a number, as at a report, but not from all the logs or the charge of then."""
    found = []
    for quantity in study_history.arrivals:
        for run in now.runs:
            if run.state is not RunState.VOID and quantity in now.given(run):
                gone, came = _exchanged(study_history, run, quantity)
                if gone:
                    found.append(Replaced(run, quantity, gone, came))
    return found


def _exchanged(
    study_history: StudyHistory, run: RunRow, quantity: Outcome
) -> tuple[tuple[Arrival, ...], tuple[Arrival, ...]]:
    most = max(run.starts, 1) if quantity.source is FileRole.LOG else 1
    has = study_history.that_count(quantity, run.uid)
    gone: dict[Arrival, None] = {}
    came: dict[Arrival, None] = {}
    for made in study_history.reports:
        had = study_history.that_count(quantity, run.uid, made)
        left = _without(had, has, study_history, made, None)
        new = _without(has, had, study_history, None, made)
        if left and len(had) <= most:
            gone |= dict.fromkeys(left)
            came |= dict.fromkeys(new)
    return tuple(gone), tuple(came)


def _without(
    some: Sequence[Arrival],
    others: Sequence[Arrival],
    study_history: StudyHistory,
    seq: int | None,
    other_seq: int | None,
) -> list[Arrival]:
    """Return those whose content the others have not, each at its entry."""
    uids = {item.uid for item in others}
    known = {part for item in others for part in study_history.content(item, other_seq)}
    return [item for item in some if item.uid not in uids and study_history.content(item, seq) - known]


def _named(items: Sequence[Arrival], quantity: Outcome) -> str:
    if quantity.source is FileRole.LOG:
        return " and ".join(str(item.name) for item in items)
    return " and ".join("a typed charge" if item.name is None else f"a charge of {item.name}" for item in items)
