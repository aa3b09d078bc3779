"""The thesis's claims against the simulation, as a table for people and as data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from reports.display import DASH, general_text, with_unit
from reports.tables.formats.as_markdown import markdown_text
from reports.tables.table import Cell, Column, Row, Table, words
from simulator.thesis.claims import Claim, Finding

CAPTION = (
    "What ch. 3 of the thesis says about its simulations, and what the simulation gives over the grids of the "
    "figures: at which share of their points it lies within the claim's limits. The text gives no ranges and few "
    "limits: both are labbook's own, the ranges those of the figures' axes; about a number is within a quarter of it."
)
_COLUMNS = (
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


def claims_table(findings: Sequence[Finding], caption: str = CAPTION) -> Table:
    """Make the table of all claims; its CSV has the numbers unrounded."""
    return Table("claims", caption, _COLUMNS, tuple(_row(finding) for finding in findings))


def _row(finding: Finding) -> Row:
    claim = finding.claim
    cells = (
        words(claim.id),
        words(claim.where),
        words(claim.statement),
        Cell(claim.measure, (claim.measure, claim.unit)),
        Cell(DASH if claim.published is None else _number(claim.published, claim.unit), (claim.published,)),
        Cell(range_text(finding), (finding.lowest, finding.median, finding.highest)),
        Cell(limits_text(claim), (claim.at_least, claim.at_most)),
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


def limits_text(claim: Claim) -> str:
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
    names = [field for column in _COLUMNS for field in column.fields]
    return [
        {
            **dict(zip(names, (value for cell in row.cells for value in cell.values), strict=True)),
            "figures": list(finding.claim.figures),
            "agrees": finding.agrees,
        }
        for finding, row in zip(findings, claims_table(findings).rows, strict=True)
    ]
