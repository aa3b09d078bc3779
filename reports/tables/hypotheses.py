"""The hypotheses of a study: what measured and simulated data say of each, and of each comparison that it makes."""

from __future__ import annotations

from dataclasses import replace

from data_schema.reasons import Reason
from data_schema.rounding import level_text as level_in_percent
from data_schema.vocabulary import Undefined
from reports.display import DASH, common_places, given_text, level_text, with_unit
from reports.naming import control_name, levels_name, treatment_name
from reports.results import Hypothesis, HypothesisPart, StudyResults
from reports.tables.table import (
    Cell,
    Columns,
    Table,
    TableKind,
    column,
    ids,
    interval_cell,
    number,
    table_of,
    text,
    value_cell,
)
from stats.days.decision import CONTROL, TREATED

_NOTHING = "runs are missing of what it compares"


def verdict_sentence(results: StudyResults, one: Hypothesis) -> str:
    """Say what came of a hypothesis: "CE costs the same: cannot tell (simulated: holds; published: p > .5)"."""
    beside = [reason] if (reason := _why_undecided(results, one)) else []
    beside += ["among the selected runs"] if one.parts and results.selection else []
    beside += [f"simulated: {one.simulated_verdict}"] if any(map(_simulated, one.parts)) else []
    beside += [f"published: {one.published}"] if one.published else []
    return f"{one.text}: {one.verdict}" + (f" ({'; '.join(beside)})" if beside else "")


def _simulated(part: HypothesisPart) -> bool:
    value = part.simulated.value
    return not isinstance(value, Undefined) or value.code is not Reason.NOT_SIMULATED


def _why_undecided(results: StudyResults, one: Hypothesis) -> str:
    """Say why a hypothesis cannot be tested, "" where it was and its data do not suffice."""
    if not one.parts:
        return _NOTHING
    reasons = [_reason(results, part) for part in one.parts]
    return reasons[0] if all(reasons) else ""


def _reason(results: StudyResults, part: HypothesisPart) -> str:
    if part.no_interval is None:
        return ""
    of, against = _sides(results, part)
    return part.no_interval.called({CONTROL: against, TREATED: of}, "run").text


def _sides(results: StudyResults, part: HypothesisPart) -> tuple[str, str]:
    """Name what is compared, and what it is compared with."""
    if part.savings or not part.against:
        return treatment_name(results, part.of), control_name(results)
    return levels_name(results, {name: part.of[name] for name in part.against}), levels_name(results, part.against)


def _claim(one: Hypothesis) -> Cell:
    return Cell(f"{one.text} ({one.source})" if one.source else one.text, (one.text, one.source))


def _simulated_verdict(one: Hypothesis) -> Cell:
    return Cell(one.simulated_verdict if one.parts else DASH, (str(one.simulated_verdict),))


def _make(results: StudyResults) -> Table:
    columns: Columns[Hypothesis] = (
        column("name", "name", lambda one: Cell("", (one.name,)), shown=False),
        text("hypothesis", "claim source", _claim, prose=True),
        text("measured", "verdict", lambda one: Cell(one.verdict, (str(one.verdict),), _why_undecided(results, one))),
        text("simulated", "simulated_verdict", _simulated_verdict),
        text("published", "published", lambda one: Cell(one.published or DASH, (one.published,)), prose=True),
    )
    return table_of("hypotheses", "Hypotheses of the study", results.hypotheses, columns)


def _in_full(results: StudyResults) -> Table:
    parts = [(one, part) for one in results.hypotheses for part in one.parts]
    places = common_places([part.measured for _, part in parts])
    levels = dict.fromkeys(level_text(part.measured) for _, part in parts if part.no_interval is None)
    several = len(levels) > 1
    columns: Columns[tuple[Hypothesis, HypothesisPart]] = (
        column("name", "name", lambda row: Cell("", (row[0].name,)), shown=False),
        text("compared", "of against", lambda row: _compared(results, row[1])),
        text("true if", "low_percent high_percent", lambda row: Cell(_bounds_text(row[1]), (row[1].low, row[1].high))),
        number("measured", "measured_percent", "%", lambda row: row[1].measured, places),
        column(
            "CI" if len(levels) != 1 else "".join(levels),
            "ci_low_percent ci_high_percent ci_level",
            lambda row: _interval(results, row[1], places, several),
            unit="%",
        ),
        text("verdict", "verdict", lambda row: str(row[1].verdict)),
        number("simulated", "simulated_percent", "%", lambda row: row[1].simulated, places),
        column("std. error", "simulated_se_percent", lambda row: _simulated_error(row[1], places), unit="%"),
        text("verdict", "simulated_verdict", lambda row: str(row[1].simulated_verdict)),
        ids(lambda row: row[1].measured.provenance),
    )
    caption = (
        "Hypotheses, comparison by comparison: change of a mean in percent, or difference of savings in percentage "
        "points. A hypothesis holds where all of its comparisons do, and fails where one does, each at alpha divided "
        "by their number (a wider interval than the one shown). That a group saves is as page one claims it, by Holm."
        f"{' In brackets: the level of the interval.' if several else ''}"
    )
    return table_of("hypotheses_in_full", caption, parts, columns, block=lambda row: row[0].text)


def _compared(results: StudyResults, part: HypothesisPart) -> Cell:
    of, against = levels_name(results, part.of), levels_name(results, part.against)
    return Cell(f"{of} against {against}" if against else of or "all runs", (of, against))


def _interval(results: StudyResults, part: HypothesisPart, places: int, with_level: bool) -> Cell:
    if reason := _reason(results, part):
        return Cell(DASH, (None, None, None), note=reason)
    cell = interval_cell(part.measured, places)
    return replace(cell, text=f"{cell.text} ({level_in_percent(part.measured.ci_level)})") if with_level else cell


def _simulated_error(part: HypothesisPart, places: int) -> Cell:
    return value_cell(None if isinstance(part.simulated.value, Undefined) else part.simulated.se, places)


def _bounds_text(part: HypothesisPart) -> str:
    """Write where the claim is true: "-10 to 10 %", "above -3 %", "below 0 %"."""
    low, high = (None if end is None else given_text(end) for end in (part.low, part.high))
    if low is not None and high is not None:
        return with_unit(f"{low} to {high}", "%")
    return with_unit(f"above {low}" if high is None else f"below {high}", "%")


HYPOTHESES = TableKind("hypotheses", _make)
HYPOTHESES_IN_FULL = TableKind("hypotheses_in_full", _in_full)
