"""`labbook why ID --check`: a number computed anew from raw copies and journal, compared to the last digit."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields

from data_schema import journal
from data_schema.engine import reading
from data_schema.errors import UnknownName
from data_schema.queries.results import NumberRow, result_of_number
from labbook.book.opening import Book
from labbook.book.replaying import replayed


@dataclass(frozen=True, slots=True)
class Recomputed:
    """A number as it is stored and as it came out anew, None where this labbook computes it under another id.

    `differs` names the columns (value, standard error, ends of the interval, ...) that are not the same double.
    """

    stored: NumberRow
    anew: NumberRow | None
    differs: tuple[str, ...]

    @property
    def sentence(self) -> str:
        """Say whether the number stands."""
        if self.anew is None:
            return (
                f"{self.stored.uid} could not be recomputed: this labbook's versions give the number another id; make "
                "the report again to see it."
            )
        if not self.differs:
            return f"{self.stored.uid} recomputed from raw copies and journal: the same to the last digit."
        values = "; ".join(
            f"{name} is {getattr(self.stored, name)!r} and should be {getattr(self.anew, name)!r}"
            for name in self.differs
        )
        return f"{self.stored.uid} does not stand: {values}; `labbook db check` names what was altered."


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
    with replayed(book.store, book.mirror, until, step) as (engine, _replay), reading(engine) as fresh:
        return [_compared(number, result_of_number(fresh, number.uid)) for number in numbers]


def _compared(stored: NumberRow, found: tuple[object, NumberRow] | None) -> Recomputed:
    if found is None:
        return Recomputed(stored, None, ())
    anew = found[1]
    names = [field.name for field in fields(NumberRow)]
    differs = [name for name in names if repr(getattr(stored, name)) != repr(getattr(anew, name))]
    return Recomputed(stored, anew, tuple(differs))
