"""Stored numbers as a report carries them."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass, field

from data_schema.queries.results import NumberRow, ResultRow
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison import pairing
from labbook.analysis.results.result_cache import number
from reports.content import Number, Provenance, SignificanceTest, Value


@dataclass
class Shown:
    """Remembers every stored number that a report shows, for its list of sources."""

    sources: dict[str, Provenance] = field(default_factory=dict)

    def number(self, row: ResultRow, name: str) -> Number:
        """Return a number of a result with its provenance id."""
        item = number(row, name)
        self.sources[item.uid] = Provenance(item.uid, f"{name.replace('_', ' ')}, {_scope(row)}", len(row.inputs))
        undefined = Undefined(_reason(row, item))
        return Number(
            value=_value(row, item),
            unit=item.unit,
            se=item.se,
            shared_se=item.shared_se,
            ci_low=undefined if item.value is None else item.ci_low,
            ci_high=undefined if item.value is None else item.ci_high,
            ci_level=item.ci_level or 0.95,
            df=item.df,
            n=item.n,
            provenance=item.uid,
        )

    def value(self, row: ResultRow, name: str) -> Value:
        """Return the bare value of a number."""
        return self.number(row, name).value

    def test(
        self, row: ResultRow, name: str, statistic: str, p: str, df: tuple[Value, ...] | None = None
    ) -> SignificanceTest:
        """Return a test as statistic, degrees of freedom and p."""
        return SignificanceTest(
            name,
            _value(row, number(row, statistic)),
            df or (_df(row, number(row, statistic)),),
            _value(row, number(row, p)),
        )


def _value(row: ResultRow, item: NumberRow) -> Value:
    return Undefined(_reason(row, item)) if item.value is None else item.value


def _df(row: ResultRow, item: NumberRow) -> Value:
    return Undefined(_reason(row, item)) if item.df is None else item.df


def _reason(row: ResultRow, item: NumberRow) -> str:
    """Return why a number does not exist, with the two sides of a comparison called as the report calls them.

    A comparison sets its second group against its first (treatment less control); the values compared are runs
    or days.
    """
    reason, scope = item.undefined_reason or "", json.loads(row.scope_json)
    family = scope.get("family")
    if family is None:
        return reason
    for group, name in zip(("group a", "group b"), side_names(family), strict=True):
        reason = reason.replace(group, name).replace(f"group '{group[-1]}'", name)
    return values_as(scope.get("unit", "run"), reason)


def side_names(family: str) -> tuple[str, str]:
    """Return what a family of comparisons calls the side that is compared, and the one that it is compared with."""
    between = family.startswith(pairing.BETWEEN.partition("{")[0])
    return ("the level", "the level it is compared with") if between else ("the treatment", "the control")


def values_as(unit: str, text: str) -> str:
    """Call values what they are: runs, or days."""
    return re.sub(r"\bvalue(s?)\b", rf"{unit}\1", text)


def _scope(row: ResultRow) -> str:
    """Say what a result is about in a few words; the family of a comparison is in its label already."""
    scope = json.loads(row.scope_json)
    return "; ".join(str(value) for name, value in scope.items() if value != "" and name != "family")
