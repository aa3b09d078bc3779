"""Where controls come first a drift over the day passes for an effect: page one says so, and gives it adjusted."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from data_schema.outcomes import Outcome
from labbook.analysis.comparison.order import ADJUSTED
from reports.results import StudyResults
from reports.trust import trust_sentences
from tests.helpers.charged_book import Made, charged_book
from tests.helpers.decided import reports
from tests.helpers.pages import quick_page
from tests.helpers.wording import says

DRIFT_J, RUN_SD_J = 24.0, 8.0


def report_on(folder: Path, order: str, feet: tuple[str, ...] = ("small",), days: int = 5) -> StudyResults:
    """Report on days of c(ontrol) and t(reated) runs with each foot, which differ by a drift over the day alone."""
    rng = random.Random(5)
    slots = [(foot, 0 if side == "c" else 100) for side in order for foot in feet]
    runs = [
        Made(day, foot, gain, 400.0 + DRIFT_J * place / len(slots) + rng.gauss(0.0, RUN_SD_J))
        for day in range(days)
        for place, (foot, gain) in enumerate(slots)
    ]
    return reports(charged_book(folder, runs)).results


def test_controls_first_are_said_on_page_one_with_the_adjusted_saving(tmp_path: Path) -> None:
    content = report_on(tmp_path, "cccttttt")
    headline = content.pooled[0].decision.headline
    (found,) = content.favoured
    adjusted = found.adjusted[Outcome.JOULES]
    assert isinstance(headline.ci_high, float)
    assert headline.ci_high < 0.0
    assert isinstance(adjusted.ci_low, float)
    assert isinstance(adjusted.ci_high, float)
    assert adjusted.ci_low < 0.0 < adjusted.ci_high
    assert (found.positions.control, found.positions.treated) == (2.0, 6.0)
    assert found.positions.p < 1e-6
    assert adjusted.provenance in {item.id for item in content.provenance}
    said = next(each for each in trust_sentences(content) if "random order" in each)
    says(said, "2.0 against 6.0", "p < .001", "saving")
    assert said.replace("<", "&lt;") in quick_page(content)


def test_over_groups_the_adjusted_effect_over_all_is_given(tmp_path: Path) -> None:
    content = report_on(tmp_path, "ccttt", ("small", "large"))
    (found,) = content.favoured
    adjusted = found.adjusted[Outcome.JOULES]
    assert found.group is None
    assert isinstance(adjusted.ci_low, float)
    assert isinstance(adjusted.ci_high, float)
    assert adjusted.ci_low < 0.0 < adjusted.ci_high
    assert content.overall[0].rejected


def test_a_balanced_order_is_not_warned_of_and_robustness_has_the_adjusted_saving(tmp_path: Path) -> None:
    content = report_on(tmp_path, "tcttcttct")
    assert content.favoured == ()
    assert not any("random order" in each for each in trust_sentences(content))
    headline, varied = content.headlines[0]
    (adjusted,) = [one for one in varied if one.variant == ADJUSTED]
    assert adjusted.result.headline.value == pytest.approx(headline.decision.headline.value, abs=1e-9)


def test_one_run_a_side_and_day_leaves_nothing_to_adjust_by(tmp_path: Path) -> None:
    content = report_on(tmp_path, "ct", days=6)
    (found,) = content.favoured
    assert found.positions.p == pytest.approx(2 / 2**6)
    assert found.adjusted == {}
    says(trust_sentences(content)[0], "1.0 against 2.0", "p = .031")
    says(trust_sentences(content)[0], "no adjusted")
    assert not any(one.variant == ADJUSTED for one in content.variations)
