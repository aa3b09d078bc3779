"""Commands that write to a book, as they are given to a small one, and what each leaves."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from data_schema.journal import Entry
from data_schema.journal_file import JournalFile
from data_schema.vocabulary import Action
from ingest.store import Store, raw_path
from labbook.book.copies.copying import raw_of
from tests.helpers.books import ADA

INGEST = ("ingest", "{instruments}/logs/r001.csv", "{instruments}/charger")
CORRECT = ("correct", "r002", "foot=large", "--why", "seen on the video")
BACKUP = ("backup", "{book} on a stick")
RESTORE = ("restore", "{book} on a stick", "{book} again")
PLAN = ("plan", "--seed", "7", "--n", "1", "--per-day", "8", "--start", "2022-01-01", "--out", "{book}/plan.csv")
REREAD = ("ingest", "{instruments}/logs/r001.csv", "--column", "battery_voltage=own.voltage:V")


@dataclass(frozen=True, slots=True)
class Case:
    """Commands given to a book one after the other, the last of which ends well.

    `book`: where it lies; `dies_after`: the first command is killed after so many syncs to the disk;
    `slow`: to give it again takes seconds; `chances`: in so many ways at random the soak cuts it besides. `before`:
    commands given before those, while the power stays; `once`: where it was done it is refused when given again;
    `in_place`: what is left is laid where the disk was, for a path to it stands in a file.
    """

    commands: tuple[tuple[str, ...], ...]
    before: tuple[tuple[str, ...], ...] = ()
    once: bool = False
    in_place: bool = False
    ingested: bool = True
    book: str = "book"
    dies_after: int = 0
    slow: bool = False
    chances: int = 3

    @property
    def made(self) -> bool:
        """Whether there is a book before the first command."""
        return self.commands[0][0] != "init"

    def words(self, command: tuple[str, ...], folder: Path) -> list[str]:
        """A command with the paths of the folder that the book is in."""
        book = str(folder / self.book)
        words = [word.format(book=book, instruments=folder / "instruments") for word in command]
        return [*words, "--book", book] if self.made and command != RESTORE and "--book" not in words else words


CASES = {
    "init": Case((("init", "{book}", "--as", ADA),), book="shelf/new/book", chances=0),
    "ingest": Case((INGEST,), ingested=False),
    "ingest, killed before": Case((INGEST, INGEST), ingested=False, dies_after=3),
    "correct": Case((CORRECT,)),
    "correct, killed before": Case((CORRECT, ("runs", "list"), CORRECT), dies_after=1),
    "report": Case((("report", "--out", "{book}/reports/one"),), slow=True, chances=1),
    "rebuild": Case((("rebuild",),), chances=0),
    "rebuild --journal": Case((("rebuild", "--journal"),)),
    "backup": Case((BACKUP,)),
    "backup, killed before": Case((BACKUP, BACKUP), dies_after=4),
    "plan": Case((PLAN,), once=True, slow=True),
    "reread": Case((REREAD,), slow=True),
    "prune": Case((("db", "prune", "--yes"),), before=(("rebuild",),)),
    "restore": Case((RESTORE,), before=(BACKUP,), once=True, in_place=True, slow=True, chances=0),
    "merge": Case(
        (("merge", "{book} again"),),
        before=(BACKUP, RESTORE, ("note", "r001", "seen on the video", "--book", "{book} again")),
        slow=True,
    ),
}
"""What is recorded; another command that writes to a book is a line here."""


def check_backup(stick: Path, journal: Sequence[str] | None) -> None:
    """A backup that has a journal has every raw copy it speaks of; one that was done has the book's `journal`."""
    if not (stick / "journal.jsonl").exists():
        assert journal is None or not stick.exists()
        return
    entries = list(JournalFile(stick / "journal.jsonl").entries())
    for sha256 in raw_of(entries):
        assert Store(stick).raw(raw_path(sha256), sha256)
    assert journal is None or [entry.hash for entry in entries] == journal


def kinds_of(entries: Sequence[Entry]) -> Counter[tuple[str, str, bool]]:
    return Counter(
        (entry.action, entry.entity_kind, entry.old is not None)
        for entry in entries
        if entry.action is not Action.REPORT
    )
