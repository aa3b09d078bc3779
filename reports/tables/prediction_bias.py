"""Predictions judged by their signed bias, of each group and of all jointly, in words and as a table.

And by limits of agreement: how far predictions lie from what was measured, over conditions.
"""

from __future__ import annotations

from collections.abc import Sequence

from data_schema.vocabulary import Undefined
from reports import fields
from reports.content import AssumedInput, Judged, JudgedGroup, Limits, ReportContent
from reports.display import (
    EQUALS,
    as_shown,
    common_places,
    count_text,
    decimal_text,
    general_text,
    interval_text,
    list_text,
    p_text,
    sentence_start,
    shown_unit,
    value_text,
    with_unit,
)
from reports.naming import levels_name
from reports.numbers import Number
from reports.tables.table import (
    PROVENANCE,
    Cell,
    Column,
    Columns,
    Table,
    TableKind,
    count,
    interval_cell,
    number_cell,
    p_cell,
    provenance_cell,
    table_of,
    text_column,
    words,
)

_CI = "95\u00a0% CI"
_NAMED = 2
"""Groups that a sentence names before it only counts them."""
_ORDERED = 3
"""So many groups have an order worth a tau: of two it is 1 or -1."""


def _places_of_biases(one: Judged) -> int:
    """Return the decimals of a quantity's biases, in the unit that they are shown in."""
    return common_places([group.bias for group in one.groups])


def _group_verdict(group: JudgedGroup, places: int) -> str:
    """Say what a group's bias amounts to: "predictions 5.1 J high", "no significant bias"."""
    if group.differs:
        return f"predictions {_size([group], places)}"
    if group.agrees_only_by_assumed:
        return f"{_size([group], places)}, not significant with the assumed inputs' uncertainty included"
    return "no significant bias"


def _size(groups: Sequence[JudgedGroup], places: int) -> str:
    """Write how far predictions of groups lie to one side: "4.6 to 5.6 J high"."""
    shown = [as_shown(group.bias) for group in groups]
    values = sorted(abs(each.value) for each in shown if not isinstance(each.value, Undefined))
    ends = dict.fromkeys(decimal_text(value, places) for value in (values[0], values[-1]))
    side = "high" if _is_high(groups[0]) else "low"
    return f"{with_unit(' to '.join(ends), shown[0].unit)} {side}"


def _is_high(group: JudgedGroup) -> bool:
    return isinstance(group.bias.value, float) and group.bias.value > 0.0


def _joint_text(one: Judged) -> str:
    """Write the joint test and Kendall's tau of the order of groups: "joint p < .001, \u03c4 = 0.33"."""
    value = None if one.tau is None or len(one.groups) < _ORDERED else one.tau.value
    tau = f", \u03c4{EQUALS}{decimal_text(value, 2)}" if isinstance(value, float) else ""
    return f"joint {p_text(one.joint_p.value)}{tau}"


def verdict_text(content: ReportContent) -> str:
    """Say of each quantity whether its predictions are biased, where and by how much; "" where none can be judged."""
    found, assumed = content.predictions.judged, content.predictions.assumed
    sentences = [
        f"{sentence_start(str(each.quantity))} ({_joint_text(each)}): {_where_biased(content, each)}." for each in found
    ]
    if any(group.differs for each in found for group in each.groups):
        needed = [text for each in found if (text := _needed(each, assumed))]
        explained = f"To explain that, {'; '.join(needed)}; or an" if needed else "No assumed input explains that: an"
        sentences.append(f"{explained} effect is missing in the scene.")
    fitted = [one.name for one in assumed if one.fitted]
    if found and fitted:
        sentences.append(f"Fitted to this study: {list_text(fitted)}; agreement with the runs fitted is no test.")
    return " ".join(sentences)


def _needed(one: Judged, assumed: Sequence[AssumedInput]) -> str:
    """Say how far off the input that moves a quantity most must be to explain its largest bias alone, if linear."""
    biases = [abs(group.bias.value) for group in one.groups if group.differs and isinstance(group.bias.value, float)]
    moves = [
        (part, each) for each in assumed if isinstance(part := each.changes.get(one.quantity), float) and part > 0.0
    ]
    if not biases or not moves:
        return ""
    part, most = max(moves, key=lambda of: of[0])
    off = with_unit(general_text(100.0 * max(biases) / part * most.parameter.varied_by, 2), "%")
    within = with_unit(general_text(100.0 * most.parameter.varied_by, 2), "%")
    return f"{most.name} must be {off} off, not within {within} ({one.quantity})"


def _where_biased(content: ReportContent, one: Judged) -> str:
    parts = []
    for high in (True, False):
        biased = [each for each in one.groups if each.differs and _is_high(each) is high]
        if biased:
            parts.append(f"{_size(biased, _places_of_biases(one))}{_where(content, one.groups, biased)}")
    bought = [each for each in one.groups if each.agrees_only_by_assumed]
    if bought and not parts:
        means = "mean agrees" if len(bought) == 1 else "means agree"
        return f"group {means}{_where(content, one.groups, bought)} only with the assumed inputs' uncertainty included"
    return list_text(parts) or "no significant bias"


