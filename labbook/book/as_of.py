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
from data_schema.queries.history import CommandEnd, command_ends
from data_schema.queries.study import config_in_force
from labbook.book.opening import Book
from labbook.book.replaying import replayed
from labbook.config.local_time import local_text
from labbook.config.parsing import Configuration, parse_configuration


@dataclass(frozen=True, slots=True)
class PastBook:
    """What a book held after entry `seq`, for reading, and in words when that was."""

    connection: sa.Connection
    configuration: Configuration
    seq: int
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
    with replayed(book.store, book.mirror, end.seq, step, use_cache=True) as (engine, replay):
        if replay.reached != (end.seq, end.hash):
            raise BookDamaged(f"journal.jsonl does not hold entry {end.seq} of the database: {MEND_FILE}.")
        with reading(engine) as connection:
            row = config_in_force(connection)
            if row is None:
                raise UsageError(f"at entry {end.seq} the book had no configuration yet: name a later one.")
            configuration = parse_configuration(row.text, "the book's configuration then")
            yield PastBook(connection, configuration, end.seq, f"entry {end.seq}, {local_text(end.at_utc, zone)}")


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


_FORMS: Sequence[tuple[str, datetime.timedelta]] = (
    (r"\d{4}-\d\d-\d\d", datetime.timedelta(days=1)),
    (r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d", datetime.timedelta(minutes=1)),
    (r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d", datetime.timedelta(seconds=1)),
    (r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d:\d\d\.\d{1,6}", datetime.timedelta(milliseconds=1)),
)
"""How a time is written, and how long the last of what it says lasts."""


def _instant(asked: str, zone: str) -> datetime.datetime:
    """Return the end of what a time says; behind it may stand an offset, Z, or the zone's own letters as lists have."""
    text, offset = _parted(asked.strip())
    for form, lasts in _FORMS:
        with contextlib.suppress(ValueError, OverflowError):
            if not re.fullmatch(form, text):
                continue
            moment = datetime.datetime.fromisoformat(text + offset) if offset[:1] in ("+", "-", "Z") else None
            local = datetime.datetime.fromisoformat(text).replace(tzinfo=ZoneInfo(zone))
            names = {fold: local.replace(fold=fold).tzname() for fold in (0, 1)}
            if moment is None and offset and offset not in names.values():
                continue
            if moment is None:
                moment = local.replace(fold=int(bool(offset) and names[0] != offset))
            moment = moment.astimezone(datetime.UTC)
            return moment + min(lasts, datetime.datetime.max.replace(tzinfo=datetime.UTC) - moment)
    raise UsageError(
        f"--as-of {asked!r} is neither the number of an entry nor a time: give for example 412, 2021-06-14, "
        '"2021-06-14 12:30" or a time as `labbook journal` lists it.'
    )


def _parted(text: str) -> tuple[str, str]:
    """Part a time from its offset or zone."""
    found = re.fullmatch(r"(\d{4}-\d\d-\d\d(?:[T ][\d:.]+)?) ?((?:[+-]\d\d:?\d\d|[A-Za-z]+)?)", text)
    return (found[1], found[2]) if found else (text, "")
