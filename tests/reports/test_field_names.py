"""The names that programs and papers rely on are those of `field_names.txt`, whatever the titles on the page are."""

import dataclasses
import os
from pathlib import Path

from reports.numbers import Number
from reports.tables.formats import macros_of
from reports.tables.registry import TABLES
from tests.reports.made import overall_equivalence, overall_savings

NAMES = Path(__file__).with_name("field_names.txt")


def with_endings(names):
    """Names in their order, each with those that go on from it by what is added."""
    found = []
    for name in names:
        if found and name.startswith(found[-1][0]):
            found[-1].append(name.removeprefix(found[-1][0]))
        else:
            found.append([name])
    return found


def test_fields_of_tables_and_names_of_macros_are_those_on_record(plated):
    pooled = [each for each in plated.pooled if each.group == {"foot": "small", "k_gain": "300"}]
    number, groups = Number(11.0, "%", ci_low=8.0, ci_high=14.0), (pooled[0].group,)
    content = dataclasses.replace(
        plated,
        comparisons=tuple(
            dataclasses.replace(each, decision=dataclasses.replace(each.decision, adjusted=number)) for each in pooled
        ),
        overall=(overall_savings(number, groups),),
        overall_equivalence=overall_equivalence(pooled[1].decision.equivalence, groups),
    )
    tables = {f"{name}.csv": kind.make(content).columns for name, kind in TABLES.items()}
    found = [
        *(" ".join((f"{name}:", *(field for column in of for field in column.fields))) for name, of in tables.items()),
        *(f"numbers.tex: {' '.join(names)}" for names in with_endings([macro.name for macro in macros_of(content)])),
    ]
    if os.environ.get("LABBOOK_FROZEN") == "write":
        NAMES.write_text("".join(f"{line}\n" for line in found), encoding="utf-8")
    assert found == NAMES.read_text(encoding="utf-8").splitlines()
