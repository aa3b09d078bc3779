"""The table that judges predictions: signed bias of each group with its interval, and all groups together."""

from __future__ import annotations

from reports.content import ReportContent
from reports.display import as_shown, interval_text, value_text, with_unit
from reports.judged import group_verdict, places_of_biases
from reports.naming import levels_name
from reports.predicted import Judged, JudgedGroup
from reports.tables.table import PROVENANCE, Cell, Column, Row, Table, TableKind, count, p_cell, provenance_cell, words
from reports.wording import sentence_start

_COLUMNS = (
    Column("quantity", ("quantity",), numeric=False),
    Column("group", ("group",), numeric=False),
    Column("days", ("days",)),
    Column("runs", ("n",), shown=False),
    Column("measured", ("measured",), shown=False),
    Column("predicted", ("predicted",), shown=False),
    Column("bias", ("bias", "unit")),
    Column("95\u00a0% CI", ("ci_low", "ci_high")),
    Column("by measurement alone", ("ci_low_measured", "ci_high_measured"), shown=False),
    Column("p", ("p",)),
    Column("verdict", ("verdict",), numeric=False, prose=True),
    Column("joint test", ("joint_p", "kendall_tau", "joint_id", "kendall_tau_id"), shown=False),
    PROVENANCE,
)


def _make(content: ReportContent) -> Table:
    rows = [_row(content, one, group) for one in content.predictions.judged for group in one.groups]
    caption = (
        "Predicted less measured by day; intervals hold both errors. Joint p: Bonferroni's; "
        f"\u03c4: Kendall's, of groups.{_other_units(content)}"
    )
    return Table("prediction_bias", caption, _COLUMNS, tuple(rows))


def _other_units(content: ReportContent) -> str:
    """Say which factors the scene takes in another unit than the study states; "" for none."""
    return "".join(
        f" {sentence_start(factor.title)}: {factor.unit} in the study, as many {unit} in the scene."
        for factor in content.factors
        if (factor.slope is not None or factor.unit)
        and (unit := content.predictions.units.get(factor.name, factor.unit)) != factor.unit
    )


def _row(content: ReportContent, one: Judged, group: JudgedGroup) -> Row:
    bias, places = group.bias, places_of_biases(one)
    shown = as_shown(bias)
    tau, tau_id = (None, None) if one.tau is None else (one.tau.value, one.tau.provenance)
    return Row(
        (
            words(str(one.quantity)),
            words(levels_name(content, group.group) or "all runs"),
            count(group.days),
            count(bias.n),
            Cell("", (group.measured.value,)),
            Cell("", (group.predicted.value,)),
            Cell(with_unit(value_text(shown.value, places), shown.unit), (bias.value, bias.unit)),
            Cell(interval_text(bias, places), (bias.ci_low, bias.ci_high)),
            Cell("", (group.of_measured.ci_low, group.of_measured.ci_high)),
            p_cell(group.p.value),
            words(group_verdict(group, places)),
            Cell("", (one.joint_p.value, tau, one.joint_p.provenance, tau_id)),
            provenance_cell(bias.provenance),
        ),
    )


PREDICTION_BIAS = TableKind("prediction_bias", _make)
