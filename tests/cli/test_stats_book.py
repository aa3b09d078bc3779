"""`labbook stats` on a book: the numbers are the report's own, and nothing is written."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from data_schema.outcomes import Outcome
from labbook.analysis.comparison import pairing
from reports.numbers import Number
from reports.results import Comparison, StudyResults
from tests.cli.shell import good, labbook, refused, unchanged
from tests.helpers.books import SmallBook, ingest_all, small_book
from tests.helpers.pages import content_of
from tests.helpers.wording import says

SMALL = ("--where", "foot=small")


@dataclass(frozen=True)
class Reported:
    """A book in which runs differ in duration, so that the drain's error does not cancel, and its report."""

    book: SmallBook
    results: StudyResults

    def comparison(self, quantity: Outcome, family: str) -> Comparison:
        (found,) = [item for item in self.results.comparisons if (item.quantity, item.family) == (quantity, family)]
        return found

    def stats(self, *words: str) -> Any:
        with unchanged(self.book.folder):
            return good(labbook("stats", *words, *SMALL, "--json", at=self.book.folder)).json


@pytest.fixture(scope="module")
def reported(tmp_path_factory: pytest.TempPathFactory) -> Reported:
    book = small_book(tmp_path_factory.mktemp("stats"))
    for run, seconds in (("r002", 1000), ("r004", 900), ("r010", 600)):
        good(labbook("correct", run, f"duration_s={seconds}", "--why", "timed by hand", at=book.folder))
    return Reported(book, content_of(book.folder, SMALL[1]))


def ends(number: Number | None) -> list[Any]:
    assert number is not None
    return [number.ci_low, number.ci_high]


@pytest.mark.parametrize(("name", "quantity"), [("joules", Outcome.JOULES), ("apex", Outcome.APEX)])
@pytest.mark.parametrize("pooled", [(), ("--pooled",)], ids=["each", "pooled"])
def test_the_route_of_the_thesis_gives_the_numbers_of_the_report(
    reported: Reported, name: str, quantity: Outcome, pooled: tuple[str, ...]
) -> None:
    found = reported.stats("compare", "--quantity", name, *pooled, "--route", "f_then_t")
    (thesis,) = found["comparisons"]
    theirs = reported.comparison(quantity, pairing.POOLED if pooled else pairing.EACH)
    route = theirs.over_runs
    assert (thesis["n_a"], thesis["n_b"]) == (route.n_treatment, route.n_control) == (4, 4)
    assert thesis["difference"] == route.difference.value
    assert thesis["difference_ci"] == ends(route.difference)
    assert [thesis["t"], thesis["df"], thesis["p"]] == [route.t.value, route.t.df, route.p.value]
    assert [thesis["f"], thesis["f_p"]] == [route.f.value, route.f_p.value]
    assert (found["unit"], found["source"]) == ("J" if name == "joules" else "m", "book")


@pytest.mark.parametrize(("name", "quantity"), [("joules", Outcome.JOULES), ("apex", Outcome.APEX)])
def test_compare_is_the_deciding_test_of_the_report(reported: Reported, name: str, quantity: Outcome) -> None:
    (mine,) = reported.stats("compare", "--quantity", name, "--pooled")["decisions"]
    theirs = reported.comparison(quantity, pairing.POOLED).decision
    assert theirs is not None
    assert (mine["rule"], mine["n_a"], mine["n_b"]) == ("within days", theirs.n_treatment, theirs.n_control)
    assert mine["days"] == [*theirs.days]
    assert [mine["t"], mine["df"], mine["p"]] == [theirs.test.statistic, *theirs.test.df, theirs.test.p]
    assert mine["difference"] == theirs.difference.value
    assert mine["difference_ci"] == ends(theirs.difference)
    if theirs.savings is not None:
        (saved,) = reported.stats("savings", "--pooled")["decisions"]
        for one in (mine, saved):
            assert [one["savings_percent"], one["savings_percent_ci"]] == [theirs.savings.value, ends(theirs.savings)]
    said = good(labbook("stats", "compare", "--quantity", name, "--pooled", *SMALL, at=reported.book.folder)).out
    says(said.splitlines()[0], "2 days", "within days")
    assert len(re.findall(r"\bp [=<>]", said)) == 1


def test_equivalence_is_the_deciding_test_of_the_report_by_the_bounds_of_the_book(tmp_path: Path) -> None:
    book = small_book(tmp_path)
    asked = ("stats", "equivalence", "--quantity", "apex")
    refused(labbook(*asked, at=book.folder), 2, "add --low and --high")
    bounded = book.toml.read_text(encoding="utf-8") + "\n[analysis]\nalpha = 0.1\napex_bounds_percent = [-4, 5]\n"
    book.toml.write_text(bounded, encoding="utf-8")
    words = (*asked, "--pooled", *SMALL)
    (mine,) = good(labbook(*words, "--json", at=book.folder)).json["decisions"]
    comparison = next(
        item for item in content_of(book.folder, SMALL[1]).comparisons if item.decision and item.decision.equivalence
    )
    decision = comparison.decision
    assert decision is not None
    theirs = decision.equivalence
    assert theirs is not None
    assert (mine["rule"], mine["days"]) == ("within days", [*decision.days])
    assert (mine["low"], mine["high"], mine["alpha"]) == (-4.0, 5.0, 0.1)
    assert [mine["estimate"], *mine["estimate_ci"]] == [theirs.estimate.value, *ends(theirs.estimate)]
    assert [mine["t_low"], mine["t_high"], mine["p"]] == [theirs.t_low.value, theirs.t_high.value, theirs.p.value]
    assert mine["equivalent"] == theirs.shown
    said = good(labbook(*words, at=book.folder)).out
    says(said, "shared days", "within days", "2 days", "-4 to 5 %", "80 %")
    metres = (*words, "--low", "-0.01", "--high", "0.02")
    says(good(labbook(*metres, at=book.folder)).out, "shared days", "-10 to 20 mm")
    (other,) = good(labbook(*words, "--low", "-0.1", "--json", at=book.folder)).json["decisions"]
    assert (other["low"], other["high"]) == (-0.1, None)
    says(other["t_high"]["reason"], "no upper bound")
    refused(labbook(*words, "--low=-5", at=book.folder), 2, "--low -5 is in metres", "write --low -0.005")


