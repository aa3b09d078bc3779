"""What stands beside a comparison: Holm, equivalence, and the word exploratory."""

import dataclasses

import pytest

from data_schema.outcomes import Outcome
from reports.results import Plan
from reports.tables.registry import TABLES
from tests.helpers.pages import quick_page
from tests.helpers.wording import says
from tests.reports import made
from tests.reports.made import csv_rows


def changed(content, change, which=lambda _comparison: True):
    return dataclasses.replace(content, comparisons=tuple(change(c) if which(c) else c for c in content.comparisons))


@pytest.mark.parametrize("quantity", [Outcome.JOULES, Outcome.APEX])
def test_holms_p_stands_beside_the_p_of_its_family_and_a_dash_beside_others(content, quantity):
    name = f"comparisons_{quantity.key}"
    chosen = [c for c in content.comparisons if c.quantity is quantity]
    for row, comparison in zip(csv_rows(name, content), chosen, strict=True):
        adjusted = comparison.decision.adjusted
        assert row["holm_p"] == ("" if adjusted is None else repr(adjusted.value))
        assert row["holm_tests"] == ("" if adjusted is None else "4")
        assert row["holm_provenance"] == ("" if adjusted is None else adjusted.provenance)
    says(TABLES[name].make(content).caption, "4 tests")
    without = made.changed(content, adjusted=None)
    assert "Holm" not in [column.title for column in TABLES[name].make(without).heads]
    assert "Holm" not in TABLES[name].make(without).caption


def test_equivalence_has_both_tests_and_the_verdict(content):
    tested = [c.decision.equivalence for c in content.comparisons if c.decision.equivalence is not None]
    for row, item in zip(csv_rows("equivalence", content), tested, strict=True):
        assert float(row["difference_m"]) == item.estimate.value
        assert (float(row["t_low_statistic"]), float(row["t_low_p"])) == (item.t_low.value, item.p_low.value)
        assert (float(row["t_high_df"]), float(row["t_high_p"])) == (item.t_high.df, item.p_high.value)
        assert float(row["tost_p"]) == item.p.value
        assert (float(row["bound_low_m"]), float(row["bound_high_m"])) == (-0.005, 0.005)
        assert row["equivalent"] == str(item.shown).lower()
    table = TABLES["equivalence"].make(content)
    says(table.caption, "−5", "5 mm", "two one-sided tests")
    assert {row.cells[9].text for row in table.rows} <= {"shown", "not shown"}
    assert len({column.title for column in table.heads} & {"90\u00a0% CI"}) == 1


def test_without_a_test_of_equivalence_the_page_says_why(content):
    none = made.changed(content, equivalence=None)
    told = dataclasses.replace(none, no_equivalence="No bounds were stated.")
    says(quick_page(told), "No bounds were")
    assert TABLES["equivalence"].make(told).rows == ()
    assert "two one-sided tests" not in quick_page(told)


def test_what_is_exploratory_stands_under_its_word_with_the_reason_in_caption_and_file(content):
    told = changed(
        content, lambda c: dataclasses.replace(c, exploratory="the family is pooled"), lambda c: c.level != "pooled"
    )
    for name in ("comparisons_joules", "tests_joules"):
        blocks = TABLES[name].make(told).blocks
        assert all(("(exploratory)" in block) == block.startswith("each AD gain") for block, _ in blocks)
    caption = TABLES["comparisons_joules"].make(told).caption
    says(caption, "Rows called exploratory")
    assert {row["exploratory"] for row in csv_rows("comparisons_joules", told)} == {"", "the family is pooled"}
    assert all("(exploratory)" not in block for block, _ in TABLES["equivalence"].make(told).blocks)
    item = next(c.decision.equivalence for c in content.comparisons if c.decision.equivalence is not None)
    unplanned = dataclasses.replace(item, exploratory="no bounds then")
    own = made.changed(content, lambda c: c.decision.equivalence is not None, equivalence=unplanned)
    table = TABLES["equivalence"].make(own)
    assert all(block.endswith("(exploratory)") for block, _ in table.blocks)
    says(table.caption, "because no bounds")


def test_what_was_decided_and_what_departs_stand_under_a_heading_of_their_own(content):
    told = dataclasses.replace(
        content, plan=Plan(decided=("Alpha is 0.05.",), departures=("Departure: alpha was 0.01.",))
    )
    page = quick_page(told)
    heading = "Plan and deviations</h2>"
    assert page.index(heading) < page.index("Alpha is 0.05.") < page.index("alpha was 0.01.")
    assert heading not in quick_page(content)


def test_several_reasons_why_rows_are_exploratory_stand_numbered_in_the_caption(content):
    told = changed(content, lambda c: dataclasses.replace(c, exploratory=f"of {c.level != 'pooled'}; then"))
    says(TABLES["comparisons_joules"].make(told).caption, "Rows called exploratory", "1", "2")
