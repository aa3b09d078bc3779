"""Which look at the data a report is: made before on fewer runs, planned, and at which level."""

from __future__ import annotations

from pathlib import Path

import pytest

from data_schema.outcomes import Outcome
from labbook.analysis.preregistration.looks import look_at
from reports.results import StudyResults
from reports.trust import trust_sentences
from tests.cli.shell import good, labbook
from tests.helpers.books import DAYS, SmallBook, small_book
from tests.helpers.decided import reports
from tests.helpers.wording import says

FIRST = [f"r{number:03}" for number in range(1, 9)]
PLAN = "\n[analysis]\napex_bounds_percent = [-3, 3]\n"


@pytest.fixture
def book(tmp_path: Path) -> SmallBook:
    """A book whose runs are stated and not measured."""
    made = small_book(tmp_path, ingested=False)
    made.toml.write_text(made.toml.read_text(encoding="utf-8") + PLAN, encoding="utf-8")
    return made


def measure(book: SmallBook, day: int) -> None:
    logs = sorted((book.instruments / "logs").glob("*.csv"))
    of_day = [log for log in logs if (log.stem in FIRST) is (day == 0)]
    good(labbook("ingest", *of_day, book.instruments / "charger" / f"{DAYS[day]}.csv", at=book.folder))


def report(book: SmallBook, where: str | None = None) -> StudyResults:
    return reports(book, where).results


def levels(content: StudyResults) -> list[float]:
    """The level of the interval of each group's difference that has one."""
    found = [each.decision.difference for each in content.pooled if each.quantity is Outcome.APEX]
    return [each.ci_level for each in found if isinstance(each.ci_low, float)]


def test_a_look_is_a_report_on_fewer_runs_and_one_report_says_nothing(book: SmallBook) -> None:
    measure(book, 0)
    assert report(book).plan.look is None
    again = report(book).plan.look
    assert again is None or (again.number, again.planned) == (1, 1)
    measure(book, 1)
    second = report(book)
    assert second.plan.look is not None
    assert (second.plan.look.number, second.plan.look.planned, second.plan.look.level) == (2, 1, 0.05)
    assert second.plan.look.share_in_error == pytest.approx(0.083, abs=0.001)
    says(" ".join(trust_sentences(second)), "look 2", "planned for one", "8.3 %")
    third = report(book)
    assert third.plan.look == second.plan.look


def test_one_report_of_all_runs_and_groups_after_each_other_are_no_further_looks(book: SmallBook) -> None:
    measure(book, 0)
    measure(book, 1)
    report(book, "foot=small")
    large = report(book, "foot=large")
    assert large.plan.look is not None
    assert not large.plan.look.unplanned
    assert not any("look" in sentence for sentence in trust_sentences(large))


def test_planned_looks_are_kept_to_by_tests_and_intervals(book: SmallBook) -> None:
    planned = good(labbook("plan", "--seed", "7", "--n", "3", "--looks", "2", "--json", at=book.folder)).json
    first, last = (look_at([6, 12][:n], planned=2, runs_planned=12).level for n in (1, 2))
    assert planned["looks"] == [{"runs": 6, "level": pytest.approx(first)}, {"runs": 12, "level": pytest.approx(last)}]
    measure(book, 0)
    content = report(book)
    look = content.plan.look
    assert look is not None
    assert (look.number, look.planned, look.runs, look.runs_planned) == (1, 2, 6, 12)
    assert look.level == pytest.approx(first)
    assert levels(content) == [pytest.approx(1.0 - first)]
    heights = [each.decision.equivalence for each in content.pooled if each.decision.equivalence is not None]
    assert any(item.estimate.ci_level == pytest.approx(1.0 - 2.0 * first) for item in heights)
    says(" ".join(trust_sentences(content)), "look 1 of 2", "6 of 12", "5 %")
    says(" ".join(content.plan.decided), "alpha 0.05", "2 looks")
    measure(book, 1)
    final = report(book)
    assert final.plan.look is not None
    assert final.plan.look.level == pytest.approx(last)
    assert not final.plan.look.unplanned
    assert levels(final) == [pytest.approx(1.0 - last)]
    refused = labbook("plan", "--seed", "8", "--n", "2", "--looks", "3", "--out", "further.csv", at=book.folder)
    assert refused.code == 2
    says(refused.err, "before the first measurement")
    assert report(book).plan.look == final.plan.look
