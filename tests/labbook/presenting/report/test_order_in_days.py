"""Where controls come first a drift over the day passes for an effect: page one says so, and gives it adjusted."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from data_schema.outcomes import Outcome
from ingest.tables.sheet import SheetFile
from labbook.actions.report_command import state_report
from labbook.actions.runs.charges import state_charge
from labbook.actions.runs.runs_importing import import_runs
from labbook.analysis.comparison.order import ADJUSTED
from reports.content import ReportContent
from reports.trust import trust_sentences
from tests.helpers.books import ADA, small_book
from tests.helpers.pages import quick_page
from tests.helpers.wording import says

DRIFT_MAH, RUN_SD_MAH = 12.0, 4.0
SHEET = "run,date,position,kind,foot,k_gain,b_ad_gain,battery,robot,started,duration_s,jumps_made,starts,note"


def report_on(
    folder: Path, order: str, feet: tuple[str, ...] = ("small",), analysis: str = "", days: int = 5
) -> ReportContent:
    """Report on days of c(ontrol) and t(reated) runs with each foot, which differ by a drift over the day alone."""
    rng = random.Random(5)
    rows, charges = [SHEET], {}
    made = small_book(folder, runs=False, ingested=False)
    if analysis:
        made.toml.write_text(f"{made.toml.read_text()}\n[analysis]\n{analysis}\n")
    for day in range(1, days + 1):
        slots = [(foot, gain) for gain in order for foot in feet]
        for place, (foot, gain) in enumerate([*slots, ("", "idle")], start=1):
            name = f"r{len(rows):03d}"
            cells = f"jumps,{foot},400,{0 if gain == 'c' else 100}" if gain != "idle" else "idle,,,"
            minutes, jumps = (12, 3) if gain != "idle" else (10 * day, 0)
            rows.append(
                f"{name},2021-06-{day:02d},{place},{cells},A,hopper,{7 + place // 2:02d}:{30 * (place % 2):02d},"
                f"{60 * minutes},{jumps},1,"
            )
            drift = DRIFT_MAH * place / len(slots) + rng.gauss(0.0, RUN_SD_MAH) if jumps else rng.gauss(0.0, 0.2)
            charges[name] = round(2.0 * minutes + (200.0 if jumps else 0.0) + drift, 2)
    with made.open() as book:
        with book.session(ADA) as session:
            import_runs(book, session, SheetFile("runs.csv", "\n".join([*rows, ""]).encode()))
        for name, charge_mah in charges.items():
            with book.session(ADA) as session:
                state_charge(session, book.configuration, name, charge_mah, None, None)
        return state_report(book, None, ADA, lambda _step: None).content


def test_controls_first_are_said_on_page_one_with_the_adjusted_saving(tmp_path: Path) -> None:
    content = report_on(tmp_path, "cccttttt")
    headline = content.sensitivity[0].as_reported
    (found,) = content.favoured
    adjusted = found.adjusted[Outcome.JOULES]
    assert isinstance(headline.ci_high, float)
    assert headline.ci_high < 0.0
    assert isinstance(adjusted.ci_low, float)
    assert isinstance(adjusted.ci_high, float)
    assert adjusted.ci_low < 0.0 < adjusted.ci_high
    assert (found.control_position, found.treated_position) == (2.0, 6.0)
    assert found.p < 1e-6
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
    (variant,) = [one for one in content.sensitivity[0].variants if one.label == ADJUSTED]
    assert variant.number.value == pytest.approx(content.sensitivity[0].as_reported.value, abs=1e-9)
    assert any(ADJUSTED in one.label for each in content.sensitivity for one in each.variants)


def test_one_run_a_side_and_day_leaves_nothing_to_adjust_by(tmp_path: Path) -> None:
    content = report_on(tmp_path, "ct", days=6)
    (found,) = content.favoured
    assert found.p == pytest.approx(2 / 2**6)
    assert found.adjusted == {}
    says(trust_sentences(content)[0], "1.0 against 2.0", "p = .031")
    says(trust_sentences(content)[0], "no adjusted")
    assert not any(one.label == ADJUSTED for each in content.sensitivity for one in each.variants)
