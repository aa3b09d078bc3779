"""Each system call on files fails once in each way: one sentence, nothing that was said is lost, and all can go on.

As SQLite's own tests do, a command is run until the nth of its calls is refused, for every n until it runs through.
"""

from __future__ import annotations

import errno
import re
import shutil
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from data_schema.journal import Entry
from data_schema.journal_file import JournalFile
from labbook.book.opening import opened
from tests.helpers import failing_calls
from tests.helpers.books import small_book
from tests.helpers.commands import Commands, running_commands
from tests.helpers.failing_calls import ERRORS, Call, chosen
from tests.helpers.figures import Count, record
from tests.helpers.statements import said_alike
from tests.helpers.upkeep import health
from tests.helpers.written_by import CASES, Case, check_backup, kinds_of

pytestmark = pytest.mark.skipif(failing_calls.compiler() is None, reason="no C compiler is installed")

COMMANDS = ("init", "ingest", "report", "backup", "rebuild", "merge", "restore", "prune")
ALIKE = 3
"""So many of the calls that do the same to files of one kind are refused."""


@dataclass(frozen=True, slots=True)
class Trial:
    """A command, the folder with its book, a copy of that from before, and what it says where nothing fails."""

    case: Case
    folder: Path
    before: Path
    usual: list[Entry]

    @property
    def words(self) -> list[str]:
        return self.case.words(self.case.commands[-1], self.folder)

    @property
    def book(self) -> Path:
        return self.folder / self.case.book

    def lay(self) -> list[Entry]:
        """Make all as it was; returns what was said by then."""
        shutil.rmtree(self.folder, ignore_errors=True)
        shutil.copytree(self.before, self.folder)
        return self.said()

    def said(self) -> list[Entry]:
        journal = self.book / "journal.jsonl"
        return list(JournalFile(journal).entries()) if journal.exists() else []


@pytest.fixture(scope="module")
def refused() -> Iterator[Commands]:
    """Commands whose calls can fail."""
    with running_commands(failing_calls.between()) as running:
        yield running


def prepared(case: Case, folder: Path, log: Path, commands: Commands) -> tuple[Trial, list[Call]]:
    """Run the command as usual; returns the calls that it makes."""
    before = folder.with_name("before")
    folder.mkdir()
    if case.made:
        small_book(folder, ingested=case.ingested)
    for command in case.before:
        code, said = commands.run(*case.words(command, folder))
        assert code == 0, said
    shutil.copytree(folder, before)
    trial = Trial(case, folder, before, [])
    standing = len(trial.said())
    code, said = failing_calls.run(commands, trial.words, folder, log)
    assert code == 0, said
    return Trial(case, folder, before, trial.said()[standing:]), failing_calls.calls(log)


def check(trial: Trial, call: Call, error: int, log: Path, commands: Commands) -> bool:
    """Let one call fail, look, give the command again, look once more; tells whether the command failed."""
    before, usual = trial.lay(), kinds_of(trial.usual)
    code, said = failing_calls.run(commands, trial.words, trial.folder, log, call.number, error)
    assert "Traceback" not in said, said
    left = trial.said()
    assert left[: len(before)] == before
    added = left[len(before) :]
    partly = "refused (unknown), nothing stored:" in said or "skipped (" in said  # files, each a command of its own
    assert not kinds_of(added) - usual
    if code == 0:
        assert partly or kinds_of(added) == usual, said
    else:
        assert code in (2, 3), f"{code} {said}"
        assert partly or sum(line.startswith("labbook: ") for line in said.splitlines()) == 1, said
        assert partly or not added or "do not say it again" in said, said
    if trial.case.made:
        assert health(trial.book).problems == (), said
    check_backup(trial.folder / f"{trial.case.book} on a stick", None)
    again, said_again = commands.run(*trial.words)
    assert again == 0 or (trial.case.once and again == 2 and code == 0), f"{said}{said_again}"
    assert "Traceback" not in said_again, said_again
    for one in (trial.folder / f"{trial.case.book} again", *([] if trial.case.made else [trial.book])):
        assert not one.exists() or health(one).problems == (), said
    with opened(trial.book) as standing:
        after = said_alike(standing)
    assert after[: len(left)] == left
    assert not usual - kinds_of(after[len(before) :])
    return code != 0


def faults(trial: Trial, calls: Iterable[Call], error: int, log: Path, commands: Commands) -> tuple[Count, list[str]]:
    """Let each of these calls fail; returns how many there were, and what was wrong."""
    count, found = Count("", f"call refused: {errno.errorcode[error]}", "SQLite"), []
    for call in calls:
        count.tried += 1
        try:
            count.cut_off += check(trial, call, error, log, commands)
        except AssertionError as fault:
            count.lost += 1
            found.append(f"{errno.errorcode[error]} of {call}: {fault}")
    return count, found


@pytest.mark.parametrize(
    ("name", "error", "refused_call"),
    [
        ("correct", errno.ENOSPC, "fsync .*/journal.jsonl"),
        ("init", errno.EIO, "read .*/.labbook.db.*-wal"),
        ("init", errno.EIO, "read .*/.labbook.db.[0-9a-f]*"),
        ("ingest", errno.EACCES, "opendir .*/charger"),
    ],
)
def test_a_call_that_fails_is_told_and_nothing_is_lost(
    name: str, error: int, refused_call: str, tmp_path: Path, refused: Commands
) -> None:
    trial, made = prepared(CASES[name], tmp_path / "trial", tmp_path / "log", refused)
    calls = [call for call in made if re.fullmatch(refused_call, f"{call.name} {call.path}")]
    count, found = faults(trial, {calls[0], calls[-1]}, error, tmp_path / "log", refused)
    assert count.tried
    assert not found, "\n".join(found)


@pytest.mark.soak
@pytest.mark.parametrize("error", ERRORS, ids=errno.errorcode.get)
@pytest.mark.parametrize("name", COMMANDS)
def test_every_call_is_refused_in_turn(name: str, error: int, tmp_path: Path, refused: Commands) -> None:
    trial, made = prepared(CASES[name], tmp_path / "trial", tmp_path / "log", refused)
    count, found = faults(trial, chosen(made, error, ALIKE), error, tmp_path / "log", refused)
    record(replace(count, command=name))
    assert not found, "\n".join(found)
