"""Where groups had one day each no p over runs is left to stand for evidence: a sentence beside it says so."""

from __future__ import annotations

from pathlib import Path

import pytest

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from labbook.actions.report_command import state_report
from labbook.presenting.report.campaign import confounded_with_day
from labbook.presenting.report.content import MadeReport
from labbook.presenting.report.day_layout import one_day_each
from reports.remarks import FOOTNOTE
from reports.tables.formats.as_csv import csv_bytes
from reports.tables.registry import TABLES
from tests.helpers.books import ADA, DAYS, ingest_all, small_book
from tests.helpers.pages import quick_page
from tests.helpers.wording import says
from tests.labbook.conftest import Reports

FIRST, SECOND = DAYS
APART = f"b_ad_gain == 0 and day == {FIRST} or b_ad_gain == 100 and day == {SECOND}"
SAID = (
    "the treatment and the control were measured on one day each, and not the same one, so that a p or an interval "
    "that counts runs cannot tell a difference between them from a difference between their days"
)


@pytest.mark.parametrize(
    ("days", "said"),
    [
        ({"b": {"mon"}, "a": {"tue"}}, "b and a were measured on one day each, and not the same one, so that a p"),
        ({"b": {"mon"}, "a": {"mon"}}, ""),  # one day for all: runs differ as runs do
        ({"b": {"mon", "tue"}, "a": {"wed"}}, ""),  # how days differ is measured, if badly
        ({"b": {"mon"}, "a": {"mon", "tue"}}, ""),
        ({"a": {"mon"}}, ""),
        ({}, ""),
        ({"c": {"mon"}, "b": {"tue"}, "a": {"tue"}}, "c, b and a were measured on one day each, and not all the same"),
    ],
)
def test_only_days_that_nothing_measures_are_said(days: dict[str, set[str]], said: str) -> None:
    assert bool(one_day_each(days)) == bool(said)
    assert one_day_each(days).startswith(said)


@pytest.fixture(scope="module")
def confounded(tmp_path_factory: pytest.TempPathFactory) -> MadeReport:
    """A report in which the control had one day and active damping the other; the large foot has a run a side."""
    book = small_book(tmp_path_factory.mktemp("confounded"))
    book.toml.write_text(
        f'{book.toml.read_text()}\n[analysis]\nunit_of_analysis = "run"\napex_bounds_m = [-0.03, 0.03]\n'
    )
    with book.open() as opened:
        return state_report(opened, APART, ADA, lambda _step: None)


def test_every_test_on_runs_says_that_it_cannot_tell_the_treatment_from_the_day(confounded: MadeReport) -> None:
    content = confounded.content
    tested = [c for c in (*content.comparisons, *content.jump_comparisons) if not isinstance(c.test.p, Undefined)]
    assert {c.quantity for c in tested} == {Outcome.JOULES, Outcome.APEX}
    assert {c.one_day_each for c in tested} == {SAID}
    assert {c.one_day_each for c in content.comparisons if isinstance(c.test.p, Undefined)} == {""}
    assert all(isinstance(c.test.statistic, float) for c in tested)  # the thesis's own route is there to be compared


def test_claims_of_the_page_do_not_take_days_for_the_treatment(confounded: MadeReport) -> None:
    saved, _in_full, _of_one_run, height, _of_one_run_too = (claim.text for claim in confounded.content.claims)
    says(saved, "No saving with")
    says(height, "difference between days")
    says(height, "difference between days", "90")
    for text in (saved, height):
        assert "measured on one" not in text


def test_page_one_says_that_runs_of_different_days_were_compared(confounded: MadeReport) -> None:
    says(confounded.content.different_days, "plan counts runs", "0 of")
    page = quick_page(confounded.content)
    assert page.index("runs of different days") < page.index("Limitations")


def test_what_days_leave_untold_is_said_once_after_the_first_claim(confounded: MadeReport) -> None:
    content, in_full = confounded.content, "the groups were measured on one day each, and not all on the same one"
    second = content.claims[1].text.replace("\u00a0", " ")
    says(second, "4 comparisons", "2 tests", in_full, "or an interval")
    page = quick_page(content)
    assert page.count("measured on one") == 1
    assert "Conditions and days" not in page
    assert content.order.sentences == ()
    tables = [kind.make(content) for kind in TABLES.values()]
    marked = {table.name for table in tables if FOOTNOTE in table.footnotes}
    over_runs = {"headlines", "comparisons_joules", "comparisons_apex", "equivalence", "tests_joules", "tests_apex"}
    assert marked == over_runs | {"tests_jumps", "by_day_joules", "by_day_apex"}
    assert FOOTNOTE in page
    assert f"undefined: {FOOTNOTE}" not in "".join(TABLES["headlines"].make(content).explained.values())
    assert f'"{SAID}"' in csv_bytes(TABLES["comparisons_joules"].make(content)).decode()


@pytest.mark.soak
def test_a_family_of_levels_says_how_many_cannot_be_told_from_days(tmp_path: Path) -> None:
    book = small_book(tmp_path, ingested=False)
    book.toml.write_text(f'{book.toml.read_text()}\n[analysis]\nfamily = "each"\nunit_of_analysis = "run"\n')
    with book.open() as opened:
        ingest_all(opened, book.instruments)
        content = state_report(opened, APART, ADA, lambda _step: None).content
    family = content.claims[0].text.replace("\u00a0", " ")
    says(family, "2 comparisons", "1 cannot")
    says(content.claims[1].text, "groups were measured")


def test_a_factor_is_confounded_with_days_where_no_claim_says_so(confounded: MadeReport) -> None:
    (sentence,) = confounded_with_day(confounded.analysis)
    says(sentence, "the active-damping coefficient")
    assert confounded_with_day(confounded.analysis, in_claims=True) == []


@pytest.mark.soak
def test_on_shared_days_nothing_of_that_is_said(reports: Reports) -> None:
    content = reports().content
    assert {c.one_day_each for c in (*content.comparisons, *content.jump_comparisons)} == {""}
    assert {c.one_day_each for c in reports(where=f"day == {FIRST}").content.comparisons} == {""}
