"""System calls that fail: which calls a command makes on the files of a folder, and the nth of them refused.

`failing_calls.c` stands between a process and libc, and so under Python, SQLite and pyarrow alike.
"""

from __future__ import annotations

import errno
import re
import shutil
import subprocess
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tests.helpers.commands import Commands
from tests.helpers.once import made_once

SOURCE = Path(__file__).with_suffix(".c")
NEEDS_SPACE = frozenset({"create", "write", "fsync", "ftruncate", "truncate", "rename", "link", "mkdir"})
BY_NAME = frozenset({"open", "create", "opendir", "stat", "rename", "link", "unlink", "mkdir", "truncate", "chmod"})
ERRORS = {errno.EIO: None, errno.ENOSPC: NEEDS_SPACE, errno.EACCES: BY_NAME}
"""Which calls end with an error, None for all of them; a full disk stays full."""


_OF_ONE_FILE = re.compile(r"(?<=/figures/)\.?\w+|(?<=/tables/)\.?\w+|[0-9a-f]{2,}")
"""What tells files of one kind apart in their names: hashes, numbers, and what a figure or table is of."""


@dataclass(frozen=True, slots=True)
class Call:
    """The nth call of a command: what it does and to which path."""

    number: int
    name: str
    path: str


def compiler() -> str | None:
    """Return the C compiler."""
    return shutil.which("cc")


def between() -> list[str]:
    """The words to put before a program so that its calls can fail."""

    def compiled(folder: Path) -> Path:
        library = folder / "failing_calls.so"
        subprocess.run(["cc", "-shared", "-fPIC", "-O1", "-o", library, SOURCE, "-ldl"], check=True)
        return library

    return ["env", f"LD_PRELOAD={made_once('failing_calls', compiled)}"]


def run(
    commands: Commands, words: list[str], below: Path, log: Path, number: int = 0, error: int = 0
) -> tuple[int, str]:
    """Run a command of which the call with this number on files below a folder fails, none with 0."""
    log.unlink(missing_ok=True)
    failing = {"number": number, "error": error, "stays": error == errno.ENOSPC, "below": str(below), "log": str(log)}
    return commands.run(*words, failing=failing)


def calls(log: Path) -> list[Call]:
    """Read which calls were made."""
    lines = log.read_text(encoding="utf-8").splitlines()
    return [Call(number, *line.split(" ", 1)) for number, line in enumerate(lines, start=1)]


def chosen(made: list[Call], error: int, alike: int) -> Iterator[Call]:
    """Give the calls that can end with an error, of those that do the same to files of one kind so many."""
    allowed, seen = ERRORS[error], Counter[tuple[str, str]]()
    for call in made:
        same = (call.name, _OF_ONE_FILE.sub("*", call.path))
        seen[same] += 1
        if (allowed is None or call.name in allowed) and seen[same] <= alike:
            yield call
