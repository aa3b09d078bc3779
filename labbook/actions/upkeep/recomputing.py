"""`labbook why ID --check`: a number computed anew from raw copies and journal, compared to the last digit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields

import sqlalchemy as sa

from data_schema import journal
from data_schema.engine import reading
from data_schema.errors import UnknownName
from data_schema.queries.results import NumberRow, result_of_number
from labbook.actions.upkeep.tracing import Trace, trace_of
from labbook.book.differing import differences
from labbook.book.opening import Book
from labbook.book.replaying import replayed


@dataclass(frozen=True, slots=True)
class Recomputed:
    """A number as it is stored and as it came out anew, None where raw copies and journal do not give it.

    `differs` names the columns (value, standard error, ends of the interval, ...) that are not the same double. `trace`
    is where the recomputed number came from, `as_traced` whether the book has the same trace. `other_versions`:
    versions of readers or algorithms made the book that this labbook does not have.
    """

    stored: NumberRow
    anew: NumberRow | None
    differs: tuple[str, ...]
    trace: Trace | None = None
    as_traced: bool = True
    other_versions: bool = False

    @property
    def stands(self) -> bool | None:
        """Whether the number is as stored, from the inputs that the book has; None where that cannot be decided."""
        if self.anew is None:
            return None if self.other_versions else False
        return not self.differs and self.as_traced

    @property
    def sentence(self) -> str:
        """Say whether the number stands."""
        uid = self.stored.uid
        if self.stands is None:
            return (
                f"{uid} could not be recomputed: this labbook's versions give the number another id; make the report "
                "again to see it."
            )
        if self.anew is None:
            return (
                f"{uid} does not stand: raw copies and journal do not give it, so what it rests on was altered; "
                "`labbook db check` names it, `labbook rebuild` mends it."
            )
        if self.differs:
            values = "; ".join(
                f"{name} is {getattr(self.stored, name)!r} and should be {getattr(self.anew, name)!r}"
                for name in self.differs
            )
            return f"{uid} does not stand: {values}; `labbook db check` names what was altered."
        if not self.as_traced:
            return (
                f"{uid} recomputed from raw copies and journal: the same to the last digit; but the database says "
                "otherwise of what it rests on: `labbook db check` names what was altered. What follows is as raw "
                "copies and journal have it."
            )
        return f"{uid} recomputed from raw copies and journal: the same to the last digit."


def recompute(book: Book, uids: Sequence[str], step: Callable[[str], None]) -> list[Recomputed]:
    """Compute stored numbers anew in one replay of the journal; raises `UnknownName` for one that is not stored."""
    with book.reading() as connection:
        until, _hash = journal.head(connection)
        stored = [result_of_number(connection, uid) for uid in uids]
        missing = next((uid for uid, found in zip(uids, stored, strict=True) if found is None), None)
        if missing is not None:
            raise UnknownName(
                f"{missing} is no number that the book holds now: it was printed by an earlier labbook; make the "
                "report again and check a number of that."
            )
        numbers = [number for _row, number in filter(None, stored)]
        with replayed(book.store, book.mirror, until, step) as (engine, replay), reading(engine) as fresh:
            other_versions = differences(fresh, journal.stored(fresh), replay.without_rows).other_versions
            return [_compared(connection, fresh, number, other_versions) for number in numbers]


def _compared(book: sa.Connection, fresh: sa.Connection, stored: NumberRow, other_versions: bool) -> Recomputed:
    found = result_of_number(fresh, stored.uid)
    if found is None:
        return Recomputed(stored, None, (), other_versions=other_versions)
    anew = found[1]
    names = [field.name for field in fields(NumberRow)]
    differs = [name for name in names if repr(getattr(stored, name)) != repr(getattr(anew, name))]
    here, there = trace_of(book, stored.uid), trace_of(fresh, stored.uid)
    return Recomputed(stored, anew, tuple(differs), there, here == there)
