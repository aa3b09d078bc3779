"""Statements for tests, and what a book holds of all that was said."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from itertools import takewhile
from typing import Any, TypeVar

from data_schema import journal
from data_schema.journal import Entry
from data_schema.vocabulary import Action, ReasonCode, Verdict
from labbook.actions.runs.jump_review import review
from labbook.book.naming import run_named
from labbook.book.opening import Book
from labbook.book.write_session import Statement, WriteSession, new_uid
from tests.helpers.books import ADA

T = TypeVar("T")


def state(book: Book, action: Callable[..., T], *given: object, person: str = ADA, **named: Any) -> T:
    """Make a statement in a session of its own; an action that asks for book or configuration first gets them."""
    with book.session(person) as session:
        own = {"book": book, "session": session, "configuration": book.configuration}
        asked = takewhile(own.__contains__, inspect.signature(action).parameters)
        return action(*(own[name] for name in asked), *given, **named)


def note(session: WriteSession, text: str, run: str = "r001") -> None:
    target = run_named(session.connection, run).uid
    new = {"target_kind": "run", "target_uid": target, "text": text}
    session.state(Statement(Action.NOTE, "note", new_uid(), new=new))


def judge_blind(book: Book, run: str, number: int, verdict: Verdict, reason: ReasonCode, person: str = ADA) -> None:
    """State a verdict on a jump as one who does not see which run it is of."""
    with book.session(person) as session:
        found = review(book, session.connection, run)
        item = next(item for item in found.jumps if item.jump.number == number)
        new = {
            "target_kind": "jump",
            "target_uid": found.run.uid,
            "signal_sha256": item.signal_sha256,
            "anchor_s": item.jump.apex_s,
            "verdict": str(verdict),
            "reason_code": str(reason),
            "note": None,
            "old_value": item.jump.apex_height_m,
            "algorithm": found.detections[0].algorithm,
            "version": found.detections[0].version,
            "blind": 1,
        }
        session.state(Statement(verdict.action, "decision", new_uid(), new=new))


def notes(book: Book) -> list[str]:
    """All remarks in the table, in their order."""
    with book.reading() as connection:
        return list(connection.exec_driver_sql("SELECT text FROM note ORDER BY id").scalars())


def in_table(book: Book) -> list[Entry]:
    """The journal as the database has it, its chain verified."""
    with book.reading() as connection:
        return list(journal.verified_chain(journal.stored(connection)))


def in_file(book: Book) -> list[Entry]:
    """The journal as the file has it, its chain verified."""
    return list(book.mirror.entries())


def said_alike(book: Book) -> list[Entry]:
    """The journal, after checking that table and file tell the same."""
    entries = in_table(book)
    assert in_file(book) == entries
    return entries
