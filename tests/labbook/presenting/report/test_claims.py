"""What page one opens with: claims on joules and on apex heights, each over all groups or group by group."""

from __future__ import annotations

from pathlib import Path

from labbook.actions.report_command import state_report
from tests.helpers.books import ADA, ingest_all, small_book
from tests.helpers.wording import says

DECIDED = '\n[analysis]\nunit_of_analysis = "shared_days"\napex_bounds_percent = [-3, 3]\n'


def test_joules_are_claimed_where_heights_alone_are_told_over_groups(tmp_path: Path) -> None:
    """One group claims a saving, and of heights no group has two runs of a condition on a day."""
    made = small_book(tmp_path, ingested=False)
    made.toml.write_text(made.toml.read_text() + DECIDED)
    for run in ("r004", "r006", "r012", "r014"):
        made.log(run).unlink()
    with made.open() as book:
        ingest_all(book, made.instruments)
        content = state_report(book, None, ADA, lambda _step: None).content
    (overall,) = content.overall
    assert content.overall_equivalence is not None
    assert (len(overall.scope.groups), len(content.overall_equivalence.scope.groups)) == (1, 0)
    small, large, heights = (claim.text.replace("\u00a0", " ") for claim in content.claims)
    says(small, "small foot", "saved", "95 %")
    says(large, "large foot", "cannot be told")
    says(heights, "apex height", "cannot be told")
