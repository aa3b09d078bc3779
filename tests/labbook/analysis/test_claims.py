"""What page one opens with: claims on joules and on apex heights, each over all groups or group by group."""

from __future__ import annotations

from pathlib import Path

import pytest

from data_schema.outcomes import Outcome
from labbook.analysis.comparison.pairing import EACH
from tests.helpers.books import ingest_all, small_book
from tests.helpers.charged_book import Made, charged_book
from tests.helpers.decided import decided_book, reports
from tests.helpers.wording import says

EACH_LEVEL = '\n[analysis]\nfamily = "each"\n'


def test_joules_are_claimed_where_heights_alone_are_told_over_groups(tmp_path: Path) -> None:
    """One group claims a saving, and of heights no group has two runs of a condition on a day."""
    made = small_book(tmp_path, ingested=False)
    made.toml.write_text(made.toml.read_text() + "\n[analysis]\napex_bounds_percent = [-3, 3]\n")
    for run in ("r004", "r006", "r012", "r014"):
        made.log(run).unlink()
    with made.open() as book:
        ingest_all(book, made.instruments)
    content = reports(made).results
    (overall,) = content.overall
    assert content.overall_equivalence is not None
    assert (len(overall.groups), len(content.overall_equivalence.groups)) == (1, 0)
    small, large, heights = (claim.text.replace("\u00a0", " ") for claim in content.claims)
    says(small, "small foot", "95 %")
    says(large, "large foot")
    assert "95 %" not in large
    assert "CI" not in heights


def test_equal_readings_of_each_condition_have_an_effect_over_groups(tmp_path: Path) -> None:
    """Page one said that no group can be compared, above a table with the saving of each."""
    runs = [
        Made(day, foot, gain, joules - 0.1 * gain)
        for day in range(4)
        for foot, joules in (("small", 80.0), ("large", 60.0))
        for gain in (0, 100)
    ]
    content = reports(charged_book(tmp_path, runs)).results
    (overall,) = content.overall
    each = [one.decision.savings for one in content.pooled]
    assert len(overall.groups) == len(each) == 2
    assert overall.savings.known == pytest.approx(sum(one.known for one in each if one is not None and one.known) / 2)
    assert overall.savings.interval is not None
    assert overall.savings.se == 0.0
    assert overall.rejected
    says(content.claims[0].text, "2 groups", "4 days", "95 %")


def test_one_level_is_not_pooled_and_its_planned_comparison_is_shown_as_planned(tmp_path: Path) -> None:
    """With one treated level all levels against the control are the comparisons that were planned level by level."""
    book = decided_book(tmp_path, EACH_LEVEL)
    both, small = (reports(book, where).results for where in (None, "foot = small"))
    opening, *_others = both.claims
    says(opening.text, EACH, "2")
    joules, _heights = small.claims
    assert not next(item.exploratory for item in small.pooled if item.quantity is Outcome.JOULES)
    says(joules.text, "small foot")
    (pooled,) = (item for item in small.pooled if item.quantity is Outcome.JOULES)
    (each,) = (item for item in small.comparisons if item.family == EACH and item.quantity is Outcome.JOULES)
    assert pooled.decision == each.decision
    assert pooled.decision.adjusted is not None
    assert pooled.decision.adjusted.n == 2  # the other foot's, which the report does not show, counts


def test_a_page_leads_with_the_planned_levels_and_what_they_saved(tmp_path: Path) -> None:
    """Gain 100 saves nothing and gain 200 5 %: pooled, which nobody planned, that is 2.5 %."""
    scatter = (3.0, -2.0, 1.0, -2.0)
    joules = {0: (401.0, 396.0), 100: (400.0, 399.0), 200: (381.0, 379.0)}
    runs = [
        Made(day, "small", gain, value + more * (1.0 if gain else 0.5))
        for day, more in enumerate(scatter)
        for gain, values in joules.items()
        for value in values
    ]
    content = reports(charged_book(tmp_path, runs, EACH_LEVEL)).results
    lead, pooled = (claim.text.replace("\u00a0", " ") for claim in content.claims)
    says(lead, "1 of 2", "gain 200", "4.")
    says(pooled, "2.2")
    assert all(each.exploratory for each in content.pooled)


@pytest.mark.parametrize("small_days", [4, 1])
def test_the_charge_that_costs_a_group_its_claim_is_named(tmp_path: Path, small_days: int) -> None:
    """The large foot has one control run a day, and another on the last without a charge; a third is of a lone day."""
    runs = [
        Made(day, "small", gain, 400.0 + 3 * day + 2 * at - gain / 5)
        for day in range(small_days)
        for gain, several in ((0, small_days > 1), (100, True))
        for at in range(1 + several)
    ]
    runs += [Made(day, "large", gain, 401.0 + 2 * day - gain / 5) for day in range(3) for gain in (0, 100, 100)]
    missing, alone = len(runs) + 1, len(runs) + 2
    runs += [Made(2, "large", 0, None), Made(5, "large", 0, None)]
    content = reports(charged_book(tmp_path, runs)).results
    claim = content.claims[0 if small_days == 1 else 1].text.replace("\u00a0", " ")
    says(claim, f"r{missing:03d}", "large foot")
    assert f"r{alone:03d}" not in " ".join(each.text for each in content.claims)
