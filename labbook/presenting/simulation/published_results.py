"""Every published result with its verdict, and where the thesis contradicts itself: a table, Markdown, JSON."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from labbook.presenting.simulation.thesis_claims import limits_text, range_text
from reports.display import DASH, decimal_text, stated_text, with_unit
from reports.tables.table import Cell, Column, Row, Table, words
from simulator.steady.published_results import CONTRADICTED, VERDICTS, JudgedResult, PublishedResult, contradictions

_COLUMNS = (
    Column("Result", ("result",), numeric=False),
    Column("Where", ("where",), numeric=False),
    Column("What", ("statement",), numeric=False, prose=True),
    Column("Published", ("published", "unit", "relation")),
    Column("Simulated", ("lowest", "median", "highest", "saving")),
    Column("Reproduced if", ("at_least", "at_most")),
    Column("Verdict", ("verdict", "n_within", "n"), numeric=False),
    Column("Remark", ("remark",), numeric=False, prose=True),
)
_CAPTION = (
    "A result is reproduced where all that is simulated for it lies within the limits, and contradicted where any "
    "point does not; its verdict says how many. Limits and ranges are those of the claims above and of labbook sim "
    "figures, for the text gives few. Parameters are those of the shipped scenes: none was chosen for a verdict, but "
    "some of the emulator's for its apexes, and the bed's stiffness for the height that the small foot cleared. Beside "
    "a p value stands the saving that is simulated in its conditions."
)
_SIGNS = {"": "=", "less than": "<", "greater than": ">"}


def results_table(results: Sequence[JudgedResult]) -> Table:
    """Make the table of all published results; its CSV has the numbers unrounded."""
    caption = f"{_CAPTION} {verdict_counts(results)}"
    return Table("published_results", caption, _COLUMNS, tuple(_row(item) for item in results))


def verdict_counts(results: Sequence[JudgedResult]) -> str:
    """Count the verdicts: "Of 47: 7 reproduced, 8 contradicted, 32 not testable."."""
    counts = Counter(item.verdict for item in results)
    said = [f"{counts[verdict]} {verdict}" for verdict in VERDICTS]
    return f"Of {len(results)}: {', '.join(said)}."


def results_rows(results: Sequence[JudgedResult]) -> list[list[str]]:
    """Return the table's short columns, for a terminal."""
    table = results_table(results)
    shown = [place for place, column in enumerate(table.columns) if not column.prose and column.title != "Where"]
    head = [table.columns[place].title.lower() for place in shown]
    return [head, *([row.cells[place].text for place in shown] for row in table.rows)]


def results_data(results: Sequence[JudgedResult]) -> list[dict[str, Any]]:
    """Return every field of every result, for JSON."""
    names = [field for column in _COLUMNS for field in column.fields]
    return [
        dict(zip(names, (value for cell in row.cells for value in cell.values), strict=True))
        for row in results_table(results).rows
    ]


def contradiction_items() -> list[str]:
    """Return a line for each contradiction of the thesis with itself: where, and what."""
    return [f"**{item.where}**: {item.text}" for item in contradictions()]


def contradictions_data() -> list[dict[str, str]]:
    """Return the contradictions for JSON."""
    return [asdict(item) for item in contradictions()]


def _row(item: JudgedResult) -> Row:
    result, found = item.result, item.finding
    claim = None if found is None else found.claim
    cells = (
        words(result.id),
        words(result.where),
        words(item.statement),
        Cell(_published_text(result), (result.published, result.unit, result.relation)),
        Cell(
            _simulated_text(item),
            (*((None,) * 3 if found is None else (found.lowest, found.median, found.highest)), item.saving),
        ),
        Cell(
            DASH if claim is None else limits_text(claim),
            (None, None) if claim is None else (claim.at_least, claim.at_most),
        ),
        Cell(_verdict_text(item), (item.verdict, *((None, None) if found is None else (found.n_within, found.n)))),
        words(item.remark),
    )
    return Row(cells)


def _published_text(result: PublishedResult) -> str:
    if result.published is None:
        return DASH
    number = stated_text(result.published)
    if result.unit == "p":
        return f"p {_SIGNS[result.relation]} {number}"
    return f"{result.relation} {with_unit(number, result.unit)}".strip()


def _simulated_text(item: JudgedResult) -> str:
    if item.finding is not None:
        return range_text(item.finding)
    return DASH if item.saving is None else f"saves {decimal_text(100.0 * item.saving, 1)} %"


def _verdict_text(item: JudgedResult) -> str:
    found = item.finding
    if found is None or item.verdict != CONTRADICTED or found.n == 1:
        return item.verdict
    return f"{item.verdict} at {found.n - found.n_within} of {found.n}"
