"""Hypotheses of a book: what is compared, judged as intervals and the first page say, and traced."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats as scipy_stats

from data_schema.outcomes import Outcome
from labbook.analysis.comparison.comparisons import Compared, thesis_route
from labbook.analysis.comparison.deciding import decide_pair
from labbook.analysis.comparison.pairing import POOLED, Pair
from labbook.analysis.outcomes.conditions import ConditionValues, RunNumber
from labbook.analysis.prediction.hypotheses import Comparison, _tested
from labbook.config.model import Alternative, AnalysisSettings
from reports.numbers import Number, Result
from reports.results import Comparison as Shown
from reports.results import ConditionSummary, Decision, HypothesisPart, Verdict
from reports.tables.formats import csv_bytes
from reports.tables.registry import TABLES
from stats.compare.shared_error import SharedError
from stats.days.decision import contrast_by_day
from tests.cli.shell import Answer, good, labbook
from tests.helpers.books import SmallBook, small_book
from tests.helpers.decided import decided_book, reports
from tests.helpers.pages import quick_page
from tests.helpers.wording import says

SIMULATION = """
[simulation]
scene = "bed"
factors = { foot = "foot_radius", k_gain = "k_extension", b_ad_gain = "b_ad" }
"""
HYPOTHESES = """
[hypotheses]
foot_of_treated = { text = "AD too", claim = "same", side = "treated", between = "foot", within_percent = 0.001 }
saves = { text = "Active damping saves", claim = "saves" }
apex = { text = "It costs no height", claim = "not_lower", outcome = "apex", within_percent = 3 }
most = { text = "The small foot saves most", claim = "largest_saving", group = { foot = "small", k_gain = 400 } }
least = { text = "It saves least", claim = "smallest_saving", group = { foot = "small", k_gain = 400 } }
energy = { text = "It takes no less energy", claim = "not_lower", within_percent = 0.001 }

[hypotheses.foot_of_control]
text = "A jump of CE costs the same with either foot"
source = "thesis 3.3.1"
published = "p > .5"
claim = "same"
side = "control"
between = "foot"
levels = ["large", "small"]
within_percent = 99

