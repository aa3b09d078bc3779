"""The rows of sheets about some runs, fetched at once, and as they stand while one after another is placed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from data_schema.queries.facts import update_fact
from data_schema.queries.runs import run_uids_named
from data_schema.queries.sheet_rows import SheetRow, repeating, rows_about
from data_schema.vocabulary import ChargeState
from labbook.statements.apply_context import ApplyContext
from labbook.statements.said_by_hand import SaidByHand, said_by_hand

STANDING = (ChargeState.COUNTED, ChargeState.DISMISSED)
"""States of a row that others may repeat."""


class RowsAround:
    """What the rows to be placed may repeat, contradict or displace.

    `said` is what people said of each row here, `runs` the uids of the runs that rows name. The rows to be placed count
    nowhere when this is made; those in `back` displace what repeats them.
    """

    __slots__ = ("_named", "_of_run", "_repeating", "_rows", "_scene", "runs", "said")

    def __init__(
        self,
        context: ApplyContext,
        rows: Sequence[SheetRow],
        said: Mapping[str, SaidByHand],
        run_uids: Sequence[str],
        back: Sequence[str],
    ) -> None:
        self._scene = context
        names = sorted({row.stated_run for row in rows if row.stated_run is not None})
        self.runs = run_uids_named(context.connection, names)
        about = rows_about(context.connection, sorted({*run_uids, *self.runs.values()}), names)
        repeats = repeating(context.connection, back, ChargeState.COUNTED)
        self._rows: dict[str, SheetRow] = {}
        self._of_run: dict[str, dict[str, None]] = {}
        self._named: dict[str, dict[str, None]] = {}
        for row in (*rows, *about, *(row for some in repeats.values() for row in some)):
            self._rows[row.uid] = row
            self._of_run.setdefault(row.run_uid or "", {})[row.uid] = None
            self._named.setdefault(row.stated_run or "", {})[row.uid] = None
        self._repeating = {uid: [row.uid for row in some] for uid, some in repeats.items()}
        others = [uid for uid in self._rows if uid not in said]
        self.said = {**said, **said_by_hand(context, others)}

    def about(self, run_uid: str | None, run_name: str | None) -> list[SheetRow]:
        """Return the rows that count for a run, then those that name one and belong to none; dismissed ones too."""
        of_run = [self._rows[uid] for uid in self._of_run.get(run_uid or "", ())] if run_uid else []
        named = [self._rows[uid] for uid in self._named.get(run_name or "", ())] if run_name is not None else []
        found = [row for row in of_run if row.state is ChargeState.COUNTED]
        found += [row for row in named if row.run_uid is None and row.state in STANDING]
        return sorted(found, key=lambda row: (row.run_uid is None, row.order))

    def repeating(self, uid: str) -> list[SheetRow]:
        """Return the rows that count and said the same as this one before."""
        rows = [self._rows[other] for other in self._repeating.get(uid, ())]
        return [row for row in rows if row.state is ChargeState.COUNTED and row.repeats == uid]

    def set(self, row: SheetRow, state: ChargeState, run_uid: str | None, repeats: str | None = None) -> None:
        """Say where a row stands from now on."""
        values = {"state": str(state), "run": run_uid, "repeats": repeats}
        update_fact(self._scene.connection, "charge", row.uid, values)
        self._of_run[self._rows[row.uid].run_uid or ""].pop(row.uid)
        self._rows[row.uid] = replace(self._rows[row.uid], state=state, run_uid=run_uid, repeats=repeats)
        self._of_run.setdefault(run_uid or "", {})[row.uid] = None