def test_a_day_of_two_feet_is_one_day(tmp_path: Path) -> None:
    book = small_book(tmp_path)
    (mine,) = good(labbook("stats", "compare", "--pooled", "--json", at=book.folder)).json["decisions"]
    assert (mine["rule"], len(mine["days"])) == ("within days", 2)


def test_other_groups_and_what_is_pooled_over_is_said(reported: Reported) -> None:
    found = good(labbook("stats", "anova", "--by", "foot", "--json", at=reported.book.folder)).json
    assert found["groups"] == {"large": 4, "small": 8}
    says(found["notes"][0], "b_ad_gain")
    by_day = ("stats", "compare", "--by", "day", "--quantity", "apex", "--json")
    assert good(labbook(*by_day, at=reported.book.folder)).json["groups"] == {"2021-06-14": 6, "2021-06-16": 6}


def test_runs_without_a_number_are_left_out_as_in_the_report_and_named(tmp_path: Path) -> None:
    book = small_book(tmp_path, ingested=False)
    good(labbook("ingest", book.instruments / "logs", at=book.folder))
    good(labbook("void", "r001", "--reason", "foot came loose", at=book.folder))
    found = good(labbook("stats", "compare", "--quantity", "apex", *SMALL, "--json", at=book.folder)).json
    assert found["groups"] == {"b_ad_gain 0": 3, "b_ad_gain 100": 4}
    refused(labbook("stats", "compare", at=book.folder), 2, "no selected run has a value of joules a jump")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--by b_ad", "'b_ad' is not a known factor or column of runs: did you mean 'b_ad_gain'?"),
        ("--quantity joule", "did you mean 'joules'?"),
        ("--control 10", "is not a known level of b_ad_gain"),
        ("--value x", "--value is about a table"),
        ("--day x", "--day is about a table"),
        ("--missing drop", "--missing is about a table"),
        ("--where b_ad_gain=0", "all values belong to one group (b_ad_gain 0)"),
        ("--route welsh", "did you mean 'welch'?"),
        ("--plot a.jpg", "--plot a.jpg does not say which form"),
    ],
)
def test_refused_with_a_sentence(reported: Reported, words: str, said: str) -> None:
    refused(labbook("stats", "compare", *words.split(), at=reported.book.folder), 2, said)


def test_away_from_a_book_a_table_is_asked_for(tmp_path: Path) -> None:
    refused(labbook("stats", "compare", at=tmp_path), 2, "there is no book")


DECIDED = '\n[analysis]\nprimary_outcome = "apex"\nalpha = 0.01\napex_bounds_percent = [-4, 5]\n'


@pytest.fixture(scope="module")
def decided(tmp_path_factory: pytest.TempPathFactory) -> SmallBook:
    """A book whose analysis was decided before the first measurement, and whose labbook.toml says otherwise now."""
    book = small_book(tmp_path_factory.mktemp("decided"), ingested=False)
    text = book.toml.read_text(encoding="utf-8")
    book.toml.write_text(text + DECIDED, encoding="utf-8")
    with book.open() as opened_book:
        ingest_all(opened_book, book.instruments)
    late = DECIDED.replace("0.01", "0.1").replace("[-4, 5]", "[-40, 50]")
    book.toml.write_text(text + late, encoding="utf-8")
    return book


def asked(book: SmallBook, *words: str) -> Any:
    return good(labbook("stats", *words, "--quantity", "apex", "--json", at=book.folder)).json


def test_what_was_stated_before_the_first_measurement_rules(decided: SmallBook) -> None:
    (equal,) = asked(decided, "equivalence", *SMALL, "--pooled")["decisions"]
    assert (equal["low"], equal["high"], equal["alpha"]) == (-4.0, 5.0, 0.01)
    assert asked(decided, "compare", *SMALL)["decisions"][0]["alpha"] == 0.01


@pytest.mark.parametrize("words", [("compare",), ("anova",), ("equivalence", "--low", "-0.002", "--high", "0.002")])
def test_people_read_heights_in_millimetres(decided: SmallBook, words: tuple[str, ...]) -> None:
    line = good(labbook("stats", *words, *SMALL, "--quantity", "apex", at=decided.folder)).out
    assert " mm" in line
    assert not re.search(r"\d m\b", "\n".join(each for each in line.splitlines() if not each.startswith("note: ")))
    assert asked(decided, *words, *SMALL)["unit"] == "m"


def test_people_read_the_reports_names_and_programs_the_books(decided: SmallBook) -> None:
    found = asked(decided, "compare", *SMALL)
    assert list(found["groups"]) == ["b_ad_gain 0", "b_ad_gain 100"]
    assert [(one["a"], one["b"]) for one in found["decisions"]] == [("b_ad_gain 100", "b_ad_gain 0")]
    for words in (("compare",), ("anova",), ("savings",), ("equivalence", "--low=-5", "--high=5")):
        told = good(labbook("stats", *words, *SMALL, at=decided.folder)).out
        says(told, "352 kg/s", "gain", "100", "CE")
        assert "b_ad_gain" not in told.split("\nnote:")[0], words
    says(good(labbook("stats", "compare", "--by", "foot", at=decided.folder)).out, "small foot minus large foot")