[hypotheses.stiffness]
text = "Stiffness does not matter"
claim = "same"
side = "control"
between = "k_gain"
within_percent = 10
"""


def failing(answer: Answer) -> Answer:
    """One hypothesis of the book fails, that a jump takes no less energy, which the exit code says."""
    assert (answer.code, answer.err) == (1, "")
    if answer.out.startswith("{"):
        assert [one["name"] for one in answer.json["hypotheses"] if one["verdict"] == "fails"] == ["energy"]
    else:
        told = (line.partition(": ") for line in answer.out.splitlines())
        assert [text for text, _, verdict in told if verdict.startswith("fails")] == ["It takes no less energy"]
    return answer


@pytest.fixture(scope="module")
def book(tmp_path_factory: pytest.TempPathFactory) -> SmallBook:
    made = small_book(tmp_path_factory.mktemp("hypotheses"))
    made.toml.write_text(made.toml.read_text(encoding="utf-8") + SIMULATION + HYPOTHESES, encoding="utf-8")
    return made


@pytest.fixture(scope="module")
def found(book: SmallBook) -> dict[str, Any]:
    return dict(failing(labbook("compare", "--json", at=book.folder)).json)


@pytest.fixture
def compared(found: dict[str, Any]) -> dict[str, Any]:
    return {one["name"]: one for one in found["hypotheses"]}


def between(part: dict[str, Any], low: float | None, high: float | None) -> str:
    """What an interval from low to high says of the claim."""
    if low is None or high is None:
        return "cannot tell"
    above = -math.inf if part["above_percent"] is None else part["above_percent"]
    below = math.inf if part["below_percent"] is None else part["below_percent"]
    if above < low and high < below:
        return "holds"
    return "fails" if high <= above or low >= below else "cannot tell"


def test_each_comparison_is_judged_as_its_interval_says(compared: dict[str, Any]) -> None:
    for one in compared.values():
        for part in one["comparisons"]:
            measured, simulated = part["measured_percent"], part["simulated_percent"]
            if len(one["comparisons"]) == 1:
                ends = (measured.get("ci_low"), measured.get("ci_high"))
                assert part["verdict"] == between(part, *ends)
                of_savings = one["name"] in ("most", "least")
                assert measured.get("ci_level") in (None, pytest.approx(0.95 if of_savings else 0.90))
            if simulated["value"] is not None:
                half = 2.0 * simulated["se"]
                assert part["simulated_verdict"] == between(part, simulated["value"] - half, simulated["value"] + half)
        verdicts = {part["verdict"] for part in one["comparisons"]}
        expected = "fails" if "fails" in verdicts else "holds" if verdicts == {"holds"} else "cannot tell"
        assert one["verdict"] == expected
    assert {one["verdict"] for one in compared.values()} >= {"fails", "cannot tell"}


def test_what_is_compared_are_means_and_savings_of_the_runs(found: dict[str, Any], compared: dict[str, Any]) -> None:
    means = {
        (one["group"]["foot"], one["control"]): (one["measured"]["value"], one["predicted"]["value"])
        for one in found["predictions"]
        if one["quantity"] == "joules a jump" and one["level"] != "pooled"
    }
    for place, key in enumerate(("measured_percent", "simulated_percent")):
        joules = {name: both[place] for name, both in means.items()}
        (foot,) = compared["foot_of_control"]["comparisons"]
        expected = 100.0 * (joules[foot["of"]["foot"], True] / joules[foot["against"]["foot"], True] - 1.0)
        assert foot[key]["value"] == pytest.approx(expected, rel=1e-9)
        saved = {foot: 100.0 * (1.0 - joules[foot, False] / joules[foot, True]) for foot in ("small", "large")}
        by_foot = {part["of"]["foot"]: part[key]["value"] for part in compared["saves"]["comparisons"]}
        assert by_foot == pytest.approx({foot: -saving for foot, saving in saved.items()}, rel=1e-9)
        for name in ("most", "least"):
            (part,) = compared[name]["comparisons"]
            assert part[key]["value"] == pytest.approx(saved["small"] - saved["large"], rel=1e-7)


def test_what_cannot_be_compared_is_told_with_the_reason(book: SmallBook, compared: dict[str, Any]) -> None:
    """A factor of one level, feet without a day in common, and a level that was not selected."""
    assert (compared["stiffness"]["comparisons"], compared["stiffness"]["verdict"]) == ([], "cannot tell")
    (part,) = compared["foot_of_control"]["comparisons"]
    assert part["verdict"] == "cannot tell"
    assert "ci_low" not in part["measured_percent"]
    told = failing(labbook("compare", at=book.folder)).out
    says(told, "Stiffness does not matter")
    says(told, "either foot", "holds", "published")
    says(told, "either foot", "cannot tell", "no day")
    assert told.index("A jump of CE") < told.index("Energy of a jump")
    told = failing(labbook("compare", "--foot", "small", at=book.folder)).out
    says(told, "either foot", "cannot tell")
    says(told, "It costs no height", "selected runs")


def test_a_group_without_control_or_treated_runs_leaves_a_claim_about_all_untold(book: SmallBook) -> None:
    told = good(labbook("compare", "--where", "foot=small or b_ad_gain=0", at=book.folder)).out
    for text in ("Active damping saves", "It costs no height", "The small foot saves most"):
        says(told, text, "cannot tell", "missing")


NONE = Number(0.0, "1")
ALPHA = 0.05


class Run:
    """A run of one day, which is all that a contrast asks of it."""

    day = "2021-06-14"


def side(values: Any) -> tuple[ConditionValues, ...]:
    runs = tuple(RunNumber(Run(), float(value), SharedError(), Result()) for value in values)  # type: ignore[arg-type]
    return (ConditionValues("", False, {}, runs, ConditionSummary(NONE, NONE, ())),)


def test_one_of_several_comparisons_fails_only_beyond_the_interval_of_alpha_by_their_number() -> None:
    sides = (side([100.0, 104.0, 97.0, 101.0]), side([91.0, 95.0, 88.0, 94.0]))

    def judged(low: float, n_comparisons: int) -> HypothesisPart:
        return _tested(Comparison({}, {}, sides, low=low), {}, Outcome.JOULES, 0.1, n_comparisons)

    def upper_end(n_comparisons: int) -> float:
        alone = contrast_by_day(*([run.value for run in side[0].runs] for side in reversed(sides)))
        ci = alone.savings(1.0 - 0.1 / n_comparisons).ci
        assert isinstance(ci, tuple)
        return -ci[0]

    between = 0.5 * (upper_end(1) + upper_end(5))
    assert upper_end(1) < between < upper_end(5)
    assert judged(between, 1).verdict is Verdict.FAILS
    assert judged(between, 5).verdict is Verdict.CANNOT_TELL
    assert judged(upper_end(5) + 0.1, 5).verdict is Verdict.FAILS


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

[hypotheses]
saves = { text = "Active damping saves", claim = "saves" }
"""


def test_compare_judges_measured_hypotheses_without_a_scene_as_the_report_does(tmp_path: Path) -> None:
    book = decided_book(tmp_path, PLAN)
    compared = labbook("compare", "--json", at=book.folder)
    assert compared.code in (0, 1)
    (saves,) = compared.json["hypotheses"]
    assert compared.json["predictions"] == []
    assert [part["simulated_percent"]["value"] for part in saves["comparisons"]] == [None, None]
    page = quick_page(reports(book).results)
    says(page, "Active damping saves", saves["verdict"])
    says(page, "one-sided p", "90 % CI")
    says(labbook("compare", at=book.folder).out, "Active damping saves", saves["verdict"])
    says(labbook("analysis", at=book.folder).out, "one-sided")


def test_a_report_has_them_as_tables_whose_numbers_are_traced(book: SmallBook, compared: dict[str, Any]) -> None:
    content = reports(book).results
    page = quick_page(content)
    assert page.index("Hypotheses of the study") < page.index("Hypotheses, comparison by comparison")
    table = csv_bytes(TABLES["hypotheses_in_full"].make(content)).decode()
    rows = list(csv.DictReader(table.splitlines()))
    assert len(rows) == sum(len(one["comparisons"]) for one in compared.values())
    assert [row["verdict"] for row in rows] == [p["verdict"] for one in compared.values() for p in one["comparisons"]]
    checked = good(labbook("why", rows[0]["provenance"], "--check", at=book.folder)).out
    assert "hypothesis" in checked
