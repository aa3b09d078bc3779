"""What the command of a finding of `attention` does, done by a button: through the functions that the command calls.

Only what `attention` found is carried out, from the words that it gave, and only where no more than a reason is wanted.
Jumps are not accepted so: a person looks at them first.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from data_schema.errors import InputRefused, UsageError
from labbook.actions.files.assigning import NO_RUN, assign
from labbook.actions.files.rereading import RereadRequest, reread_lines
from labbook.actions.files.stored_files import dismiss, files_to_reread, reread_named, withdraw
from labbook.actions.runs.attention import Blank, Found
from labbook.actions.runs.correcting import correct
from labbook.actions.runs.day_checks import state_check
from labbook.actions.runs.jump_review import clear_waiting, review
from labbook.book.opening import Book
from labbook.book.write_session import WriteSession, new_uid
from labbook.config.profiles import declared_column


@dataclass(frozen=True, slots=True)
class Mending:
    """What a command does: in a word or two for a button, and the function that does it as one person says."""

    verb: str
    state: Callable[[Book, str | None], object]


def mending(found: Found, why: str = "") -> Mending | None:
    """Return what mends a finding for this reason; None where its command shows something, or a person fills it in."""
    if not {*found.fill_in} <= {Blank.WHY}:
        return None
    match [why if word is Blank.WHY else "".join(word) for word in found.words]:
        case ["assign", item, "none", "--why", why]:
            return _stating("Take it off the run", lambda session: assign(session, item, NO_RUN, why))
        case ["assign", item, run]:
            return _stating("Assign", lambda session: assign(session, item, run, None))
        case ["assign", item, run, "--why", why]:
            return _stating(f"Assign to {run}", lambda session: assign(session, item, run, why))
        case ["check", kind, "--day", day]:
            return Mending("It was made and passed", partial(_check, kind, day))
        case ["correct", target, *changes, "--why", why]:
            return Mending("Correct", partial(_correct, target, changes, why))
        case ["files", "reread", "--all"]:
            return Mending("Read all again", _reread_all)
        case ["files", "reread", name]:
            return Mending("Read again", partial(_reread, [name], None))
        case ["files", "reread", name, "--column", column]:
            return Mending("Read again", partial(_reread, [name], column))
        case ["files", "withdraw", name, "--why", why]:
            return _stating("Withdraw", lambda session: withdraw(session, name, why))
        case ["jumps", "clear", run, "waiting"]:
            return Mending("Take back", partial(_clear, run))
        case ["runs", "dismiss", item, "--why", why]:
            return _stating("Dismiss", lambda session: dismiss(session, item, why))
        case _:
            return None


def mend(book: Book, person: str | None, found: Found, why: str) -> None:
    """Do what the command of a finding does; raises `UsageError` where that wants more, or the reason is empty."""
    way = mending(found, why)
    if way is None:
        raise UsageError(f"`{found.command}` is for a person to give: copy it, and fill in what stands in capitals.")
    if found.fill_in and not why.strip():
        raise UsageError("the reason is empty: say why in a few words, the journal keeps them.")
    way.state(book, person)


def _stating(verb: str, state: Callable[[WriteSession], object]) -> Mending:
    """Return what needs a session alone."""

    def in_session(book: Book, person: str | None) -> None:
        with book.session(person) as session:
            state(session)

    return Mending(verb, in_session)


def _check(kind: str, day: str, book: Book, person: str | None) -> None:
    with book.session(person) as session:
        state_check(session, book.configuration, kind, None, None, True, day)


def _correct(target: str, changes: Sequence[str], why: str, book: Book, person: str | None) -> None:
    with book.session(person, correcting=True) as session:
        correct(book, session, target, changes, why)


def _reread_all(book: Book, person: str | None) -> None:
    _reread([row.file_uid or "" for row in files_to_reread(book, lambda _name: None)], None, book, person, new_uid())


def _reread(names: Sequence[str], column: str | None, book: Book, person: str | None, batch: str | None = None) -> None:
    options = {} if column is None else {"columns": dict([declared_column(column)])}
    done = [reread_named(book, name, RereadRequest(options, person, batch=batch)) for name in names]
    refused = [f"{one.file}: {' '.join(reread_lines(one, dry_run=False))}" for one in done if one.read.refused]
    if refused:
        raise InputRefused("; ".join(refused))


def _clear(run: str, book: Book, person: str | None) -> None:
    found = None
    with contextlib.suppress(UsageError), book.reading() as connection:
        found = review(book, connection, run)
    with book.session(person) as session:
        clear_waiting(book, session, run, None, found)
