"""The names that programs and papers rely on are those of `field_names.txt`, whatever the titles on the page are."""

import dataclasses
from pathlib import Path

from data_schema.outcomes import Outcome
from reports.content import Number, SignificanceTest
from reports.evidence import OverallEquivalence, OverallSavings, OverGroups
from reports.tables.formats.as_macros import macros_of
from reports.tables.registry import TABLES

NAMES = Path(__file__).with_name("field_names.txt")


def test_fields_of_tables_and_names_of_macros_are_those_on_record(plated):
    pooled = [each for each in plated.pooled if each.group == {"foot": "small", "k_gain": "300"}]
    number, test = Number(11.0, "%", ci_low=8.0, ci_high=14.0), SignificanceTest("t", 7.0, (13.9,), 2e-6)
    scope = OverGroups((pooled[0].group,), (), ("2021-05-03",), False)
    content = dataclasses.replace(
        plated,
        comparisons=tuple(
            dataclasses.replace(each, decision=dataclasses.replace(each.lead, adjusted=number)) for each in pooled
        ),
        overall=(OverallSavings(Outcome.JOULES, number, test, number, number, False, True, scope),),
        overall_equivalence=OverallEquivalence(pooled[1].equivalence, scope),
    )
    tables = {f"{name}.csv": kind.make(content).columns for name, kind in TABLES.items()}
    found = [
        *(" ".join((f"{name}:", *(field for column in of for field in column.fields))) for name, of in tables.items()),
        *(f"numbers.tex: {macro.name}" for macro in macros_of(content)),
    ]
    assert found == NAMES.read_text(encoding="utf-8").splitlines()
