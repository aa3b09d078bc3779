"""Hypotheses of a book: what is compared, judged as intervals say, on measured and on simulated data, and traced."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow
from labbook.actions.report_command import state_report
from labbook.analysis.outcomes.conditions import ConditionSummary, ConditionValues, RunNumber
from labbook.analysis.prediction.hypotheses import Comparison, _tested
from reports.numbers import Number, Result
from reports.predicted import HypothesisPart, Verdict
from reports.tables.formats.as_csv import csv_bytes
from reports.tables.registry import TABLES
from stats.compare.shared_error import SharedError
from stats.days.decision import contrast_by_day
from tests.cli.shell import Answer, good, labbook
from tests.helpers.books import ADA, SmallBook, small_book
from tests.helpers.pages import quick_page
from tests.helpers.wording import says

SIMULATION = """
[simulation]
scene = "bed"
factors = { foot = "foot_radius", k_gain = "k_extension", b_ad_gain = "b_ad" }
"""
HYPOTHESES = """
[hypotheses.foot_of_control]
text = "A jump of CE costs the same with either foot"
source = "thesis 3.3.1"
published = "p > .5"
claim = "same"
side = "control"
between = "foot"
levels = ["large", "small"]
within_percent = 99

[hypotheses.foot_of_treated]
text = "So does one of active damping"
claim = "same"
side = "treated"
between = "foot"
within_percent = 0.001

[hypotheses.apex_of_feet]
text = "Both feet jump as high"
claim = "same"
side = "treated"
outcome = "apex"
between = "foot"
within_percent = 0.001

[hypotheses.saves]
text = "Active damping saves"
claim = "saves"

[hypotheses.apex]
text = "It costs no height"
claim = "not_lower"
outcome = "apex"
within_percent = 3

[hypotheses.most]
text = "The small foot saves most"
claim = "largest_saving"
group = { foot = "small", k_gain = 400 }

[hypotheses.least]
text = "The small foot saves least"
claim = "smallest_saving"
group = { foot = "small", k_gain = 400 }

[hypotheses.energy]
text = "It takes no less energy"
claim = "not_lower"
within_percent = 0.001

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
def compared(book: SmallBook) -> dict[str, Any]:
    found = failing(labbook("compare", "--json", at=book.folder)).json
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


def test_what_is_compared_are_means_and_savings_of_the_runs(book: SmallBook, compared: dict[str, Any]) -> None:
    found = failing(labbook("compare", "--json", at=book.folder)).json
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


@pytest.mark.soak
def test_a_factor_of_one_level_tells_nothing_and_is_said(book: SmallBook, compared: dict[str, Any]) -> None:
    assert compared["stiffness"]["comparisons"] == []
    assert compared["stiffness"]["verdict"] == "cannot tell"
    told = failing(labbook("compare", at=book.folder)).out
    says(told, "Stiffness does not matter")
    says(told, "either foot", "holds", "published")
    assert told.index("A jump of CE") < told.index("Energy of a jump")


@pytest.mark.soak
def test_a_level_that_was_not_selected_is_not_told_and_a_selection_is_said(book: SmallBook) -> None:
    told = failing(labbook("compare", "--foot", "small", at=book.folder)).out
    says(told, "either foot", "cannot tell")
    says(told, "It costs no height", "selected runs")


def test_a_group_without_control_or_treated_runs_leaves_a_claim_about_all_untold(book: SmallBook) -> None:
    told = good(labbook("compare", "--where", "foot=small or b_ad_gain=0", at=book.folder)).out
    for text in ("Active damping saves", "It costs no height", "The small foot saves most"):
        says(told, text, "cannot tell", "missing")


def conditions_of(*values: float) -> tuple[ConditionValues, ...]:
    """One condition whose runs have these values."""
    none = Number(0.0, "1")
    runs = tuple(
        RunNumber(cast(RunRow, SimpleNamespace(day="2021-06-14")), value, SharedError(), Result()) for value in values
    )
    return (ConditionValues("", False, {}, runs, ConditionSummary(none, none, ())),)


def test_one_of_several_comparisons_fails_only_beyond_the_interval_of_alpha_by_their_number() -> None:
    sides = (conditions_of(100.0, 104.0, 97.0, 101.0), conditions_of(91.0, 95.0, 88.0, 94.0))

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


def test_a_hypothesis_that_fails_is_one_for_scripts_to_see(book: SmallBook, compared: dict[str, Any]) -> None:
    failing(labbook("compare", at=book.folder))
    assert compared["energy"]["verdict"] == "fails"


@pytest.mark.soak
def test_feet_without_a_day_in_common_cannot_be_compared_and_the_reason_is_said(tmp_path: Path) -> None:
    own = small_book(tmp_path)
    text = own.toml.read_text(encoding="utf-8") + SIMULATION + HYPOTHESES
    own.toml.write_text(text, encoding="utf-8")
    found = {one["name"]: one for one in failing(labbook("compare", "--json", at=own.folder)).json["hypotheses"]}
    (part,) = found["foot_of_control"]["comparisons"]
    assert part["verdict"] == "cannot tell"
    assert "ci_low" not in part["measured_percent"]
    says(failing(labbook("compare", at=own.folder)).out, "either foot", "cannot tell", "no day")


def test_a_report_has_them_as_tables_whose_numbers_are_traced(book: SmallBook, compared: dict[str, Any]) -> None:
    with book.open() as standing:
        content = state_report(standing, None, ADA, lambda _step: None).content
    page = quick_page(content)
    assert page.index("Hypotheses of the study") < page.index("Hypotheses, comparison by comparison")
    table = csv_bytes(TABLES["hypotheses_in_full"].make(content)).decode()
    rows = list(csv.DictReader(table.splitlines()))
    assert len(rows) == sum(len(one["comparisons"]) for one in compared.values())
    assert [row["verdict"] for row in rows] == [p["verdict"] for one in compared.values() for p in one["comparisons"]]
    checked = good(labbook("why", rows[0]["provenance"], "--check", at=book.folder)).out
    assert "hypothesis" in checked
