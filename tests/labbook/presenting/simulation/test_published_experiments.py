from __future__ import annotations

from dataclasses import replace

from labbook.presenting.simulation.published_experiments import document, reasons, score
from simulator.steady.published_numbers import comparisons
from tests.helpers.steady import steady_tables
from tests.helpers.wording import says


def test_every_published_number_stands_in_the_document_with_its_reason_where_it_disagrees() -> None:
    tables = steady_tables()
    compared = comparisons(tables)
    text = document(tables, compared)
    for item in compared:
        name = item.published.claim.id
        assert (f"| {name} |" in text) == (item.finding is not None)
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
    says(score(compared), "5", "11 agree", "2 more")
    says(score([item for item in compared if item.agrees]), "5 agree", "0 more")
