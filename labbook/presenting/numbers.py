"""Stored numbers as a report carries them."""

from __future__ import annotations

import json
from dataclasses import dataclass, field

from data_schema.queries.results import NumberRow, ResultRow
from data_schema.vocabulary import Undefined
from labbook.analysis.workbench import number
from reports.content import Number, Provenance, SignificanceTest, Value


@dataclass
class Shown:
    """Remembers every stored number that a report shows, for its list of sources."""

    sources: dict[str, Provenance] = field(default_factory=dict)

    def number(self, row: ResultRow, name: str) -> Number:
        """Return a number of a result with its provenance id."""
        item = number(row, name)
        self.sources[item.uid] = Provenance(item.uid, f"{name.replace('_', ' ')}, {_scope(row)}", len(row.inputs))
        undefined = Undefined(item.undefined_reason or "")
        return Number(
            value=_value(item),
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
            name, _value(number(row, statistic)), df or (_df(number(row, statistic)),), _value(number(row, p))
        )


def _value(item: NumberRow) -> Value:
    return Undefined(item.undefined_reason or "") if item.value is None else item.value


def _df(item: NumberRow) -> Value:
    return Undefined(item.undefined_reason or "") if item.df is None else item.df


def _scope(row: ResultRow) -> str:
    """Say what a result is about in a few words; the family of a comparison is in its label already."""
    scope = json.loads(row.scope_json)
    return "; ".join(str(value) for name, value in scope.items() if value != "" and name != "family")
