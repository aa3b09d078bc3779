"""The thesis's claims and published results against the simulation: tables for people, Markdown, JSON."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from reports.display import DASH, decimal_text, general_text, stated_text, with_unit
from reports.tables.formats.as_markdown import markdown_text
from reports.tables.table import Cell, Column, Row, Table, words
from simulator.steady.published_results import CONTRADICTED, VERDICTS, JudgedResult, PublishedResult, contradictions
from simulator.thesis.claims import Claim, Finding

_CLAIMS_CAPTION = (
    "What ch. 3 of the thesis says about its simulations, and what the simulation gives over the grids of the "
    "figures: at which share of their points it lies within the claim's limits. The text gives no ranges and few "
    "limits: both are labbook's own, the ranges those of the figures' axes; about a number is within a quarter of it."
)
_CLAIM_COLUMNS = (
    Column("Claim", ("claim",), numeric=False),
    Column("Where", ("where",), numeric=False),
    Column("Statement", ("statement",), numeric=False, prose=True),
    Column("Measured", ("measure", "unit"), numeric=False, prose=True),
    Column("Thesis", ("published",)),
    Column("Simulated", ("lowest", "median", "highest")),
    Column("Holds if", ("at_least", "at_most")),
    Column("Points within", ("n_within", "n")),
    Column("Holds at", ("share_within",)),
)


def claims_table(findings: Sequence[Finding], caption: str = _CLAIMS_CAPTION) -> Table:
    """Make the table of all claims; its CSV has the numbers unrounded."""
    return Table("claims", caption, _CLAIM_COLUMNS, tuple(_claim_row(finding) for finding in findings))


def _claim_row(finding: Finding) -> Row:
    claim = finding.claim
    cells = (
        words(claim.id),
        words(claim.where),
        words(claim.statement),
        Cell(claim.measure, (claim.measure, claim.unit)),
        Cell(DASH if claim.published is None else _number(claim.published, claim.unit), (claim.published,)),
        Cell(range_text(finding), (finding.lowest, finding.median, finding.highest)),
        Cell(_limits_text(claim), (claim.at_least, claim.at_most)),
        Cell(f"{finding.n_within} of {finding.n}", (finding.n_within, finding.n)),
        Cell(_share_text(finding), (finding.share_within,)),
    )
    return Row(cells, strong=not finding.agrees)


def _share_text(finding: Finding) -> str:
    """Return the share in percent, rounded so that only all is 100 % and only none 0 %."""
    percent = 100.0 * finding.share_within
    return f"{percent:.0f} %" if finding.n_within in (0, finding.n) else f"{min(max(percent, 1.0), 99.0):.0f} %"


def _number(value: float, unit: str) -> str:
    return with_unit(general_text(value), unit)


def range_text(finding: Finding) -> str:
    """Write what was found: one number, or the ends of the range and the median, with the unit."""
    ends = [general_text(value) for value in (finding.lowest, finding.highest)]
    if ends[0] == ends[1]:
        return with_unit(ends[0], finding.claim.unit)
    median = general_text(finding.median)
    return f"{with_unit(f'{ends[0]} to {ends[1]}', finding.claim.unit)} (median {median})"


def _limits_text(claim: Claim) -> str:
    """Write within which limits a claim holds, with the unit."""
    if claim.at_least is not None and claim.at_most is not None:
        ends = general_text(claim.at_least), general_text(claim.at_most)
        return with_unit(ends[0] if ends[0] == ends[1] else f"{ends[0]} to {ends[1]}", claim.unit)
    if claim.at_least is not None:
        return f"at least {_number(claim.at_least, claim.unit)}"
    return DASH if claim.at_most is None else f"at most {_number(claim.at_most, claim.unit)}"


def claims_markdown(findings: Sequence[Finding]) -> str:
    """Write the table as Markdown, what disagrees in bold."""
    return markdown_text(claims_table(findings))


def claims_rows(findings: Sequence[Finding]) -> list[list[str]]:
    """Return the table's short columns, for a terminal: claim, thesis, simulated, its limits, points within, share."""
    table = claims_table(findings)
    shown = [place for place, column in enumerate(table.columns) if not column.prose and column.title != "Where"]
    head = [table.columns[place].title.lower() for place in shown]
    return [head, *([row.cells[place].text for place in shown] for row in table.rows)]


def claims_data(findings: Sequence[Finding]) -> list[dict[str, Any]]:
    """Return every field of every claim and finding, for JSON."""
    names = [field for column in _CLAIM_COLUMNS for field in column.fields]
    return [
        {
            **dict(zip(names, (value for cell in row.cells for value in cell.values), strict=True)),
            "figures": list(finding.claim.figures),
            "agrees": finding.agrees,
        }
        for finding, row in zip(findings, claims_table(findings).rows, strict=True)
    ]


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
            DASH if claim is None else _limits_text(claim),
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
