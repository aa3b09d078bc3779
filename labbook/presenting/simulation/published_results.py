"""The thesis's claims and published results against the simulation: tables for people, Markdown, JSON."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from reports import fields
from reports.display import DASH, decimal_text, general_text, given_text, with_unit
from reports.tables.table import Cell, Column, Columns, Table, table_of, text_column, words
from simulator.steady.published_results import CONTRADICTED, VERDICTS, JudgedResult, PublishedResult
from simulator.thesis.claims import Claim, Finding

_CLAIMS_CAPTION = (
    "What ch. 3 of the thesis says about its simulations, and what the simulation gives over the grids of the "
    "figures: at which share of their points it lies within the claim's limits. The text gives no ranges and few "
    "limits: both are labbook's own, the ranges those of the figures' axes; about a number is within a quarter of it."
)
_CLAIM_COLUMNS: Columns[Finding] = (
    (text_column("Claim", fields.CLAIM), lambda found: words(found.claim.id)),
    (text_column("Where", fields.WHERE), lambda found: words(found.claim.where)),
    (text_column("Statement", fields.STATEMENT, prose=True), lambda found: words(found.claim.statement)),
    (
        text_column("Measured", fields.MEASURE, prose=True),
        lambda found: Cell(found.claim.measure, (found.claim.measure, found.claim.unit)),
    ),
    (
        Column("Thesis", fields.PUBLISHED),
        lambda found: Cell(_number(found.claim.published, found.claim.unit), (found.claim.published,)),
    ),
    (
        Column("Simulated", fields.RANGE),
        lambda found: Cell(range_text(found), (found.lowest, found.median, found.highest)),
    ),
    (
        Column("Holds if", fields.LIMITS),
        lambda found: Cell(_limits_text(found.claim), (found.claim.at_least, found.claim.at_most)),
    ),
    (
        Column("Points within", fields.POINTS_WITHIN),
        lambda found: Cell(f"{found.n_within} of {found.n}", (found.n_within, found.n)),
    ),
    (Column("Holds at", fields.SHARE_WITHIN), lambda found: Cell(_share_text(found), (found.share_within,))),
)


def claims_table(findings: Sequence[Finding], caption: str = _CLAIMS_CAPTION) -> Table:
    """Make the table of all claims; its CSV has the numbers unrounded."""
    return table_of("claims", caption, findings, _CLAIM_COLUMNS, strong=lambda found: not found.agrees)


def _share_text(finding: Finding) -> str:
    """Return the share in percent, rounded so that only all is 100 % and only none 0 %."""
    percent = 100.0 * finding.share_within
    return f"{percent:.0f} %" if finding.n_within in (0, finding.n) else f"{min(max(percent, 1.0), 99.0):.0f} %"


def _number(value: float | None, unit: str) -> str:
    return DASH if value is None else with_unit(general_text(value), unit)


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


def claims_data(findings: Sequence[Finding]) -> list[dict[str, Any]]:
    """Return every field of every claim and finding, for JSON."""
    return [
        {**record, "figures": list(finding.claim.figures), "agrees": finding.agrees}
        for finding, record in zip(findings, claims_table(findings).records, strict=True)
    ]


def short_rows(table: Table) -> list[list[str]]:
    """Return heads and rows without prose and places in the thesis, for a terminal."""
    shown = [place for place, column in enumerate(table.columns) if not column.prose and column.title != "Where"]
    head = [table.columns[place].title.lower() for place in shown]
    return [head, *([row.cells[place].text for place in shown] for row in table.rows)]


_COLUMNS: Columns[JudgedResult] = (
    (text_column("Result", fields.RESULT), lambda item: words(item.result.id)),
    (text_column("Where", fields.WHERE), lambda item: words(item.result.where)),
    (text_column("What", fields.STATEMENT, prose=True), lambda item: words(item.statement)),
    (
        Column("Published", fields.PUBLISHED_NUMBER),
        lambda item: Cell(
            _published_text(item.result), (item.result.published, item.result.unit, item.result.relation)
        ),
    ),
    (Column("Simulated", fields.RANGE_AND_SAVING), lambda item: _simulated(item)),
    (Column("Reproduced if", fields.LIMITS), lambda item: _limits(item.finding)),
    (text_column("Verdict", fields.JUDGED), lambda item: _verdict(item)),
    (text_column("Remark", fields.REMARK, prose=True), lambda item: words(item.remark)),
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
    return table_of("published_results", caption, results, _COLUMNS)


def verdict_counts(results: Sequence[JudgedResult]) -> str:
    """Count the verdicts: "Of 47: 7 reproduced, 8 contradicted, 32 not testable."."""
    counts = Counter(item.verdict for item in results)
    counted = [f"{counts[verdict]} {verdict}" for verdict in VERDICTS]
    return f"Of {len(results)}: {', '.join(counted)}."


def _published_text(result: PublishedResult) -> str:
    if result.published is None:
        return DASH
    number = given_text(result.published)
    if result.unit == "p":
        return f"p {_SIGNS[result.relation]} {number}"
    return f"{result.relation} {with_unit(number, result.unit)}".strip()


def _simulated(item: JudgedResult) -> Cell:
    found = item.finding
    if found is not None:
        return Cell(range_text(found), (found.lowest, found.median, found.highest, item.saving))
    text = DASH if item.saving is None else f"saves {decimal_text(100.0 * item.saving, 1)} %"
    return Cell(text, (None, None, None, item.saving))


def _limits(found: Finding | None) -> Cell:
    if found is None:
        return Cell(DASH, (None, None))
    return Cell(_limits_text(found.claim), (found.claim.at_least, found.claim.at_most))


def _verdict(item: JudgedResult) -> Cell:
    found = item.finding
    if found is None:
        return Cell(item.verdict, (item.verdict, None, None))
    at = f" at {found.n - found.n_within} of {found.n}" if item.verdict == CONTRADICTED and found.n > 1 else ""
    return Cell(item.verdict + at, (item.verdict, found.n_within, found.n))
