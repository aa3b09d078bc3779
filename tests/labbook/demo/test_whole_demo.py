"""A campaign (more in a soak) through files, database and report: what was drawn is reported, its ground found."""

from __future__ import annotations

import csv
import json
import random
import re
from pathlib import Path

import numpy as np
import pytest

from data_schema.outcomes import Outcome
from data_schema.queries.history import list_reports
from data_schema.vocabulary import RunKind
from labbook.actions.simulate.calibrating import calibrate_book
from labbook.actions.upkeep.tracing import ReportOfNumber, recompute
from labbook.analysis.comparison.pairing import POOLED
from labbook.analysis.outcomes.run_energy import joules_per_jump
from labbook.analysis.preregistration.planned import planned_analysis
from labbook.analysis.study import Analysis, analyse
from labbook.book.opening import Book, opened
from labbook.book.report_numbers import read_numbers
from labbook.config.model import Bounds
from labbook.demo.campaign import Campaign, make_campaign
from labbook.demo.files import campaign_files
from labbook.demo.running import make_campaign_book
from labbook.demo.truth import GROUND, Condition
from stats.lines.passive_drain import PassiveDrain, fit_passive_drain
from tests.helpers.demos import CAMPAIGNS, made_demo
from tests.helpers.wording import says

JUMPS = 4
SOFT, STIFF = "small foot, k = 835 N/m", "small foot, k = 1091 N/m"
LARGE = "large foot, k = 835 N/m"
PREDICTED_J = {(SOFT, "0"): 40.391692, (STIFF, "0"): 46.233119, (STIFF, "150"): 41.639542, (LARGE, "0"): 41.620428}
PREDICTED_M = {(SOFT, "0"): 0.28553619, (STIFF, "0"): 0.31408899, (STIFF, "150"): 0.31567884, (LARGE, "0"): 0.30808764}
"""Joules a jump and apexes of the scene `bed`, by two independent implementations."""


def analysed(book: Book) -> Analysis:
    with book.reading() as connection:
        return analyse(connection, book.store, book.configuration, where=None, made_at="2026-01-01T00:00:00Z")


def joules_drawn(campaign: Campaign) -> dict[str, float]:
    idle = campaign.of_kind(RunKind.IDLE)
    drain = fit_passive_drain([run.duration_s for run in idle], [run.charge_mah for run in idle])
    assert isinstance(drain, PassiveDrain)
    voltage = campaign.truth.reference_voltage_v
    found = {}
    for run in campaign.of_kind(RunKind.JUMPS):
        value = joules_per_jump(run.charge_mah, drain.at(run.duration_s).charge_mah, voltage, run.jumps_made)
        assert isinstance(value, float)
        found[run.name] = value
    return found


@pytest.mark.soak
@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5])
def test_a_campaign_through_files_gives_what_was_drawn_and_its_ground(seed: int, tmp_path: Path) -> None:
    campaign = make_campaign(seed, runs_per_condition=1, extra_controls=4, jumps_per_run=JUMPS)
    said: list[str] = []
    folder = make_campaign_book(tmp_path / "demo", campaign_files(campaign), lambda _step: None, said.append)
    assert not any("refused" in line or "duplicate" in line for line in said), said
    check_drawn(campaign, folder)


def test_the_demonstration_gives_what_was_drawn() -> None:
    check_drawn(CAMPAIGNS["two_runs_a_condition"](), Path(made_demo("two_runs_a_condition").book))


