"""What happened since the first measurement: reports, corrections, and which runs had which logs and charges."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import sqlalchemy as sa

from data_schema.outcomes import Outcome
from data_schema.queries.arrivals import Arrival, charge_arrivals, log_arrivals, reports_made, samples_of_files
from data_schema.queries.changes import Change, changes_after
from data_schema.queries.charges import ChargeOfRun, every_charge
from data_schema.vocabulary import ChargeMode, FileRole
from labbook.analysis.outcomes.detecting import BODY_HEIGHT

_ARRIVALS = {FileRole.CHARGE: charge_arrivals, FileRole.LOG: log_arrivals}


@dataclass(frozen=True, slots=True)
class StudyHistory:
    """`reports` are entries, `arrivals` by quantity and the run's uid, `heights` the samples of logs by their file."""

    reports: Sequence[int]
    changes: Sequence[Change]
    arrivals: Mapping[Outcome, Mapping[str, Sequence[Arrival]]]
    charges: Mapping[str, ChargeOfRun]
    heights: Mapping[str, frozenset[str]]

    def said(self, uid: str, column: str, now: Any, seq: int) -> Any:
        """Return what a column of a run or a charge said at an entry, where it says `now` in the end."""
        later = (item.old[column] for item in self.changes if item.uid == uid and item.seq > seq and column in item.old)
        return next(later, now)

    def that_count(self, quantity: Outcome, run_uid: str, seq: int | None = None) -> list[Arrival]:
        """Return the charges that charged, or the logs with a body height, of a run at an entry; now, without one.

        Contents that others have too are left out.
        """
        items = self.arrivals[quantity].get(run_uid, ())
        there = [item for item in items if (item.stayed if seq is None else item.belonged(seq))]
        if quantity.source is FileRole.CHARGE:
            return [item for item in there if self._mode(item, seq) == ChargeMode.CHARGE]
        known: set[str] = set()
        found = []
        for item in there:
            if self.content(item) - known:
                found.append(item)
            known |= self.content(item)
        return found

    def content(self, item: Arrival, seq: int | None = None) -> frozenset[Any]:
        """Return what a number is made of: a log's samples, or what a charge said at an entry; now, without one."""
        if item.uid not in self.charges:
            return self.heights.get(item.uid, frozenset())
        now = self.charges[item.uid].charge_mah
        return frozenset([now if seq is None else self.said(item.uid, "charge_mah", now, seq)])

    def _mode(self, item: Arrival, seq: int | None) -> Any:
        now = self.charges[item.uid].mode
        return now if seq is None else self.said(item.uid, "mode", now, seq)


def read_study_history(connection: sa.Connection, first_seq: int) -> StudyHistory:
    """Read what happened after the entry of the first measurement."""
    reports = reports_made(connection)
    found: dict[Outcome, dict[str, list[Arrival]]] = {}
    for quantity in (Outcome.JOULES, Outcome.APEX):
        of_runs = found.setdefault(quantity, {})
        for arrival in _ARRIVALS[quantity.source](connection, reports):
            of_runs.setdefault(arrival.run_uid, []).append(arrival)
    return StudyHistory(
        reports,
        changes_after(connection, first_seq),
        found,
        {item.uid: item for item in every_charge(connection)},
        samples_of_files(connection, BODY_HEIGHT),
    )
