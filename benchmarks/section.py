"""What a benchmark found: budgets with their numbers, tables, and the sentence under each."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.timing import Times


@dataclass(frozen=True, slots=True)
class Budget:
    """A limit and what was measured; None where this machine could not measure it, `why` then says why."""

    what: str
    limit: float
    unit: str
    measured: float | None
    at_least: bool = False
    why: str = ""

    @property
    def verdict(self) -> str:
        """Return met, missed or not measured."""
        if self.measured is None:
            return "not measured"
        met = self.measured >= self.limit if self.at_least else self.measured <= self.limit
        return "met" if met else "missed"

    @property
    def limit_text(self) -> str:
        """Return the limit with its direction and unit."""
        return f"at {'least' if self.at_least else 'most'} {self.limit:g}{_unit(self.unit)}"

    @property
    def measured_text(self) -> str:
        """Return what was measured, or why it was not."""
        return self.why if self.measured is None else f"{_short(self.measured)}{_unit(self.unit)}"


@dataclass(frozen=True, slots=True)
class Table:
    """Rows of text under their heads, and what they show."""

    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    shows: str


@dataclass(frozen=True, slots=True)
class Section:
    """One benchmark's part of the document."""

    title: str
    measured: str
    budgets: tuple[Budget, ...]
    tables: tuple[Table, ...]


@dataclass(frozen=True, slots=True)
class Benchmark:
    """One benchmark by name; `measure` is told where to say what it is doing. A `long` one takes hours: it is named."""

    name: str
    measure: Callable[[Callable[[str], None]], Section]
    long: bool = False


def times_table(times: dict[str, Times], peer: str, shows: str) -> Table:
    """Return wall and processor times of each work in ms, and the ratio of its minimum to the peer's."""
    base = times[peer].minimum
    rows = tuple(
        (name, *map(milliseconds, (one.minimum, one.median, one.cpu_minimum)), _short(one.minimum / base))
        for name, one in times.items()
    )
    return Table(("", "min, ms", "median, ms", "processor, ms", f"min over that of “{peer}”"), rows, shows)


def milliseconds(seconds: float) -> str:
    """Return a time as text, in ms."""
    return _short(seconds * 1e3)


def _short(value: float) -> str:
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.0f}"


def _unit(unit: str) -> str:
    return {"": "", "×": " ×"}.get(unit, f" {unit}")
