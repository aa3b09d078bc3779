"""A report on a part of the conditions has the adjusted p of the report on all, where the family was planned."""

from __future__ import annotations

from pathlib import Path

import pytest

from data_schema.outcomes import Outcome
from labbook.actions.report_command import state_report
from labbook.analysis.comparison.pairing import EACH, POOLED
from labbook.presenting.report.content import MadeReport
from reports.numbers import Value
from tests.helpers.books import ADA, SmallBook
from tests.helpers.decided import decided_book
from tests.helpers.wording import says


def report(made: SmallBook, where: str | None) -> MadeReport:
    with made.open() as book:
        return state_report(book, where, ADA, lambda _step: None)


def adjusted_p(made: MadeReport, quantity: Outcome, family: str) -> dict[str, tuple[Value, int | None]]:
    """Holm's p of each comparison of a family, with the number of tests that it counts."""
    found = {}
    for item in made.analysis.compared:
        adjusted = item.shown.decision.adjusted
        if (item.shown.quantity, item.pair.family) == (quantity, family) and adjusted is not None:
            found[item.pair.label] = adjusted.value, adjusted.n
    return found


@pytest.mark.parametrize(("family", "named"), [("pooled", POOLED), ("each", EACH)])
def test_a_selection_has_the_adjusted_p_of_the_whole(tmp_path: Path, family: str, named: str) -> None:
    made = decided_book(tmp_path, f'\n[analysis]\nfamily = "{family}"\n')
    whole, part = report(made, None), report(made, "foot=small")
    for quantity in (Outcome.JOULES, Outcome.APEX):
        of_whole, of_part = adjusted_p(whole, quantity, named), adjusted_p(part, quantity, named)
        assert len(of_whole) == 2
        assert len(of_part) == 1
        assert of_part.items() <= of_whole.items()
    counted = [f"2 of {quantity}" for quantity in (Outcome.JOULES, Outcome.APEX)]
    says(" ".join(whole.content.methods), *counted)
    assert "not in this" not in " ".join(whole.content.methods)
    says(" ".join(part.content.methods), *(f"{each} (1 not in this selection)" for each in counted))
    assert all("large" not in item.pair.label for item in part.analysis.compared)


@pytest.mark.soak
def test_levels_that_are_left_out_of_a_group_count_too(tmp_path: Path) -> None:
    made = decided_book(tmp_path, '\n[analysis]\nfamily = "each"\n')
    found = report(made, "foot=small or b_ad_gain=0").analysis.compared
    assert {len(item.family.rejected) for item in found if item.family is not None} == {2}


@pytest.mark.soak
def test_without_a_plan_the_family_is_what_is_compared(tmp_path: Path) -> None:
    made = decided_book(tmp_path, "")
    assert adjusted_p(report(made, "foot=small"), Outcome.JOULES, POOLED) == {}
