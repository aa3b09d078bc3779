"""The first page's claim that a treatment saves and the hypothesis that it does: one question, one answer."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats as scipy_stats

from data_schema.outcomes import Outcome
from labbook.analysis.comparison.comparisons import Compared
from labbook.analysis.comparison.deciding import decide_pair
from labbook.analysis.comparison.pairing import POOLED, Pair
from labbook.analysis.comparison.thesis_route import thesis_route
from labbook.analysis.outcomes.conditions import ConditionSummary, ConditionValues, RunNumber
from labbook.analysis.prediction.hypotheses import Comparison, _tested
from labbook.config.model import Alternative, AnalysisSettings
from reports.evidence import Comparison as Shown
from reports.evidence import Decision
from reports.numbers import Number, Result
from reports.predicted import HypothesisPart, Verdict
from stats.compare.shared_error import SharedError
from tests.cli.shell import labbook
from tests.helpers.books import SmallBook, small_book
from tests.helpers.wording import says

NONE = Number(0.0, "1")
ALPHA = 0.05


class Run:
    """A run of one day, which is all that a contrast asks of it."""

    day = "2021-06-14"


def side(values: Any) -> tuple[ConditionValues, ...]:
    runs = tuple(RunNumber(Run(), float(value), SharedError(), Result()) for value in values)  # type: ignore[arg-type]
    return (ConditionValues("", False, {}, runs, ConditionSummary(NONE, NONE, ())),)


def answers(control: Any, treated: Any, *, one_sided: bool) -> tuple[Decision, HypothesisPart]:
    """The comparison as the first page has it, and what comes of the hypothesis that the treatment saves."""
    pair = Pair(POOLED, "g", {}, "pooled", side(control), side(treated))
    settings = AnalysisSettings(alternative=Alternative.ONE_SIDED if one_sided else Alternative.TWO_SIDED)
    decision = decide_pair(pair, Outcome.JOULES, settings)
    shown = Shown("g", Outcome.JOULES, {}, "pooled", POOLED, decision, thesis_route([], [], "J", ALPHA))
    asked = Comparison({}, {}, (pair.a, pair.b), high=0.0)
    return decision, _tested(asked, {}, Outcome.JOULES, settings.outside, 1, Compared(pair, shown, None))


CONTROL, TREATED = [100.0, 104.0, 97.0, 101.0, 99.0], [96.2, 100.2, 93.7, 96.2, 94.9]


def test_a_saving_that_is_not_significant_does_not_hold_and_one_side_has_half_the_p() -> None:
    both, one = (answers(CONTROL, TREATED, one_sided=sided) for sided in (False, True))
    p_both, p_one = (found[0].p.value for found in (both, one))
    t = scipy_stats.ttest_ind(TREATED, CONTROL, equal_var=True).statistic  # n equal: t is Welch's, df the smaller
    assert p_both == pytest.approx(2.0 * scipy_stats.t.sf(-t, 4), rel=1e-9)
    assert p_one == pytest.approx(0.5 * p_both, rel=1e-9)
    assert p_one < ALPHA < p_both
    assert (both[1].verdict, one[1].verdict) == (Verdict.CANNOT_TELL, Verdict.HOLDS)
    assert (both[1].measured.ci_level, one[1].measured.ci_level) == pytest.approx((0.95, 0.90))


@pytest.mark.parametrize("one_sided", [False, True])
def test_claim_interval_and_hypothesis_agree_whatever_was_measured(one_sided: bool) -> None:
    rng, seen = np.random.default_rng(46), set()
    for _ in range(300):
        effect = rng.choice([-8.0, -3.0, 0.0, 3.0, 8.0])
        found, verdict = answers(rng.normal(100.0, 3.0, 5), rng.normal(100.0 - effect, 3.0, 6), one_sided=one_sided)
        saving = found.savings
        assert saving is not None and isinstance(saving.value, float) and isinstance(saving.ci_low, float)  # noqa: PT018
        assert isinstance(saving.ci_high, float)
        seen.add(verdict.verdict)
        holds = found.rejected and saving.value > 0.0
        assert (verdict.verdict is Verdict.HOLDS) is holds
        assert holds is (saving.ci_low > 0.0)
        assert (verdict.verdict is Verdict.FAILS) is (saving.ci_high < 0.0)
        assert (verdict.measured.ci_low, verdict.measured.ci_high) == (-saving.ci_high, -saving.ci_low)
    assert seen == set(Verdict)


PLAN = """
[analysis]
alternative = "one-sided"

[hypotheses.saves]
text = "Active damping saves"
claim = "saves"
"""


@pytest.fixture(scope="module")
def book(tmp_path_factory: pytest.TempPathFactory) -> SmallBook:
    made = small_book(tmp_path_factory.mktemp("one_answer"), ingested=False)
    made.toml.write_text(made.toml.read_text(encoding="utf-8") + PLAN, encoding="utf-8")
    assert (
        labbook("ingest", str(made.instruments / "logs"), str(made.instruments / "charger"), at=made.folder).code == 0
    )
    return made


def test_compare_judges_measured_hypotheses_without_a_scene_as_the_report_does(book: SmallBook, tmp_path: Path) -> None:
    compared = labbook("compare", "--json", at=book.folder)
    assert compared.code in (0, 1)
    (saves,) = compared.json["hypotheses"]
    assert compared.json["predictions"] == []
    assert [part["simulated_percent"]["value"] for part in saves["comparisons"]] == [None, None]
    made = labbook("report", "--out", str(tmp_path / "report"), at=book.folder)
    assert made.code == 0
    page = (tmp_path / "report" / "report.html").read_text(encoding="utf-8")
    says(page, "Active damping saves", saves["verdict"])
    says(page, "one-sided p", "90 % CI")
    says(labbook("compare", at=book.folder).out, "Active damping saves", saves["verdict"])
    said = labbook("analysis", at=book.folder).out
    says(said, "one-sided")
