"""The table of limits of agreement: how far predictions lie from what was measured, over conditions."""

from __future__ import annotations

from reports.content import ReportContent
from reports.display import common_places, shown_unit
from reports.predicted import Judged, Limits
from reports.tables.table import (
    PROVENANCE,
    Column,
    Row,
    Table,
    TableKind,
    count,
    interval_cell,
    number_cell,
    provenance_cell,
    words,
)

_CI = "95\u00a0% CI"
_COLUMNS = (
    Column("quantity", ("quantity",), numeric=False),
    Column("unit", ("unit",), numeric=False),
    Column("conditions", ("n",)),
    Column("mean", ("mean",)),
    Column(_CI, ("mean_ci_low", "mean_ci_high", "mean_ci_level")),
    Column("lower limit", ("low",)),
    Column(_CI, ("low_ci_low", "low_ci_high", "low_ci_level")),
    Column("upper limit", ("high",)),
    Column(_CI, ("high_ci_low", "high_ci_high", "high_ci_level")),
    PROVENANCE,
)


def _make(content: ReportContent) -> Table:
    rows = tuple(_row(one, one.limits) for one in content.predictions.judged if one.limits is not None)
    caption = (
        "Predicted less measured over conditions (Bland and Altman): mean difference, and the limits between which "
        "95\u00a0% of further conditions are expected."
    )
    return Table("limits_of_agreement", caption, _COLUMNS, rows)


def _row(one: Judged, limits: Limits) -> Row:
    numbers = (limits.mean, limits.low, limits.high)
    places = common_places(numbers)
    cells = [cell for each in numbers for cell in (number_cell(each, places), interval_cell(each, places))]
    unit = words(shown_unit(limits.mean.unit)[0])
    return Row((words(str(one.quantity)), unit, count(limits.mean.n), *cells, provenance_cell(limits.mean.provenance)))


LIMITS_OF_AGREEMENT = TableKind("limits_of_agreement", _make)