def _where(content: ReportContent, groups: Sequence[JudgedGroup], chosen: Sequence[JudgedGroup]) -> str:
    """Name the chosen groups, or count them; "" where a study has one group."""
    if len(groups) == 1:
        return ""
    if len(chosen) == len(groups):
        return " in all groups"
    if len(chosen) <= _NAMED:
        return f" at {list_text([levels_name(content, each.group) for each in chosen])}"
    return f" in {len(chosen)} of {count_text(len(groups), 'group')}"


def _make(content: ReportContent) -> Table:
    columns: Columns[tuple[Judged, JudgedGroup]] = (
        (text_column("quantity", fields.QUANTITY), lambda row: words(str(row[0].quantity))),
        (text_column("group", fields.GROUP), lambda row: words(levels_name(content, row[1].group) or "all runs")),
        (Column("days", fields.DAYS), lambda row: count(row[1].days)),
        (Column("runs", fields.N, shown=False), lambda row: count(row[1].bias.n)),
        (Column("measured", fields.PLAIN_MEASURED, shown=False), lambda row: Cell("", (row[1].measured.value,))),
        (Column("predicted", fields.PLAIN_PREDICTED, shown=False), lambda row: Cell("", (row[1].predicted.value,))),
        (Column("bias", fields.BIAS), lambda row: _bias(row[1].bias, _places_of_biases(row[0]))),
        (
            Column(_CI, fields.BIAS_INTERVAL),
            lambda row: Cell(
                interval_text(row[1].bias, _places_of_biases(row[0])), (row[1].bias.ci_low, row[1].bias.ci_high)
            ),
        ),
        (
            Column("by measurement alone", fields.INTERVAL_OF_MEASURED, shown=False),
            lambda row: Cell("", (row[1].of_measured.ci_low, row[1].of_measured.ci_high)),
        ),
        (Column("p", fields.P), lambda row: p_cell(row[1].p.value)),
        (
            text_column("verdict", fields.VERDICT, prose=True),
            lambda row: words(_group_verdict(row[1], _places_of_biases(row[0]))),
        ),
        (
            Column("joint test", fields.JOINT_TEST, shown=False),
            lambda row: _joint(row[0]),
        ),
        (PROVENANCE, lambda row: provenance_cell(row[1].bias.provenance)),
    )
    caption = (
        "Predicted less measured by day; intervals hold both errors. Joint p: Bonferroni's; "
        f"\u03c4: Kendall's, of groups.{_other_units(content)}"
    )
    groups = [(one, group) for one in content.predictions.judged for group in one.groups]
    return table_of("prediction_bias", caption, groups, columns)


def _bias(bias: Number, places: int) -> Cell:
    shown = as_shown(bias)
    return Cell(with_unit(value_text(shown.value, places), shown.unit), (bias.value, bias.unit))


def _joint(one: Judged) -> Cell:
    tau, tau_id = (None, None) if one.tau is None else (one.tau.value, one.tau.provenance)
    return Cell("", (one.joint_p.value, tau, one.joint_p.provenance, tau_id))


def _other_units(content: ReportContent) -> str:
    """Say which factors the scene takes in another unit than the study states; "" for none."""
    return "".join(
        f" {sentence_start(factor.title)}: {factor.unit} in the study, as many {unit} in the scene."
        for factor in content.factors
        if (factor.slope is not None or factor.unit)
        and (unit := content.predictions.units.get(factor.name, factor.unit)) != factor.unit
    )


PREDICTION_BIAS = TableKind("prediction_bias", _make)


def _limits_of_agreement(content: ReportContent) -> Table:
    columns: Columns[tuple[Judged, Limits]] = (
        (text_column("quantity", fields.QUANTITY), lambda row: words(str(row[0].quantity))),
        (text_column("unit", fields.UNIT), lambda row: words(shown_unit(row[1].mean_difference.unit)[0])),
        (Column("conditions", fields.N), lambda row: count(row[1].mean_difference.n)),
        (_limit_columns("mean", of="mean"), lambda row: _limit_cells(row[1], row[1].mean_difference)),
        (_limit_columns("lower limit", of="low"), lambda row: _limit_cells(row[1], row[1].lower_limit)),
        (_limit_columns("upper limit", of="high"), lambda row: _limit_cells(row[1], row[1].upper_limit)),
        (PROVENANCE, lambda row: provenance_cell(row[1].mean_difference.provenance)),
    )
    caption = (
        "Predicted less measured over conditions (Bland and Altman): mean difference, and the limits between which "
        "95\u00a0% of further conditions are expected."
    )
    found = [(one, one.limits) for one in content.predictions.judged if one.limits is not None]
    return table_of("limits_of_agreement", caption, found, columns)


def _limit_columns(title: str, *, of: str) -> tuple[Column, Column]:
    interval = Column(_CI, fields.named(fields.INTERVAL, of=f"{of}_"))
    return Column(title, fields.named(fields.LIMIT, of=of)), interval


def _limit_cells(limits: Limits, number: Number) -> tuple[Cell, Cell]:
    places = common_places((limits.mean_difference, limits.lower_limit, limits.upper_limit))
    return number_cell(number, places), interval_cell(number, places)


LIMITS_OF_AGREEMENT = TableKind("limits_of_agreement", _limits_of_agreement)
