"""What stands beside the thesis's route: Holm, the comparisons by day, equivalence, and the word exploratory."""

import csv
import dataclasses
import io

import pytest

from data_schema.outcomes import Outcome
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from reports.remarks import FOOTNOTE, by_day_sentences
from reports.tables.formats.as_csv import csv_bytes
from reports.tables.registry import TABLES
from tests.helpers.pages import quick_page
from tests.helpers.wording import says


def csv_rows(name, content):
    return list(csv.DictReader(io.StringIO(csv_bytes(TABLES[name].make(content)).decode("utf-8"))))


def changed(content, change, which=lambda _comparison: True):
    return dataclasses.replace(content, comparisons=tuple(change(c) if which(c) else c for c in content.comparisons))


@pytest.mark.parametrize(("quantity", "slug"), [(Outcome.JOULES, "j"), (Outcome.APEX, "m")])
def test_holms_p_stands_beside_the_p_of_its_family_and_a_dash_beside_others(content, quantity, slug):
    name = f"comparisons_{'joules' if slug == 'j' else 'apex'}"
    chosen = [c for c in content.comparisons if c.quantity is quantity]
    for row, comparison in zip(csv_rows(name, content), chosen, strict=True):
        adjusted = comparison.adjusted
        assert row["holm_p"] == ("" if adjusted is None else repr(adjusted.value))
        assert row["holm_tests"] == ("" if adjusted is None else "4")
        assert row["holm_provenance"] == ("" if adjusted is None else adjusted.provenance)
    says(TABLES[name].make(content).caption, "4 tests")
    without = changed(content, lambda c: dataclasses.replace(c, adjusted=None))
    assert "Holm" not in [column.title for column in TABLES[name].make(without).heads]
    assert "Holm" not in TABLES[name].make(without).caption


@pytest.mark.parametrize(("quantity", "slug"), [(Outcome.JOULES, "j"), (Outcome.APEX, "m")])
def test_by_day_has_difference_interval_test_and_spreads_unrounded(content, quantity, slug):
    name = f"by_day_{'joules' if slug == 'j' else 'apex'}"
    chosen = [c.by_day for c in content.comparisons if c.quantity is quantity]
    for row, by_day in zip(csv_rows(name, content), chosen, strict=True):
        assert float(row[f"difference_{slug}"]) == by_day.difference.value
        assert float(row[f"ci_high_{slug}"]) == by_day.difference.ci_high
        assert (float(row["t_statistic"]), float(row["t_df"])) == (by_day.test.statistic, by_day.test.df[0])
        assert float(row["t_p"]) == by_day.test.p
        assert float(row[f"day_sd_{slug}"]) == by_day.day_sd.value
        assert float(row[f"run_sd_{slug}"]) == by_day.run_sd.value


def test_the_table_by_day_names_the_test_of_every_row(content):
    on_runs = "exact test on runs, day held fixed"
    joules = [c for c in content.comparisons if c.quantity is Outcome.JOULES]
    exact = changed(
        content,
        lambda c: dataclasses.replace(c, by_day=dataclasses.replace(c.by_day, method=on_runs)),
        lambda c: c is joules[0],
    )
    table = TABLES["by_day_joules"].make(exact)
    (place,) = [number for number, column in enumerate(table.columns) if column.title == "test"]
    assert [row.cells[place].text for row in table.rows] == ["exact test", *["mixed model"] * (len(joules) - 1)]
    assert [row["method"] for row in csv_rows("by_day_joules", exact)][:2] == [on_runs, "mixed model"]
    says(table.caption, "exact test where")


def confounded(comparison):
    nothing = Undefined(Reason.AS_SAID, said="one day each")
    test = dataclasses.replace(comparison.by_day.test, statistic=nothing, df=(nothing,), p=nothing)
    difference = dataclasses.replace(comparison.by_day.difference, ci_low=nothing, ci_high=nothing)
    by_day = dataclasses.replace(comparison.by_day, test=test, difference=difference, confounding="No day joins them.")
    return dataclasses.replace(comparison, by_day=by_day)


