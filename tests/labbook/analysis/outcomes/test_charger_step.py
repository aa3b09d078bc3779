"""The charger's step is found in the charges, and its rounding widens intervals and is said on page one."""

import math
from pathlib import Path

import pandas as pd
import pytest

from data_schema.outcomes import Outcome
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.deciding import contrast_of
from labbook.analysis.outcomes.charger_step import ROUNDING, display_step_mah, rounding_in, scatter_in_steps
from labbook.analysis.outcomes.run_energy import joules_per_mah
from labbook.analysis.study import Analysis
from reports.trust import trust_sentences
from tests.cli.shell import good, labbook
from tests.helpers.books import JUMPS, SmallBook, ingest_all, small_book
from tests.helpers.decided import reports
from tests.helpers.pages import quick_page
from tests.helpers.tomls import without
from tests.helpers.wording import says

TENS = (20.0, 30.0, 40.0, 70.0)
STATED = "charger_resolution_mah = 1\n"


@pytest.mark.parametrize(
    ("charges_mah", "typed_mah", "step_mah"),
    [
        ([*TENS, 30.0, 30.0], 1.0, 10.0),
        ([*TENS, 31.0], 1.0, 1.0),
        ([*TENS, 35.0], 1.0, 5.0),
        ([22.0, 24.0, 28.0, 36.0, 38.0, 42.0, 44.0], 1.0, 2.0),
        ([22.0, 24.0, 28.0] * 5, 1.0, 1.0),  # three different even numbers are chance
        ([30.0, 31.0, 47.0], 0.01, 1.0),  # a spreadsheet's 30.00
        ([30.1, 30.7, 47.0], 0.1, 0.1),
        ([29.97, 31.2], 1.0, 1.0),  # a log's counter, finer than its format says
        ([200.0, 300.0, 0.0], 1.0, 100.0),
        ([25.0, 75.0, 125.0, 50.0], 1.0, 25.0),
        ([30.0] * 9, 1.0, 1.0),
        ([], 1.0, 1.0),
    ],
)
def test_the_step_is_the_coarsest_that_chance_does_not_explain(
    charges_mah: list[float], typed_mah: float, step_mah: float
) -> None:
    assert display_step_mah(charges_mah, typed_mah) == pytest.approx(step_mah, rel=1e-12)


def test_scatter_is_pooled_within_conditions_and_few_days() -> None:
    joules, steps = [1.0, 3.0, 5.0, 9.0], [2.0] * 4
    assert scatter_in_steps(joules, steps, ["a", "a", "b", "b"], ["1"] * 4) == pytest.approx(math.sqrt(5.0 / 4.0))
    assert scatter_in_steps(joules, steps, ["a"] * 4, ["1", "1", "2", "2"]) == pytest.approx(math.sqrt(5.0 / 4.0))
    by_days = scatter_in_steps(joules, steps, ["a"] * 4, ["1", "2", "3", "4"])
    assert by_days == pytest.approx(math.sqrt((35.0 / 3.0) / 4.0))  # the variance of 1, 3, 5, 9
    assert scatter_in_steps(joules, steps, ["a", "b", "c", "d"], ["1"] * 4) is None


def changed(book: SmallBook, protocol: str) -> SmallBook:
    without(book.folder, STATED, protocol)
    return book


@pytest.fixture(scope="module")
def coarse(tmp_path_factory: pytest.TempPathFactory) -> Analysis:
    """A report on sheets of a charger that shows tens, with nothing said of it in labbook.toml."""
    book = changed(small_book(tmp_path_factory.mktemp("coarse"), ingested=False), "")
    for sheet in (book.instruments / "charger").iterdir():
        charges = pd.read_csv(sheet)
        charges["mAh"] = 10 * (charges["mAh"] / 10).round().astype(int)
        charges.to_csv(sheet, index=False)
    with book.open() as opened:
        ingest_all(opened, book.instruments)
    return reports(book)


def test_page_one_says_that_the_interval_of_a_coarse_charger_cannot_be_trusted(coarse: Analysis) -> None:
    found = coarse.results.coarse_charger
    assert found is not None
    assert found.step_mah == 10.0
    assert found.scatter_mah < 5.0
    says(trust_sentences(coarse.results), "cannot be trusted", "10 mAh", "longer", "meter")
    says(quick_page(coarse.results), "half", "step of 10 mAh")


def test_equal_readings_of_a_condition_have_one_error_of_rounding(coarse: Analysis) -> None:
    """Uniform, a step / sqrt(12) wide, of each side; it does not cancel in the difference."""
    conditions = coarse.measured.conditions[Outcome.JOULES]
    pair = pairing.pairs_pooled(conditions, "b_ad_gain")[0]
    contrast = contrast_of(pair)
    step_j = 10.0 * joules_per_mah(coarse.measured.evidence.study.reference_voltage_v, JUMPS)
    for condition in conditions:
        for run in condition.runs:
            assert [fit for fit, _reading in rounding_in(run.shared).terms] == [ROUNDING]
            assert rounding_in(run.shared).se == pytest.approx(step_j / math.sqrt(12.0))
    readings = {run.run.name: next(iter(rounding_in(run.shared).terms)) for side in (pair.a, pair.b)
                for condition in side for run in condition.runs}  # fmt: skip
    shared = rounding_in(contrast.shared(1.0))
    assert set(shared.terms) == set(readings.values())
    se = math.ldexp(shared.se, contrast.scale.exponent)
    assert math.sqrt(2.0 / len(readings)) < se / (step_j / math.sqrt(12.0)) <= math.sqrt(2.0)
    budget = coarse.results.budget
    assert budget is not None
    (term,) = [one for one in budget.terms if "charger" in one.name]
    assert (term.shared, term.in_scatter) == (True, False)


def test_the_step_that_labbook_toml_states_holds_for_sheets_and_a_fine_one_changes_nothing(tmp_path: Path) -> None:
    """Found in the charges or stated, the step is 1 mAh and the numbers are the same."""
    stated, found, wide = (
        reports(changed(small_book(tmp_path / name), said)).results
        for name, said in (("stated", STATED), ("found", ""), ("wide", "charger_resolution_mah = 20\n"))
    )
    assert stated.coarse_charger is found.coarse_charger is None
    savings = [[each.decision.savings for each in content.comparisons] for content in (stated, found)]
    assert savings[0] == savings[1]
    assert wide.coarse_charger is not None
    assert wide.coarse_charger.step_mah == 20.0


def test_a_charge_typed_with_decimals_is_as_fine_as_it_was_typed(tmp_path: Path) -> None:
    book = changed(small_book(tmp_path, ingested=False), "")
    good(labbook("charge", "r001", "512.5", at=book.folder))
    says(good(labbook("show", "r001", at=book.folder)).out, "512.5 mAh", "steps of 0.1")
