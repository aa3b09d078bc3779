"""Results over groups and tests against bounds with chosen numbers, as a report carries them."""

import csv
import dataclasses
import io

from data_schema.outcomes import Outcome
from reports.numbers import Number
from reports.results import Equivalence, OverallEquivalence, OverallSavings
from reports.tables.formats import csv_bytes
from reports.tables.registry import TABLES

DAYS = ("2021-06-01", "2021-06-02", "2021-06-03", "2021-06-04", "2021-06-07")


def plain(text):
    """Text with spaces that break."""
    return text.replace("\u00a0", " ")


def csv_rows(name, content):
    """A table of the report as its file has it."""
    return list(csv.DictReader(io.StringIO(csv_bytes(TABLES[name].make(content)).decode("utf-8"))))


def shown(table, row):
    """The cells of a row as the page shows them."""
    return [plain(cell.text) for cell in table.cells(row)]


def decided(comparisons, *changes):
    """Comparisons, each with these numbers in its decision."""
    return tuple(
        dataclasses.replace(one, decision=dataclasses.replace(one.decision, **change))
        for one, change in zip(comparisons, changes, strict=True)
    )


def t_and_p(t, df, p):
    return {"t": Number(t, "1", df=df), "p": Number(p, "1")}


def equivalence(estimate, *, low=-3.0, high=3.0, p=0.001, shown=True):
    t, one = Number(9.0, "1", df=3.0), Number(0.001, "1", df=3.0)
    return Equivalence(estimate, t, one, t, one, Number(p, "1"), shown, low, high, estimate.unit == "%")


def overall_equivalence(tested, groups, left_out=(), days=DAYS, days_measured_only=False):
    fields = {each.name: getattr(tested, each.name) for each in dataclasses.fields(tested)}
    return OverallEquivalence(
        **fields, groups=groups, left_out=left_out, days=days, days_measured_only=days_measured_only
    )


def overall_savings(saved, groups, **changes):
    spread = Number(4.0, "%")
    one = OverallSavings(
        Outcome.JOULES, saved, **t_and_p(7.7, 13.9, 1e-5), spread=spread, heterogeneity_p=Number(0.2, "1"),
        groups=groups, left_out=(), days=DAYS, days_measured_only=False, rejected=True, differ=False,
    )  # fmt: skip
    return dataclasses.replace(one, **changes)


def changed(content, which=lambda _comparison: True, **decision):
    """Return the content with other numbers in the decisions of some comparisons."""
    ways = [decision if which(one) else {} for one in content.comparisons]
    return dataclasses.replace(content, comparisons=decided(content.comparisons, *ways))
