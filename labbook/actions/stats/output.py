"""What every command of `labbook stats` answers: sentences first, then tables of fields; the same whole as data."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from data_schema.errors import UsageError
from data_schema.rounding import alpha_beside
from labbook.actions.stats.pictures import Pictures
from labbook.analysis.observations import Observations
from labbook.presenting.stats.fields import field_lines_of_each, reasons_of, table_of
from labbook.presenting.stats.names import as_shown_to_people
from stats.checks import as_level

ALPHA = 0.05


Rows = list[list[str]]
"""A table as texts, its heads first."""


@dataclass
class CommandOutput:
    """Lines and tables for people and data for programs, filled as results come."""

    data: dict[str, Any] = field(default_factory=dict)
    lines: list[str | Rows] = field(default_factory=list)

    def say(self, title: str, lines: Iterable[str]) -> None:
        """Add a paragraph under a title."""
        self.lines += ["", f"{title}:", *lines]

    def say_each(self, titled: Iterable[tuple[str, Any]]) -> None:
        """Add a paragraph of fields for each result under its title; what a field means is said once."""
        titles, results = zip(*titled, strict=True)
        for title, lines in zip(titles, field_lines_of_each(results), strict=True):
            self.say(title, lines)

    def show(self, title: str, results: Sequence[Any], left_out: Sequence[str] = ()) -> None:
        """Add results of one class as a table under a title, and why fields of theirs are undefined."""
        if results:
            self.lines += ["", f"{title}:", table_of(results, left_out), *reasons_of(results, left_out)]

    def about(self, observed: Observations, pictures: Pictures, notes: Sequence[str] = ()) -> CommandOutput:
        """Add where the values come from, what is to be known about them and the comparison, and what was written.

        Notes stand right below the sentences, for tables can be long.
        """
        known, notes = observed.known(), [*observed.notes, *notes]
        self.data = {
            "source": observed.source,
            "quantity": observed.quantity,
            "unit": observed.unit,
            "by": observed.by,
            "control": observed.name(observed.control),
            "groups": {observed.name(label): len(known.values(label)) for label in observed.labels},
            "notes": notes,
            **self.data,
            "files": {name: str(path) for name, path in pictures.files.items()},
        }
        if notes:
            below = self.lines.index("") if "" in self.lines else len(self.lines)
            self.lines[below:below] = ["", *(f"note: {note}" for note in notes)]
        self.lines += [str(path) for path in pictures.files.values()]
        return self


def output_of(
    observed: Observations, pictures: Pictures, answer: Callable[[Observations, Pictures], CommandOutput]
) -> CommandOutput:
    """Return an answer whose data have the values' unit and the groups' own names, as programs ask for them.

    Its lines have lengths below 1 m in mm, and groups of a book named as in its report.
    """
    told, read = answer(observed, pictures), as_shown_to_people(observed.in_millimetres())
    if read is not observed:
        told.lines = [*answer(read, Pictures()).lines, *map(str, pictures.files.values())]
    return told


def alpha_of(alpha: float | None, level: float | None, observed: Observations | None = None) -> float:
    """Return the level of tests: given as alpha, as the level of intervals, by the book, or 0.05.

    Raises `UsageError` where both are given and differ.
    """
    if level is not None:
        of_level = alpha_beside(as_level("--level", level))
        if alpha is not None and alpha != of_level:
            raise UsageError(
                f"--alpha {alpha:g} and --level {level:g} differ: an interval has level 1 - alpha, give one."
            )
        return of_level
    if alpha is not None:
        if not 0.0 < alpha < 1.0:
            raise UsageError(f"--alpha is {alpha!r}: give a number between 0 and 1, for example 0.05 for 5 %.")
        return alpha
    settings = observed.settings if observed else None
    return ALPHA if settings is None else settings.alpha
