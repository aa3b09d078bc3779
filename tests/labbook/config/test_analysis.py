"""`[analysis]` of labbook.toml: what it says is read, what it cannot say is refused."""

from __future__ import annotations

import pytest

from data_schema.errors import InputRefused
from data_schema.outcomes import Outcome
from data_schema.vocabulary import ReasonCode
from labbook.config.model import AnalysisSettings, Bounds, Family, UnitOfAnalysis
from labbook.config.parsing import parse_configuration
from labbook.config.template import template
from labbook.demo.files import book_toml
from labbook.demo.truth import CHAPTER_5

BARE = book_toml(CHAPTER_5, predicted=False, decided=False).decode()


def read(text: str) -> AnalysisSettings | None:
    return parse_configuration(BARE + text, "labbook.toml").analysis


def test_a_book_without_the_table_has_decided_nothing() -> None:
    assert parse_configuration(template("a study", "Ada Nwosu"), "labbook.toml").analysis is None


def test_everything_is_read() -> None:
    found = read(
        '[analysis]\nprimary_outcome = "apex"\nfamily = "each"\nalpha = 0.01\napex_bounds_m = [-0.005, 0.004]\n'
        'exclusions = ["misfire"]\nunit_of_analysis = "day"\n'
    )
    bounds = Bounds(-0.005, 0.004, percent=False)
    assert found == AnalysisSettings(Outcome.APEX, Family.EACH, 0.01, bounds, (ReasonCode.MISFIRE,), UnitOfAnalysis.DAY)


def test_the_example_of_a_new_book_can_be_taken() -> None:
    lines = template("a study", "Ada Nwosu").split("\n")
    begin = lines.index("#[analysis]")
    found = read("\n".join(lines[begin : lines.index("", begin)]).replace("#", ""))
    assert found is not None
    assert found.apex_bounds == Bounds(-3.0, 3.0, percent=True)
    assert len(found.exclusions) == 5


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('primary_outcome = "joule"', "did you mean 'joules'?"),
        ("alpha = 0.7", "0.7 is no level of a test: write one below 0.5"),
        ("apex_bounds_m = [0.001, 0.005]", "are no bounds round no difference"),
        ("apex_bounds_m = [-0.005]", "are no bounds round no difference"),
        ("apex_bounds_m = [-1, 1]\napex_bounds_percent = [-3, 3]", "leave one of the two out"),
        ('exclusions = ["bad_day"]', "'bad_day' is no reason: write of dropped_packet"),
        ("aplha = 0.05", "did you mean 'alpha'?"),
    ],
)
def test_what_has_no_meaning_is_refused_with_what_has(text: str, said: str) -> None:
    with pytest.raises(InputRefused, match=r"(?s).*") as refused:
        read(f"[analysis]\n{text}\n")
    assert said in str(refused.value)
