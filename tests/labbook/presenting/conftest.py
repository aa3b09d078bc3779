"""Books of other studies than the demonstration's: other factors, two robots, with a control level and without one.

The small book's runs and logs stand for them: the small foot for a drop of 30 cm, the large one for 45 cm, the control
gain for sand, active damping for gravel. The first day is the flea's and the second the cricket's, but for the drop of
45 cm: there the flea jumps on sand and the cricket on gravel.
"""

from __future__ import annotations

import datetime as dt
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from data_schema.vocabulary import RunKind
from labbook.actions.report_command import state_report
from labbook.book.making import make_book
from labbook.book.opening import opened
from labbook.demo.campaign import DemoRun
from labbook.demo.writers import charger_sheet, run_sheet
from labbook.presenting.report.content import MadeReport
from tests.helpers.books import ADA, DAYS, TRUTH, import_sheet, ingest_all, small_runs, write_instruments
from tests.helpers.pages import quick_page

FLEA, CRICKET = "flea", "cricket"
_HEAD = """\
[study]
name = "two surfaces"
kind = "bed"
reference_voltage_v = 15.4
jumps_nominal = 3
time_zone = "America/New_York"

[people]
"Ada Nwosu" = "AN"

[factors.surface]
kind = "label"
levels = ["sand", "gravel"]
{control}
[factors.drop_height]
kind = "number"
title = "Drop height"
unit = "cm"
levels = [30, 45]

[protocol]
run_duration_s = 720
detector = "robust"
exclude_first_jumps = 0
exclude_gap_jumps = true
charger_resolution_mah = 1
idle_minutes = [20, 30, 40, 60]
checks = ["rail_angle"]
"""
_ROBOT = """
[robots.{name}]
body_mass_kg = 1.8
foot_mass_kg = 0.2
link_1_m = 0.1
link_2_m = 0.2
rest_length_m = 0.27
leg_min_m = 0.1
leg_max_m = 0.3
"""


@dataclass(frozen=True)
class Told:
    """A study's report: its content, and its page without drawings."""

    made: MadeReport
    page: str


def _robot(run: DemoRun) -> str:
    if run.condition is not None and run.condition.foot == "large":
        return FLEA if run.condition.is_control else CRICKET
    return FLEA if run.date == DAYS[0] else CRICKET


def _runs() -> list[DemoRun]:
    """The small book's runs, with two more idle runs a day, so that each robot has a drain line."""
    made = list(small_runs())
    idle = [run for run in made if run.kind is RunKind.IDLE]
    for run in idle:
        later = dt.timedelta(hours=4)
        minutes = run.duration_s // 60 + 5
        made.append(
            replace(
                run,
                name=f"r{len(made) + 1:03d}",
                position=run.position + 2,
                started=run.started + later,
                recharge_ended=run.recharge_ended + later,
                duration_s=60 * minutes,
                charge_mah=round(TRUTH.drain.charge_mah(60 * minutes)),
            )
        )
    return made


def _levels(run: DemoRun) -> dict[str, object]:
    if run.condition is None:
        return {}
    surface = "sand" if run.condition.is_control else "gravel"
    return {"surface": surface, "drop_height": 30 if run.condition.foot == "small" else 45}


def report_of(folder: Path, *, control: bool, robots: bool) -> Told:
    """Make a book below the folder and its report; without `robots` all runs are the flea's."""
    instruments = write_instruments(folder)
    made = _runs()
    rows = [replace(run, levels=_levels(run), robot=_robot(run) if robots else FLEA) for run in made]
    (instruments / "runs.csv").write_bytes(run_sheet(("surface", "drop_height"), rows))
    for date in DAYS:
        sheet = [run for run in made if run.date == date]
        (instruments / "charger" / f"{date:%Y-%m-%d}.csv").write_bytes(charger_sheet(sheet))
    book_folder = folder / "book"
    book_folder.mkdir()
    toml = _HEAD.format(control='control = "sand"\n' if control else "")
    toml += "".join(_ROBOT.format(name=name) for name in (FLEA, CRICKET))
    toml += "".join(f"\n[batteries.{name}]\ncells = 4\ncapacity_mah = 6600\n" for name in "ABC")
    (book_folder / "labbook.toml").write_text(toml, encoding="utf-8")
    make_book(book_folder, ADA)
    with opened(book_folder) as book:
        import_sheet(book, instruments / "runs.csv")
        ingest_all(book, instruments)
        report = state_report(book, None, ADA, lambda _step: None)
    return Told(report, quick_page(report.content))


@pytest.fixture(scope="session")
def surfaces(tmp_path_factory: pytest.TempPathFactory) -> Told:
    """Sand is the control; two robots."""
    return report_of(tmp_path_factory.mktemp("surfaces"), control=True, robots=True)


@pytest.fixture(scope="session")
def without_control(tmp_path_factory: pytest.TempPathFactory) -> Told:
    """No factor names a control level; one robot."""
    return report_of(tmp_path_factory.mktemp("without-control"), control=False, robots=False)
