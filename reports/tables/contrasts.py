"""Contrasts of condition means: what the levels of a factor differ by, and what the saving depends on."""

from __future__ import annotations

from dataclasses import replace

from data_schema.vocabulary import ContrastKind, Undefined
from reports.content import Claim, MeansContrast, ReportContent
from reports.display import (
    as_shown,
    common_places,
    count_text,
    given_text,
    in_sentence,
    interval_text,
    level_text,
    places_of,
    sentence_start,
    significance_text,
    value_text,
    with_unit,
)
from reports.naming import level_names, swept_factor, title_of
from reports.tables.comparisons import reasons_note
from reports.tables.table import (
    PLAIN_INTERVAL,
    Cell,
    Columns,
    Table,
    TableKind,
    column,
    counts,
    ids,
    interval_cell,
    number_cell,
    p_cell,
    statistic,
    table_of,
    text,
)


def contrast_name(content: ReportContent, one: MeansContrast) -> str:
    """Name a contrast: "saving with the small foot less that with the large foot"."""
    effect = "saving" if one.quantity.has_savings else f"difference of {one.quantity}"
    if one.kind is ContrastKind.DIFFERENCE:
        return f"{one.quantity} with {_less(content, one)}, {one.side} runs"
    if one.kind is ContrastKind.INTERACTION:
        return f"{effect} with {_less(content, one, ' less that with ')}"
    step = f"for each {given_text(one.per)} of the {_swept(content)}"
    if one.at is not None:
        return f"{effect} {step}: up to {given_text(one.at)} less from there on"
    return f"{effect} {step}" + (f" from {one.levels[0]} to {one.levels[-1]}" if len(one.levels) > 1 else "")


def _less(content: ReportContent, one: MeansContrast, less: str = " less ") -> str:
    """Write the second level less the first; without two of them what they are levels of."""
    names = [level_names(content, {one.factor: label})[0] for label in reversed(one.levels)]
    title = next((title_of(factor) for factor in content.factors if factor.name == one.factor), one.factor)
    return less.join(names) if names else f"one level{less}another of the {in_sentence(title)}"


def _swept(content: ReportContent) -> str:
    swept = swept_factor(content)
    return "treatment's level" if swept is None else in_sentence(title_of(swept))


def _unit(one: MeansContrast) -> str:
    unit = as_shown(one.estimate).unit
    return "points" if unit == "%" else unit


def _make(content: ReportContent) -> Table:
    found = content.contrasts
    places = {
        unit: common_places([each.estimate for each in found if _unit(each) == unit]) for unit in map(_unit, found)
    }
    adjusted = next((one.adjusted for one in found if one.adjusted is not None), None)
    by_days = any(one.days for one in found)
    level = next((level_text(one.estimate) for one in found), "CI")
    columns: Columns[MeansContrast] = (
        text("contrast", "kind outcome factor levels side per at", lambda one: _name_cell(content, one)),
        counts("days", "days", lambda one: len(one.days), shown=by_days),
        counts("n", "n", lambda one: one.estimate.n),
        column("estimate", "estimate unit", lambda one: _estimate(one, places[_unit(one)])),
        column(level, PLAIN_INTERVAL, lambda one: interval_cell(one.estimate, places[_unit(one)])),
        statistic("t", "t", lambda one: one.test),
        column(
            "Holm",
            "holm_p",
            lambda one: p_cell(None if one.adjusted is None else one.adjusted.value),
            shown=adjusted is not None,
        ),
        ids(lambda one: one.estimate.provenance),
        text("exploratory", "exploratory", lambda one: one.exploratory, shown=False),
    )
    holm = "" if adjusted is None else f" Holm: p adjusted over the {adjusted.n} contrasts."
    how = "over all runs"
    if by_days:
        how = (
            "on the days that hold what each of their effects compares: of the days' own contrasts from four days on, "
            "within days where there are fewer"
        )
    exploratory = reasons_note(one.exploratory for one in found)
    legend = "n: runs that enter. Points are percentage points of savings."
    caption = f"Contrasts of condition means {how}. {legend}{holm}{exploratory}"
    return table_of("contrasts", caption, found, columns)


def _name_cell(content: ReportContent, one: MeansContrast) -> Cell:
    values = (str(one.kind), one.quantity.key, one.factor, " ".join(one.levels), one.side, one.per, one.at)
    return Cell(contrast_name(content, one), values)


def _estimate(one: MeansContrast, places: int) -> Cell:
    cell = number_cell(one.estimate, places)
    text = cell.text if isinstance(one.estimate.value, Undefined) else with_unit(cell.text, _unit(one))
    return Cell(text, (*cell.values, one.estimate.unit), cell.note)


def contrast_claims(content: ReportContent) -> tuple[Claim, ...]:
    """Say what the planned contrasts show, a sentence each."""
    planned = [one for one in content.contrasts if not one.exploratory]
    return tuple(Claim(_sentence(content, one), tuple(filter(None, (one.estimate.provenance,)))) for one in planned)


def _sentence(content: ReportContent, one: MeansContrast) -> str:
    """Say what a contrast is by its name: "Saving with small foot less that with large foot: 3.1 points (...)."."""
    number, name = as_shown(one.estimate), sentence_start(contrast_name(content, one))
    for undefined in (number.value, one.test.p):
        if isinstance(undefined, Undefined):
            return f"{name} cannot be told: {undefined.reason}."
    size = with_unit(value_text(number.value, places_of(one.estimate)), _unit(one))
    test, holm = one.test, ""
    if one.adjusted is not None:  # the p that decides
        test, holm = replace(test, p=one.adjusted.value), " by Holm"
    evidence = [
        f"{level_text(number)} {interval_text(one.estimate, unit=False)}",
        f"{significance_text(test, name=False)}{holm}",
        "on the days measured" if one.unit == "run" and one.days else "",
        f"{count_text(one.left_out, 'condition')} of one side alone left out" if one.left_out else "",
    ]
    shown = "" if one.rejected else ", not significant"
    return f"{name}: {size}{shown} ({'; '.join(filter(None, evidence))})."


CONTRASTS = TableKind("contrasts", _make)
