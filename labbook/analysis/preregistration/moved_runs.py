"""Runs that stand in another condition than when a report was made.

Such a run could have been moved to please, and both conditions are exploratory. One that was moved before the first
report, or was back in its condition at each, stands where every report saw it.
"""

from __future__ import annotations

import sqlalchemy as sa

from data_schema.outcomes import Outcome
from data_schema.queries.conditions import conditions_by_key
from data_schema.vocabulary import RunKind
from labbook.analysis.preregistration.departures import Analysable, Departure
from labbook.analysis.preregistration.study_history import StudyHistory


def moved_runs(connection: sa.Connection, study_history: StudyHistory, now: Analysable) -> list[Departure]:
    """Tell which runs with numbers were moved after a report, and between which conditions."""
    moved = conditions_at_reports(study_history, now)
    keys = {uid: key for key, uid in conditions_by_key(connection).items()} if moved else {}
    found = []
    for run in now.runs:
        if run.uid in moved:
            were = [keys[uid] if uid else "none" for uid in moved[run.uid]]
            last = [item for item in study_history.changes if item.uid == run.uid and "condition" in item.new][-1]
            found.append(
                Departure(
                    f"the condition of run {run.name} was corrected after a report had been made: it was "
                    f"{' and '.join(were)} and is {run.condition_key} ({last.person}, {last.at_utc[:10]})",
                    tuple(item for item in Outcome if item in now.given(run)),
                    (*were, run.condition_key),
                )
            )
    return found


def conditions_at_reports(study_history: StudyHistory, now: Analysable) -> dict[str, tuple[str | None, ...]]:
    """Return the other conditions in which reports saw a run that has numbers, by uids."""
    found = {}
    for run in now.runs:
        if run.kind is RunKind.JUMPS and now.given(run):
            seen = [study_history.said(run.uid, "condition", run.condition_uid, made) for made in study_history.reports]
            others = tuple(dict.fromkeys(uid for uid in seen if uid != run.condition_uid))
            if others:
                found[run.uid] = others
    return found
