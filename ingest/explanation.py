"""How a file was understood: what each format saw in it, how its text is laid out, what every column became and why."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Candidate:
    """A format that the file may be of, with its score and evidence."""

    format: str
    score: int
    evidence: str


@dataclass(frozen=True, slots=True)
class TextShape:
    """The layout of a table in text: lines are numbered from 1, None where there is no such line."""

    delimiter: str
    decimal: str
    header_line: int | None
    units_line: int | None
    first_line: int


@dataclass(frozen=True, slots=True)
class ColumnUse:
    """What one column became.

    `place` counts from 1. `holds` is a channel, a role in a charger sheet, or `time`, `date` or `trial`; None where the
    column is left out, for which `left_out` says why. `unit` is the file's, `stored_unit` labbook's, `unit_from` where
    the former was found.
    """

    place: int
    name: str
    holds: str | None
    unit: str | None = None
    stored_unit: str | None = None
    unit_from: str | None = None
    sign: int = 1
    assumed: tuple[str, ...] = ()
    left_out: str | None = None


@dataclass(frozen=True, slots=True)
class TableUse:
    """What one table of a file became; `text` is None where it is not text, `rate_from` where there is no time axis."""

    text: TextShape | None
    columns: tuple[ColumnUse, ...]
    rate_from: str | None = None


@dataclass(frozen=True, slots=True)
class Explanation:
    """How a file was understood. `candidates` has the most likely format first; `encoding` is None for binary
    files, and of an archive those of its members."""

    encoding: str | None = None
    candidates: tuple[Candidate, ...] = ()
    tables: tuple[TableUse, ...] = ()
