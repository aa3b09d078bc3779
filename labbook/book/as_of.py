"""A book as it stood at an entry of its journal, played back to there into a database of its own."""

from __future__ import annotations

import contextlib
import datetime
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from zoneinfo import ZoneInfo

from data_schema.engine import reading
from data_schema.errors import UsageError
from data_schema.queries.history import CommandEnd, command_ends
from data_schema.queries.study import config_in_force
from labbook.book.opening import Book
from labbook.book.replaying import replayed
from labbook.config.local_time import local_text
from labbook.config.parsing import parse_configuration


@dataclass(frozen=True, slots=True)
class PastBook:
    """A book for reading, as it stood after entry `seq`, and in words when that was."""

    book: Book
    seq: int
    called: str


@contextlib.contextmanager
def book_as_of(book: Book, asked: str, step: Callable[[str], None]) -> Iterator[PastBook]:
    """Have a book as it stood at an entry, by its number, or at a time: `2021-06-14`, `2021-06-14 12:30`, or with zone.

    Of a date the end of that day is meant, in the study's time zone. Samples are those of the book. Raises `UsageError`
    for what is neither, and where the book had no configuration yet.
    """
    zone = book.configuration.study.time_zone
    with book.reading() as connection:
        end = _end(command_ends(connection), asked, zone)
    with replayed(book.store, book.mirror, end.seq, step, use_cache=True) as (engine, _replay):
        with reading(engine) as connection:
            row = config_in_force(connection)
        if row is None:
            raise UsageError(f"at entry {end.seq} the book had no configuration yet: name a later one.")
        configuration = parse_configuration(row.text, "the book's configuration then")
        then = replace(book, configuration=configuration, engine=engine)
        yield PastBook(then, end.seq, f"entry {end.seq}, {local_text(end.at_utc, zone)}")


def _end(ends: list[CommandEnd], asked: str, zone: str) -> CommandEnd:
    """Return the end of the last command that was given by then."""
    if asked.isdecimal():
        if not ends or not ends[0].seq <= int(asked) <= ends[-1].seq:
            of = f"entries {ends[0].seq} to {ends[-1].seq}" if ends else "no entry"
            raise UsageError(f"--as-of {asked}: the journal has {of} (`labbook journal` lists them).")
        return [end for end in ends if end.seq <= int(asked)][-1]
    until = _instant(asked, zone)
    before = [end for end in ends if datetime.datetime.fromisoformat(end.at_utc) <= until]
    if not before:
        first = f", the first of {local_text(ends[0].at_utc, zone)}" if ends else ""
        raise UsageError(f"--as-of {asked}: no command had been given by then{first}.")
    return before[-1]


def _instant(asked: str, zone: str) -> datetime.datetime:
    try:
        found = datetime.datetime.fromisoformat(asked)
    except ValueError:
        raise UsageError(
            f"--as-of {asked!r} is neither the number of an entry nor a time: give for example 412, 2021-06-14 or "
            '"2021-06-14 12:30".'
        ) from None
    if len(asked.strip()) == len("2021-06-14"):
        found += datetime.timedelta(days=1)
    return found if found.tzinfo else found.replace(tzinfo=ZoneInfo(zone))
