"""Giving the command of a finding of `attention` by a button, where no more than a reason is wanted.

Jumps are not accepted so: a person looks at them first.
"""

from __future__ import annotations

import subprocess
import sys

from data_schema.errors import BookBusy, InputRefused, UsageError
from labbook.actions.runs.finding import Blank, Finding
from labbook.book.opening import Book

COMMAND = (sys.executable, "-c", "from labbook.cli.start import main; main()")


def mending(found: Finding) -> str | None:
    """Return what a button says; None where the command shows something, or a person fills it in."""
    if not {*found.fill_in} <= {Blank.WHY}:
        return None
    match ["".join(word) for word in found.words]:
        case ["assign", _, "none", *_]:
            return "Take it off the run"
        case ["assign", _, run, *_]:
            return f"Assign to {run}"
        case ["check", *_]:
            return "It was made and passed"
        case ["correct", *_]:
            return "Correct"
        case ["files", "reread", *_]:
            return "Read again"
        case ["files", "withdraw", *_]:
            return "Withdraw"
        case ["jumps", "clear", *_]:
            return "Take back"
        case ["runs", "dismiss", *_]:
            return "Dismiss"
    return None


def mend(book: Book, person: str | None, found: Finding, why: str) -> None:
    """Give the command of a finding as `person`; raises what it says, and `UsageError` where it has no button."""
    if mending(found) is None:
        raise UsageError(f"`{found.command}` is for a person to give: copy it, and fill in what stands in capitals.")
    if found.fill_in and not why.strip():
        raise UsageError("the reason is empty: say why in a few words, the journal keeps them.")
    words = [why if word is Blank.WHY else "".join(word) for word in found.words]
    who = [] if person is None else ["--as", person]
    done = subprocess.run(
        [*COMMAND, *words, *who, "--book", str(book.folder.resolve())],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:
        said = done.stderr.strip().rpartition("labbook: ")[2] or " ".join(done.stdout.split())
        raise (BookBusy if done.returncode == BookBusy.exit_code else InputRefused)(said)