def test_confounded_days_are_said_once_with_the_comparisons_that_it_is_true_of(content):
    joules = [c for c in content.comparisons if c.quantity is Outcome.JOULES]
    assert by_day_sentences(content, Outcome.JOULES) == []
    every = changed(content, confounded)
    says(by_day_sentences(every, Outcome.JOULES), "No day joins", "all 24 comparisons")
    says(quick_page(every), "No day joins")
    one = changed(content, confounded, lambda c: c is joules[0])
    (sentence,) = by_day_sentences(one, Outcome.JOULES)
    says(sentence.replace("\u00a0", " "), "No day joins", "835 N/m")
    assert by_day_sentences(one, Outcome.APEX) == []
    pooled = changed(content, confounded, lambda c: c.level != "pooled")
    says(by_day_sentences(pooled, Outcome.JOULES), "No day joins", "20 of 24")
    table = TABLES["by_day_joules"].make(one)
    assert table.footnotes == {"one day each": "a"}
    says(csv_rows("by_day_joules", one)[0]["confounding"], "No day joins")
    marked = changed(
        one, lambda c: dataclasses.replace(c, one_day_each="one day each"), lambda c: c.by_day.confounding != ""
    )
    assert by_day_sentences(marked, Outcome.JOULES) == []  # said among the claims
    assert TABLES["by_day_joules"].make(marked).explained == {"a": f"undefined: {FOOTNOTE}"}


def test_equivalence_has_both_tests_and_the_verdict(content):
    tested = [c.equivalence for c in content.comparisons if c.equivalence is not None]
    for row, item in zip(csv_rows("equivalence", content), tested, strict=True):
        assert float(row["difference_m"]) == item.estimate.value
        assert (float(row["t_low_statistic"]), float(row["t_low_p"])) == (item.at_low.statistic, item.at_low.p)
        assert (float(row["t_high_df"]), float(row["t_high_p"])) == (item.at_high.df[0], item.at_high.p)
        assert float(row["tost_p"]) == item.p
        assert (float(row["bound_low_m"]), float(row["bound_high_m"])) == (-0.005, 0.005)
        assert row["equivalent"] == str(item.shown).lower()
    table = TABLES["equivalence"].make(content)
    says(table.caption, "−5", "5 mm", "two one-sided tests")
    assert {row.cells[9].text for row in table.rows} <= {"shown", "not shown"}
    assert len({column.title for column in table.heads} & {"90\u00a0% CI"}) == 1


@pytest.mark.parametrize(
    ("name", "titles"),
    [
        ("headlines", {"p", "95\u00a0% CI"}),
        ("comparisons_apex", {"p", "Holm", "95\u00a0% CI"}),
        ("equivalence", {"p", "equivalence", "90\u00a0% CI"}),
        ("tests_joules", {"p"}),
        ("tests_jumps", {"p"}),
        ("anovas", {"p"}),
    ],
)
def test_what_a_p_cannot_tell_is_its_footnote_and_stands_in_the_file(content, name, titles):
    why = "control and treatment had one day each"
    told = dataclasses.replace(
        changed(content, lambda c: dataclasses.replace(c, one_day_each=why)),
        jump_comparisons=tuple(dataclasses.replace(c, one_day_each=why) for c in content.jump_comparisons),
        anovas=tuple(dataclasses.replace(anova, one_day_each=why) for anova in content.anovas),
    )
    table, plain = (TABLES[name].make(each) for each in (told, content))
    assert table.footnotes == plain.footnotes | {FOOTNOTE: "abc"[len(plain.footnotes)]}
    assert table.explained == plain.explained | {table.footnotes[FOOTNOTE]: FOOTNOTE}  # a p that is there is no reason
    of_tests = {"F (df)", "t (df)", "Welch t (df)", "Brown-Forsythe p"}
    for row in table.rows:
        marked = {column.title for column, cell in zip(table.columns, row.cells, strict=True) if cell.note == FOOTNOTE}
        assert marked <= titles
        assert "p" in marked
        assert not marked & of_tests
    assert {row["one_day_each"] for row in csv_rows(name, told)} == {why}
    assert {row["one_day_each"] for row in csv_rows(name, content)} == {""}
    if name == "equivalence":
        assert {row.cells[9].text for row in table.rows} == {"–"}
    if name == "anovas":
        page = quick_page(told)
        assert why not in page
        assert page.count("difference between days)") == len(content.anovas)


