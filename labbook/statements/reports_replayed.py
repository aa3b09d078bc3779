"""Which reports of a journal need not be computed once more when it is replayed."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from data_schema.journal import Entry
from data_schema.vocabulary import Action

if TYPE_CHECKING:
    from labbook.presenting.report.content import MadeReport


@dataclass
class ReportsReplayed:
    """Which reports, made once more, would compute nothing: where the journal is replayed.

    `settled` are the selections of those that computed nothing and renewed nothing when they were made, and after which
    nothing was said but reports that did not either. Most reports of a book are made again of what the one before saw.
    """

    settled: set[str | None] = field(default_factory=set)

    def before(self, entry: Entry) -> None:
        """Take note that an entry is about to take effect."""
        if entry.action is not Action.REPORT:
            self.settled.clear()

    def made(self, where: str | None, made: MadeReport) -> None:
        """Take note of a report that was computed."""
        if made.cache.computed or made.detections.computed or any(row.stale for row in made.cache.reused.values()):
            self.settled.clear()
        else:
            self.settled.add(where)
