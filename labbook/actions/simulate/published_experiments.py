"""What `labbook sim published` does: the published experiments simulated, compared, and written as a document."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from data_schema.errors import UsageError
from labbook.presenting.simulation.published_experiments import document
from simulator.steady.published_numbers import Comparison, comparisons
from simulator.steady.tables import SteadyTables, steady_tables

DOCUMENT_KIND = ".md"


@dataclass(frozen=True, slots=True)
class ComparedExperiments:
    """The simulated tables, and what is published against them."""

    tables: SteadyTables
    comparisons: tuple[Comparison, ...]


def compare_published(accuracy: float, out: Path | None, step: Callable[[str], None]) -> ComparedExperiments:
    """Simulate and compare; with `out`, a .md file, also write the document. `step` is told of each gain."""
    if out is not None and out.suffix != DOCUMENT_KIND:
        raise UsageError(f"--out {out} is no name for a document in Markdown: end it in {DOCUMENT_KIND}.")
    tables = steady_tables(accuracy, step)
    compared = comparisons(tables)
    if out is not None:
        out.parent.mkdir(parents=True, exist_ok=True)
        out.write_text(document(tables, compared), encoding="utf-8")
    return ComparedExperiments(tables, compared)