def test_without_a_test_of_equivalence_the_page_says_why(content):
    none = changed(content, lambda c: dataclasses.replace(c, equivalence=None))
    told = dataclasses.replace(none, no_equivalence="No bounds were stated.")
    says(quick_page(told), "No bounds were")
    assert TABLES["equivalence"].make(told).rows == ()
    assert "two one-sided tests" not in quick_page(told)


def test_what_is_exploratory_stands_under_its_word_with_the_reason_in_caption_and_file(content):
    told = changed(
        content, lambda c: dataclasses.replace(c, exploratory="the family is pooled"), lambda c: c.level != "pooled"
    )
    for name in ("comparisons_joules", "by_day_apex", "tests_joules"):
        blocks = TABLES[name].make(told).blocks
        assert all(("(exploratory)" in block) == block.startswith("each AD gain") for block, _ in blocks)
    caption = TABLES["comparisons_joules"].make(told).caption
    says(caption, "Rows called exploratory")
    assert {row["exploratory"] for row in csv_rows("comparisons_joules", told)} == {"", "the family is pooled"}
    assert all("(exploratory)" not in block for block, _ in TABLES["equivalence"].make(told).blocks)
    own = changed(
        content,
        lambda c: dataclasses.replace(c, equivalence=dataclasses.replace(c.equivalence, exploratory="no bounds then")),
        lambda c: c.equivalence is not None,
    )
    table = TABLES["equivalence"].make(own)
    assert all(block.endswith("(exploratory)") for block, _ in table.blocks)
    says(table.caption, "because no bounds")


def test_what_was_decided_and_what_departs_stand_under_a_heading_of_their_own(content):
    told = dataclasses.replace(content, decided=("Alpha is 0.05.",), departures=("Departure: alpha was 0.01.",))
    page = quick_page(told)
    heading = "Plan and deviations</h2>"
    assert page.index(heading) < page.index("Alpha is 0.05.") < page.index("alpha was 0.01.")
    assert heading not in quick_page(content)


def test_several_reasons_why_rows_are_exploratory_stand_numbered_in_the_caption(content):
    told = changed(content, lambda c: dataclasses.replace(c, exploratory=f"of {c.level != 'pooled'}; then"))
    says(TABLES["comparisons_joules"].make(told).caption, "Rows called exploratory", "1", "2")


def test_analyses_of_variance_and_tests_over_jumps_are_called_exploratory_too(content):
    assert not any("exploratory" in TABLES[name].make(content).caption for name in ("anovas", "tests_jumps"))
    told = dataclasses.replace(
        content,
        anovas=tuple(dataclasses.replace(anova, exploratory="no family has one") for anova in content.anovas),
        jump_comparisons=tuple(dataclasses.replace(c, exploratory="runs count") for c in content.jump_comparisons),
    )
    for name, reason in (("anovas", "no family has one"), ("tests_jumps", "runs count")):
        table = TABLES[name].make(told)
        assert table.rows
        assert all(block.endswith("(exploratory)") for block, _ in table.blocks)
        says(table.caption, "Rows called exploratory", reason)
        assert {row["exploratory"] for row in csv_rows(name, told)} == {reason}
    says(quick_page(told), "because no family")
