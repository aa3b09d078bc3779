"""A book as it stood at an entry of its journal, played back to there into a database of its own."""

from __future__ import annotations

import contextlib
import datetime
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from zoneinfo import ZoneInfo

import sqlalchemy as sa

from data_schema.engine import reading
from data_schema.errors import BookDamaged, UsageError
from data_schema.journal import MEND_FILE
from data_schema.queries.files import lost_copies
from data_schema.queries.history import CommandEnd, command_ends
from data_schema.queries.study import config_in_force
from labbook.book.opening import Book
from labbook.book.replaying import replayed
from labbook.config.local_time import local_text
from labbook.config.parsing import Configuration, parse_configuration


@dataclass(frozen=True, slots=True)
class PastBook:
    """What a book held after an entry, for reading, and in words which and when that was."""

    connection: sa.Connection
    configuration: Configuration
    called: str


@contextlib.contextmanager
def book_as_of(book: Book, asked: str, step: Callable[[str], None]) -> Iterator[PastBook]:
    """Have a book as it stood at an entry, by its number, or at a time: `2021-06-14`, `2021-06-14 12:30`, or with zone.

    Of a date, a minute or a second its end is meant, in the study's time zone. Samples are those of the book's store.
    Raises `UsageError` for what is neither, and where the book had no configuration yet; `BookDamaged` where the
    journal file is not that of the database.
    """
    zone = book.configuration.study.time_zone
    with book.reading() as connection:
        end = _end(command_ends(connection), asked, zone)
        lost = lost_copies(connection)
    with replayed(book.store, book.mirror, end.seq, step, use_cache=True, lost=lost) as (engine, replay):
        if replay.reached != (end.seq, end.hash):
            raise BookDamaged(f"journal.jsonl does not hold entry {end.seq} of the database: {MEND_FILE}.")
        with reading(engine) as connection:
            row = config_in_force(connection)
            if row is None:
                raise UsageError(f"at entry {end.seq} the book had no configuration yet: name a later one.")
            configuration = parse_configuration(row.text, "the book's configuration then")
            yield PastBook(connection, configuration, f"entry {end.seq}, {local_text(end.at_utc, zone)}")


def _end(ends: Sequence[CommandEnd], asked: str, zone: str) -> CommandEnd:
    """Return the end of the last command that was given by then."""
    if asked.isdecimal() and len(asked) < len("20210614"):
        before = [end for end in ends if end.seq <= int(asked)]
        if not before or int(asked) > ends[-1].seq:
            of = f"its first command ends at entry {ends[0].seq}, the last at {ends[-1].seq}" if ends else "it has none"
            raise UsageError(f"--as-of {asked} is no entry of the journal: {of} (`labbook journal`).")
        return before[-1]
    until = _instant(asked, zone)
    before = [end for end in ends if datetime.datetime.fromisoformat(end.at_utc) < until]
    if not before:
        first = f", the first of {local_text(ends[0].at_utc, zone)}" if ends else ""
        raise UsageError(f"--as-of {asked}: no command had been given by then{first}.")
    return before[-1]


_TIME = re.compile(r"(\d{4}-\d\d-\d\d)(?:[T ](\d\d:\d\d)(?::(\d\d)(\.\d{1,6})?)?)? ?([+-]\d\d:?\d\d|[A-Za-z]+)?")
"""A date, and what may follow: minutes, seconds, a fraction, and an offset, Z, or the zone's letters as lists have."""
_LASTS = ({"days": 1}, {"minutes": 1}, {"seconds": 1}, {"milliseconds": 1})
"""How long the last of what a time says lasts: a date, a minute, a second, a fraction."""


def _instant(asked: str, zone: str) -> datetime.datetime:
    """Return the end of what a time says, by the clock of a zone where it names no other."""
    with contextlib.suppress(ValueError, OverflowError):
        if (found := _TIME.fullmatch(asked.strip())) is not None:
            date, minute, second, fraction, offset = found.groups()
            moment = datetime.datetime.fromisoformat(f"{date}T{minute or '00:00'}:{second or '00'}{fraction or ''}")
            moment = _in_zone(moment, offset, zone).astimezone(datetime.UTC)
            lasts = datetime.timedelta(**_LASTS[sum(part is not None for part in (minute, second, fraction))])
            return moment + min(lasts, datetime.datetime.max.replace(tzinfo=datetime.UTC) - moment)
    raise UsageError(
        f"--as-of {asked!r} is neither the number of an entry nor a time: give for example 412, 2021-06-14, "
        '"2021-06-14 12:30" or a time as `labbook journal` lists it.'
    )


def _in_zone(moment: datetime.datetime, offset: str | None, zone: str) -> datetime.datetime:
    """Return a moment with its zone; raises `ValueError` for letters that the zone does not have then."""
    if offset is not None and offset[0] in "+-Z":
        return datetime.datetime.fromisoformat(f"{moment.isoformat()}{offset}")
    for fold in (0, 1):
        local = moment.replace(tzinfo=ZoneInfo(zone), fold=fold)
        if offset in (None, local.tzname()):
            return local
    raise ValueError(offset)
