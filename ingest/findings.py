"""Collects the findings of all checks of one file, in one pass: one finding per rule and column."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field

from data_schema.vocabulary import Severity
from ingest.model import Finding, IntArray, TableUse

NOTE, ROW, FILE = Severity.NOTE, Severity.ROW, Severity.FILE

MORE_LINES = 20
"""Most lines listed beside the first one."""

_LONGEST_VALUE = 60
_GRAVEST_FIRST = {FILE: 0, ROW: 1, NOTE: 2}


@dataclass(slots=True)
class _Entry:
    message: str
    value: str | None
    count: int = 0
    lines: list[int] = field(default_factory=list)


class FindingCollector:
    """Accumulates findings; the message and value of the first report of a rule and column stand.

    `tables` takes what each table of the file became; of the files packed in it `encodings` takes the pages of text,
    and `named_runs` what the one file there calls its run.
    """

    __slots__ = ("_entries", "encodings", "named_runs", "tables")

    def __init__(self) -> None:
        self.tables: list[TableUse] = []
        self.encodings: list[str] = []
        self.named_runs: tuple[str, ...] = ()
        self._entries: dict[tuple[Severity, str, str | None], _Entry] = {}

    def add(
        self,
        severity: Severity,
        rule: str,
        message: str,
        *,
        column: str | None = None,
        lines: Sequence[int] | IntArray = (),
        count: int | None = None,
        value: str | None = None,
    ) -> None:
        """Report `rule` once, in each of `lines` (1-based, ascending), or `count` times where these are only some."""
        key = (severity, rule, column)
        entry = self._entries.get(key)
        if entry is None:
            shown = None if value is None else value[:_LONGEST_VALUE]
            entry = self._entries[key] = _Entry(message, shown)
        entry.count += count if count is not None else max(1, len(lines))
        room = MORE_LINES + 1 - len(entry.lines)
        if room > 0:
            entry.lines.extend(int(line) for line in lines[:room])

    def take_over(self, other: FindingCollector) -> None:
        """Add all that another collector holds."""
        self.tables += other.tables
        for (severity, rule, column), entry in other._entries.items():
            self.add(
                severity, rule, entry.message, column=column, lines=entry.lines, count=entry.count, value=entry.value
            )

    def count(self, rule: str) -> int:
        """Return how often a rule was reported."""
        return sum(entry.count for (_, known, _), entry in self._entries.items() if known == rule)

    def refuse_for(self, rule: str, message: str) -> None:
        """Let all that was reported under a rule refuse the file, with another message."""
        for key in [key for key in self._entries if key[1] == rule]:
            entry = self._entries.pop(key)
            self._entries[FILE, rule, key[2]] = dataclasses.replace(entry, message=message)

    def __contains__(self, rule: str) -> bool:
        return any(known == rule for _, known, _ in self._entries)

    @property
    def refuse(self) -> bool:
        """Whether something refuses the file."""
        return any(severity is FILE for severity, _, _ in self._entries)

    def findings(self) -> tuple[Finding, ...]:
        """Return all findings, gravest first, otherwise in the order of their first report."""
        found = [
            Finding(
                severity,
                rule,
                entry.message,
                entry.lines[0] if entry.lines else None,
                column,
                entry.value,
                entry.count,
                tuple(entry.lines[1:]),
            )
            for (severity, rule, column), entry in self._entries.items()
        ]
        return tuple(sorted(found, key=lambda finding: _GRAVEST_FIRST[finding.severity]))
