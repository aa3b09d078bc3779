from __future__ import annotations

from dataclasses import replace

from labbook.presenting.simulation.published_experiments import document, reasons, score
from labbook.presenting.simulation.published_results import results_table, short_rows, verdict_counts
from simulator.steady.published_numbers import comparisons
from simulator.steady.published_results import VERDICTS, contradictions
from tests.helpers.steady import results, steady_tables
from tests.helpers.wording import says


def test_every_published_number_stands_in_the_document_with_its_reason_where_it_disagrees() -> None:
    tables = steady_tables()
    compared = comparisons(tables)
    text = document(tables, compared, results())
    agrees = text.split("## What agrees")[1].split("\n## ")[0]
    for item in compared:
        name = item.published.claim.id
        assert (f"| {name} |" in agrees) == (item.finding is not None)
        assert (f"**{name}** ({item.published.claim.where})" in text) == (not item.agrees)


def test_what_disagrees_without_a_known_reason_says_so() -> None:
    compared = comparisons(steady_tables())
    name = "emu.apex_high"
    unexplained = [
        replace(item, published=replace(item.published, reason="")) if item.published.claim.id == name else item
        for item in compared
    ]
    says(reasons(unexplained)[name], "no reason is")
    assert reasons(unexplained).keys() == reasons(compared).keys()


def test_the_score_counts_what_agrees_and_what_cannot_be_compared() -> None:
    compared = comparisons(steady_tables())
    says(score(compared), "10", "21 agree", "2 more")
    says(score([item for item in compared if item.agrees]), "10 agree", "0 more")


def test_every_result_stands_in_the_table_once_with_its_verdict_and_every_contradiction_in_the_document() -> None:
    tables = steady_tables()
    text = document(tables, comparisons(tables), results())
    rows = text.split("## Every published result")[1].split("\n## ")[0].splitlines()
    for item in results():
        (row,) = [row for row in rows if row.startswith(f"| {item.result.id} |")]
        assert all(said in row for said in (item.statement, item.verdict, item.remark))
    lines = " ".join(text.split("## Where the thesis contradicts itself")[1].split("\n## ")[0].split())
    for contradiction in contradictions():
        assert f"**{contradiction.where}**: {contradiction.text}" in lines


def test_a_verdict_counts_the_points_that_contradict_and_a_p_value_stands_beside_a_saving() -> None:
    by_id = {row[0]: row for row in short_rows(results_table(results()))}
    assert by_id["emu.saving_scaled"][1:] == [
        "about 0.2",
        "0.0117 to 0.173 (median 0.124)",
        "0.15 to 0.25",
        "contradicted at 2 of 4",
    ]
    assert by_id["bed.p.s.stiff.1"][1:] == ["p = 0.041", "saves 6.3 %", "–", "not testable"]
    assert by_id["bed.foot_ce"][1] == "p > 0.5"
    assert by_id["bed.saving_best"][-1] == "contradicted"
    assert by_id["sim2.pred1"][1] == "–"


def test_the_verdicts_are_counted() -> None:
    counts = {wanted: sum(item.verdict == wanted for item in results()) for wanted in VERDICTS}
    assert sum(counts.values()) == len(results())
    for wanted, count in counts.items():
        assert f"{count} {wanted}" in verdict_counts(results())
    assert verdict_counts(results()) in results_table(results()).caption
