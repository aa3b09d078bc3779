"""By day a report and `labbook stats blocked` state one test: the exact one where the design is balanced."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import pytest

from data_schema.outcomes import Outcome
from labbook.book.opening import opened
from labbook.presenting.report.content import make_report
from reports.content import Comparison, ReportContent
from tests.cli.shell import good, labbook
from tests.helpers.books import SmallBook, small_book
from tests.helpers.pages import quick_page
from tests.helpers.wording import says

BALANCED, UNBALANCED = "foot=small", "foot=small and run!=r006 and run!=r010"
"""Two days with two runs of each side, whose joules show no variance between days; a run less on each side."""


@dataclass(frozen=True)
class ObservationRequest:
    """A report of a selection, and what `stats blocked` says of it."""

    content: ReportContent
    blocked: Any

    @property
    def joules(self) -> Comparison:
        (found,) = [c for c in self.content.comparisons if c.quantity is Outcome.JOULES and c.level != "pooled"]
        return found


@pytest.fixture(scope="module")
def book(tmp_path_factory: pytest.TempPathFactory) -> SmallBook:
    return small_book(tmp_path_factory.mktemp("leading"))


def asked(book: SmallBook, where: str) -> ObservationRequest:
    with opened(book.folder) as opened_book, opened_book.reading() as connection:
        made = make_report(
            connection, opened_book.store, opened_book.configuration, where=where, made_at="2021-07-01T12:00:00Z"
        )
    found = good(labbook("stats", "blocked", "--where", where, "--json", at=book.folder)).json
    return ObservationRequest(made.content, found["blocked"])


def test_the_exact_test_leads_where_the_design_is_balanced_and_days_show_no_variance(book: SmallBook) -> None:
    found = asked(book, BALANCED)
    by_day = found.joules.by_day
    assert by_day is not None
    assert found.blocked["day_variance"] == by_day.day_sd.value == 0.0
    (exact,), (model,) = found.blocked["contrasts"], found.blocked["mixed"]["contrasts"]
    assert [by_day.test.statistic, *by_day.test.df, by_day.test.p] == [exact["t"], exact["df"], exact["p"]]
    assert [by_day.difference.ci_low, by_day.difference.ci_high] == exact["interval"]
    assert (exact["df"], model["df"]) == (5.0, pytest.approx(6.0))
    assert by_day.test.p != pytest.approx(model["p"], rel=0.1)


def test_claims_table_and_methods_name_the_exact_test(book: SmallBook) -> None:
    found = asked(book, BALANCED)
    by_day = found.joules.by_day
    assert by_day is not None
    says(by_day.method, "day held fixed")
    methods = " ".join((*found.content.methods, found.content.tests_beside)).replace("\u00a0", " ")
    says(methods, "(1 | day)", "4 comparisons")
    says(methods, "exact test stands")
    assert "REML" not in methods
    after = quick_page(found.content).partition("The comparisons of joules a jump with the control by day")[2]
    assert "exact test" in after


def test_the_mixed_model_leads_elsewhere_and_is_named(book: SmallBook) -> None:
    found = asked(book, UNBALANCED)
    by_day = found.joules.by_day
    assert by_day is not None
    (model,) = found.blocked["contrasts"]
    assert by_day.method == "mixed model"
    assert by_day.difference.value == model["difference"]
    assert found.blocked["exact"]["balanced"] is False
    methods = " ".join((*found.content.methods, found.content.tests_beside)).replace("\u00a0", " ")
    says(methods, "4 comparisons", "REML")
    assert "exact" not in methods
