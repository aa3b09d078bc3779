"""The hypotheses of a study: what measured and simulated data say of each, and of each comparison that it makes."""

from __future__ import annotations

from data_schema.vocabulary import Undefined
from reports.content import ReportContent
from reports.display import DASH, common_places, stated_text, with_unit
from reports.naming import control_name, levels_name, treatment_name
from reports.predicted import Hypothesis, HypothesisPart
from reports.tables.table import (
    PROVENANCE,
    Cell,
    Column,
    Row,
    Table,
    TableKind,
    interval_cell,
    interval_title,
    number_cell,
    provenance_cell,
    value_cell,
    words,
)

_NOTHING = "runs are missing of what it compares"


def verdict_sentence(content: ReportContent, one: Hypothesis) -> str:
    """Say what came of a hypothesis: "CE costs the same: cannot tell (simulated: holds; published: p > .5)"."""
    beside = [reason] if (reason := _why_undecided(content, one)) else []
    beside += ["among the selected runs"] if one.parts and content.selection else []
    beside += [f"simulated: {one.simulated_verdict}"] if one.parts else []
    beside += [f"published: {one.published}"] if one.published else []
    return f"{one.text}: {one.verdict}" + (f" ({'; '.join(beside)})" if beside else "")


def _why_undecided(content: ReportContent, one: Hypothesis) -> str:
    """Say why nothing can be told of a hypothesis, "" where its data only do not suffice."""
    if not one.parts:
        return _NOTHING
    reasons = [_reason(content, part) for part in one.parts]
    return reasons[0] if all(reasons) else ""


def _reason(content: ReportContent, part: HypothesisPart) -> str:
    if part.untold is None:
        return ""
    of, against = _sides(content, part)
    return part.untold.called({"group control": against, "group treated": of}, "run").text


def _sides(content: ReportContent, part: HypothesisPart) -> tuple[str, str]:
    """Name what is compared, and what it is compared with."""
    if part.savings or not part.against:
        return treatment_name(content, part.of), control_name(content)
    return levels_name(content, {name: part.of[name] for name in part.against}), levels_name(content, part.against)


def _make(content: ReportContent) -> Table:
    columns = (
        Column("name", ("name",), shown=False),
        Column("hypothesis", ("claim", "source"), numeric=False, prose=True),
        Column("measured", ("verdict",), numeric=False),
        Column("simulated", ("simulated_verdict",), numeric=False),
        Column("published", ("published",), numeric=False, prose=True),
    )
    rows = tuple(
        Row(
            (
                Cell("", (one.name,)),
                Cell(f"{one.text} ({one.source})" if one.source else one.text, (one.text, one.source)),
                Cell(str(one.verdict), (str(one.verdict),), note=_why_undecided(content, one)),
                Cell(str(one.simulated_verdict) if one.parts else DASH, (str(one.simulated_verdict),)),
                Cell(one.published or DASH, (one.published,)),
            )
        )
        for one in content.hypotheses
    )
    return Table("hypotheses", "Hypotheses of the study, by one-sided tests", columns, rows)


def _in_full(content: ReportContent) -> Table:
    parts = [part for one in content.hypotheses for part in one.parts]
    places = common_places([part.measured for part in parts])
    level = interval_title(part.measured for part in parts if part.untold is None)
    columns = (
        Column("name", ("name",), shown=False),
        Column("compared", ("of", "against"), numeric=False),
        Column("true if", ("low_percent", "high_percent"), numeric=False),
        Column("measured", ("measured_percent",), "%"),
        Column(level, ("ci_low_percent", "ci_high_percent", "ci_level"), "%"),
        Column("verdict", ("verdict",), numeric=False),
        Column("simulated", ("simulated_percent",), "%"),
        Column("std. error", ("simulated_se_percent",), "%"),
        Column("verdict", ("simulated_verdict",), numeric=False),
        PROVENANCE,
    )
    rows = [_row(content, one, part, places) for one in content.hypotheses for part in one.parts]
    caption = (
        "Hypotheses, comparison by comparison: change of a mean in percent, or difference of savings in percentage "
        "points. A hypothesis holds where all of its comparisons do, and fails where one does, each at alpha divided "
        "by their number (a wider interval than the one shown)."
    )
    return Table("hypotheses_in_full", caption, columns, tuple(rows))


def _row(content: ReportContent, one: Hypothesis, part: HypothesisPart, places: int) -> Row:
    of, against = levels_name(content, part.of), levels_name(content, part.against)
    interval = interval_cell(part.measured, places)
    if reason := _reason(content, part):
        interval = Cell(DASH, (None, None, None), note=reason)
    return Row(
        (
            Cell("", (one.name,)),
            Cell(f"{of} against {against}" if against else of or "all runs", (of, against)),
            Cell(_bounds_text(part), (part.low, part.high)),
            number_cell(part.measured, places),
            interval,
            words(str(part.verdict)),
            number_cell(part.simulated, places),
            value_cell(None if isinstance(part.simulated.value, Undefined) else part.simulated.se, places),
            words(str(part.simulated_verdict)),
            provenance_cell(part.measured.provenance),
        ),
        block=one.text,
    )


def _bounds_text(part: HypothesisPart) -> str:
    """Write where the claim is true: "-10 to 10 %", "above -3 %", "below 0 %"."""
    low, high = (None if end is None else stated_text(end) for end in (part.low, part.high))
    if low is not None and high is not None:
        return with_unit(f"{low} to {high}", "%")
    return with_unit(f"above {low}" if high is None else f"below {high}", "%")


HYPOTHESES = TableKind("hypotheses", _make)
HYPOTHESES_IN_FULL = TableKind("hypotheses_in_full", _in_full)