def check_drawn(campaign: Campaign, folder: Path) -> None:
    with opened(folder) as book:
        content = analysed(book).results
        calibrated = calibrate_book(book, None, ["kg_scale"], 0.999, lambda _step: None)
    drawn = joules_drawn(campaign)
    conditions = {run.name: run.condition for run in campaign.of_kind(RunKind.JUMPS)}
    reported: dict[str, float] = {}
    for condition in content.conditions:
        label = {level.factor: level.label for level in condition.levels}
        joules = condition.summary(Outcome.JOULES)
        assert joules is not None
        for run, value in joules.runs:
            reported[run] = value
            assert conditions[run] == Condition(label["foot"], int(label["k_gain"]), int(label["b_ad_gain"]))
    assert reported == pytest.approx(drawn, rel=1e-12)

    truth = json.loads((folder.parent / "truth.json").read_text(encoding="utf-8"))
    assert truth["seed"] == campaign.seed
    apexes = {run.name: run.reached_apexes_m.mean() for run in campaign.of_kind(RunKind.JUMPS)}
    errors = [
        value - apexes[run]
        for condition in content.conditions
        if (apex := condition.summary(Outcome.APEX)) is not None
        for run, value in apex.runs
    ]
    # jumps that touch a gap are left out of a run's mean, so single runs of 4 jumps differ by the scatter of jumps
    assert abs(float(np.median(errors))) < 0.2e-3
    assert float(np.abs(errors).max()) < 6e-3
    (ground,) = calibrated.calibration.parameters
    low, high = ground.profile
    assert low is not None
    assert high is not None
    assert low < GROUND["kg_scale"] < high < low + 0.3
    misfired = sum(int(run.misfired.sum()) for run in campaign.of_kind(RunKind.JUMPS))
    assert content.flow.jumps_made - content.flow.jumps_detected <= misfired + 2
    assert content.flow.jumps_detected <= content.flow.jumps_made


NOT_RUNNING = re.compile(
    r"<(head|details|table|script|style|svg)\b(?:(?!<(?:head|details|table|script|style|svg)\b).)*?</\1>", re.DOTALL
)


@pytest.mark.parametrize(
    ("name", "most"), [("two_runs_a_condition", 1600), pytest.param("simulated", 1200, marks=pytest.mark.soak)]
)
def test_the_page_has_few_words_outside_folds_tables_and_drawings(name: str, most: int) -> None:
    """A report is read in minutes; where days are few, each sentence says besides for which it holds."""
    page, folded = Path(made_demo(name).page).read_text(encoding="utf-8"), 1
    while folded:
        page, folded = NOT_RUNNING.subn(" ", page)
    assert 500 < len(re.sub(r"<[^>]*>", " ", page).split()) <= most


def check_numbers(folder: Path, how_many: int) -> None:
    """Numbers picked at random, recomputed from raw copies and journal, are the same to the last digit."""
    with opened(folder) as book:
        with book.reading() as connection:
            report = list_reports(connection)[-1]
        numbers = read_numbers(book.store.root, report)
        picked = random.Random(17).sample(sorted(numbers.numbers.values(), key=lambda one: one.id), how_many)
        asked = [ReportOfNumber(number, numbers, (report,)) for number in picked]
        found = recompute(book, asked, lambda _step: None)
    assert [(number.anew is not None, number.differs) for number in found] == [(True, ())] * how_many


@pytest.mark.soak
def test_numbers_of_the_whole_demonstration_come_out_again() -> None:
    check_numbers(Path(made_demo("demonstration").book), how_many=500)


def test_the_demonstration_reports_and_remembers_its_correction() -> None:
    done = made_demo("two_runs_a_condition")
    correction = CAMPAIGNS["two_runs_a_condition"]().corrections[0]
    journal = [
        json.loads(line) for line in (Path(done.book) / "journal.jsonl").read_text(encoding="utf-8").splitlines()
    ]
    corrected = [entry for entry in journal if entry["action"] == "set" and entry["old"]]
    assert [entry["reason"] for entry in corrected] == [correction.why]
    assert corrected[0]["old"] != corrected[0]["new"]

    check_numbers(Path(done.book), how_many=6)
    with opened(Path(done.book)) as book, book.reading() as connection:
        planned = planned_analysis(connection, book.configuration)
    assert planned.stated
    (told,) = planned.departures  # the typing error in the run sheet is found after the files came in
    says(told, "the first measurement", correction.run)
    assert planned.exploratory(Outcome.JOULES, POOLED) is None
    assert planned.exploratory_equivalence(POOLED) is None
    assert planned.settings.apex_bounds == Bounds(-3.0, 3.0, percent=True)

    tables = Path(done.page).parent / "tables"
    for name, column, expected in (
        ("predicted_joules", "predicted_j", PREDICTED_J),
        ("predicted_apex", "predicted_m", PREDICTED_M),
    ):
        rows = csv.DictReader((tables / f"{name}.csv").read_text(encoding="utf-8").splitlines())
        found = {(row["group"].replace("\u00a0", " "), row["level"]): float(row[column]) for row in rows}
        assert len(found) > 20
        assert {where: found[where] for where in expected} == pytest.approx(expected, rel=1e-6)
