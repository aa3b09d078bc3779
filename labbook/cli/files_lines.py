"""What `labbook files` is asked for and prints."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from data_schema.errors import UsageError
from labbook.actions.files.rereading import Reread
from labbook.actions.upkeep.stale import stale_lines
from labbook.book.opening import opened
from labbook.book.write_session import WriteSession
from labbook.terminal import emit


def check_reread_options(names: Sequence[str], every: bool, declared: bool, nothing: bool) -> None:
    """Raise `UsageError` where it is not clear what is to be read again, and how."""
    if bool(names) == every:
        raise UsageError("name the files to be read again, or give --all for those that labbook.toml reads otherwise.")
    if every and (declared or nothing):
        raise UsageError("what is declared here is about the files that are named: leave it out with --all.")


def reread_json(done: Reread) -> dict[str, Any]:
    """Return the record for programs."""
    return {
        "file": done.name,
        "sha256": done.sha256,
        "refused": done.read.refused,
        "changes": list(done.changes),
        "runs": list(done.runs),
        "stale": list(done.stale),
        "verdicts_waiting": list(done.waiting),
        "findings": [
            {"severity": str(finding.severity), "rule": finding.rule, "message": finding.message}
            for finding in done.read.findings
        ],
    }


def state(
    book: Path | None, person: str | None, make: Callable[[WriteSession], str], record: dict[str, Any], as_json: bool
) -> None:
    """Make one statement, and print its message and what became stale."""
    with opened(book) as opened_book, opened_book.session(person) as session:
        message = make(session)
        stale = session.stale
    emit({**record, "said": message, "stale": stale}, [message, *(stale_lines(stale) if stale else ())], as_json)
