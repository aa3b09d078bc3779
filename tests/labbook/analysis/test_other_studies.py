"""A report of other studies than the demonstration's: other factors, two robots, with a control level and without one.

The small book's runs and logs stand for them: the small foot for a drop of 30 cm, the large one for 45 cm, the control
gain for sand, active damping for gravel. The first day is the flea's and the second the cricket's, but for the drop of
45 cm: there the flea jumps on sand and the cricket on gravel.
"""

from __future__ import annotations

import csv
import datetime as dt
import re
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from data_schema.vocabulary import RunKind
from labbook.actions.report_command import state_report
from labbook.analysis.comparison.order import confounded_with_day
from labbook.analysis.study import Analysis
from labbook.book.making import make_book
from labbook.book.opening import opened
from labbook.demo.campaign import DemoRun
from labbook.demo.writers import charger_sheet, run_sheet
from reports.figures.kind import draw_figure
from reports.figures.registry import FIGURES
from reports.figures.style import TWO_COLUMNS_IN
from reports.tables.formats import csv_bytes
from reports.tables.registry import TABLES
from tests.helpers.books import ADA, DAYS, TRUTH, import_sheet, ingest_all, small_runs, small_toml, write_instruments
from tests.helpers.pages import quick_page
from tests.helpers.wording import says

FLEA, CRICKET = "flea", "cricket"
FACTORS = """\
[factors.surface]
kind = "label"
levels = ["sand", "gravel"]
{control}
[factors.drop_height]
kind = "number"
title = "Drop height"
unit = "cm"
levels = [30, 45]

"""


@dataclass(frozen=True)
class Told:
    """A study's report, and the text of its page, drawings and their descriptions left out."""

    made: Analysis
    page: str


def toml_of(control: bool) -> str:
    """The small book's labbook.toml with these factors, and its robot twice."""
    factors = FACTORS.format(control='control = "sand"\n' if control else "")
    text = re.sub(r"(?s)\[factors\.foot\].*?(?=\[protocol\])", factors, small_toml())
    text = re.sub(r"(?s)\[gains\..*?(?=\[robots)", "", text)
    return re.sub(
        r"(?s)\[robots\.hopper\].*?\n\n",
        lambda robot: "".join(robot[0].replace("hopper", name) for name in (FLEA, CRICKET)),
        text,
    )


def robot_of(run: DemoRun) -> str:
    if run.condition is not None and run.condition.foot == "large":
        return FLEA if run.condition.is_control else CRICKET
    return FLEA if run.date == DAYS[0] else CRICKET


def levels_of(run: DemoRun) -> dict[str, object]:
    if run.condition is None:
        return {}
    surface = "sand" if run.condition.is_control else "gravel"
    return {"surface": surface, "drop_height": 30 if run.condition.foot == "small" else 45}


def all_runs() -> list[DemoRun]:
    """The small book's runs, with two more idle runs a day, so that each robot has a drain line."""
    made, later = list(small_runs()), dt.timedelta(hours=4)
    for run in [run for run in made if run.kind is RunKind.IDLE]:
        duration_s = run.duration_s + 300
        made.append(
            replace(
                run,
                name=f"r{len(made) + 1:03d}",
                position=run.position + 2,
                started=run.started + later,
                recharge_ended=run.recharge_ended + later,
                duration_s=duration_s,
                charge_mah=round(TRUTH.drain.charge_mah(duration_s)),
            )
        )
    return made


def report_of(folder: Path, *, control: bool, robots: bool) -> Told:
    """Make a book below the folder and its report; without `robots` all runs are the flea's."""
    instruments, made = write_instruments(folder), all_runs()
    rows = [replace(run, levels=levels_of(run), robot=robot_of(run) if robots else FLEA) for run in made]
    (instruments / "runs.csv").write_bytes(run_sheet(("surface", "drop_height"), rows))
    for date in DAYS:
        sheet = [run for run in made if run.date == date]
        (instruments / "charger" / f"{date:%Y-%m-%d}.csv").write_bytes(charger_sheet(sheet))
    (folder / "book").mkdir()
    (folder / "book" / "labbook.toml").write_text(toml_of(control), encoding="utf-8")
    make_book(folder / "book", ADA)
    with opened(folder / "book") as book:
        import_sheet(book, instruments / "runs.csv")
        ingest_all(book, instruments)
        report = state_report(book, None, ADA, lambda _step: None)
    html = re.sub(r"<style.*?</style>|<svg.*?</svg>", "", quick_page(report.results), flags=re.DOTALL)
    text = re.sub(r"<[^>]+>", " ", html).replace("\u00a0", " ").replace("&#39;", "'")
    return Told(report, re.sub(r"\s+", " ", text))


@pytest.fixture(scope="module")
def surfaces(tmp_path_factory: pytest.TempPathFactory) -> Told:
    """Sand is the control; two robots."""
    return report_of(tmp_path_factory.mktemp("surfaces"), control=True, robots=True)


@pytest.fixture(scope="module")
def without_control(tmp_path_factory: pytest.TempPathFactory) -> Told:
    """No factor names a control level; one robot."""
    return report_of(tmp_path_factory.mktemp("without-control"), control=False, robots=False)


def test_a_claim_names_the_treatment_the_control_and_the_group_with_its_unit(surfaces: Told) -> None:
    saving, *others = [claim.text.replace("\u00a0", " ") for claim in surfaces.made.results.claims]
    says(saving, "2 days", "against the control", "30 cm", "95 %")
    untold = "Whether gravel saves energy with drop height = 45 cm cannot be told: "
    assert any(text.startswith(untold) for text in others)
    assert any("the apex height" in text for text in others)


def test_a_page_names_this_study_s_levels_with_units_and_no_other_s(surfaces: Told, without_control: Told) -> None:
    for text in (surfaces.page, without_control.page):
        assert not re.search(r"\b(CE|AD|[Aa]ctive damping)\b", text)
        assert "stands at 0" not in text
    says(surfaces.page, "(control \u2212 treatment) / control")
    says(surfaces.page, "with gravel against the control (sand)", "by the days")
    says(surfaces.page, "Drop height", "30 cm", "45 cm")
    assert "30 30" not in surfaces.page


def test_the_control_stands_first_on_an_axis_of_labels(surfaces: Told) -> None:
    content = surfaces.made.results
    axes = draw_figure(FIGURES["joules_by_level"], content, TWO_COLUMNS_IN).axes[0]
    assert [label.get_text() for label in axes.get_xticklabels()] == ["control (sand)", "gravel"]
    says(FIGURES["joules_by_level"].caption(content), "The control (sand")


def test_robots_are_counted_in_the_tables_of_conditions(surfaces: Told) -> None:
    table = csv_bytes(TABLES["joules_by_condition"].make(surfaces.made.results)).decode()
    robots = [row["robots"] for row in csv.DictReader(table.splitlines())]
    assert robots == ["flea 2, cricket 2", "flea 2, cricket 2", "flea 2", "cricket 2"]
    assert robots[0] in surfaces.page


def test_a_control_of_another_robot_is_a_limitation(surfaces: Told) -> None:
    notes = [note.replace("\u00a0", " ") for note in surfaces.made.results.limitations if "may be" in note]
    says(notes, "45 cm", "flea (2)", "cricket (2)")


def test_the_drain_fits_error_is_shared_by_a_robots_runs(surfaces: Told, without_control: Told) -> None:
    def shared(told: Told) -> dict[str, str]:
        return {
            row.cells[0].text: row.cells[3].text for row in TABLES["uncertainty_budget"].make(told.made.results).rows
        }

    two, one = shared(surfaces), shared(without_control)
    assert (two["drain fit"], two["reference voltage"]) == ("a robot's runs", "all runs")
    assert (two["scatter between runs"], one["drain fit"], one["scatter between runs"]) == ("no runs", "yes", "no")


def test_without_a_control_level_the_page_says_why_it_claims_nothing(without_control: Told) -> None:
    says(without_control.page, "Nothing is claimed")
    assert "`control = ...`" in without_control.page
    says(without_control.page, "Nothing is compared")
    for words in ("F-test", "Fieller", "Savings are", "through the control", "robots:", "all conditions"):
        assert words not in without_control.page


def test_without_a_control_level_every_factor_has_a_column(without_control: Told) -> None:
    table = TABLES["joules_by_condition"].make(without_control.made.results)
    assert [column.head for column in table.heads][:2] == ["Surface", "Drop height (cm)"]
    assert [cell.text for row in table.rows for cell in table.cells(row)[:2]] == [
        "sand", "30", "sand", "45", "gravel", "30", "gravel", "45",
    ]  # fmt: skip
    assert [block for block, _ in table.blocks] == [""]
    days = TABLES["days"].make(without_control.made.results)
    says(days.rows[0].cells[2].text.replace("\u00a0", " "), "drop height =", "30 cm")


MIXED, SAND, GRAVEL, TREATED = ("sand", "gravel"), ("sand", "sand"), ("gravel", "gravel"), ("gravel", "mud")


@pytest.mark.parametrize(
    ("days", "facts"),
    [
        ([("sand",), ("gravel",), MIXED], None),  # days of a single run show nothing
        ([("sand",), ("gravel",)], None),
        ([SAND, GRAVEL, ("gravel",)], ["On 2 of the 2 days", "the surface", "confounded"]),
        ([SAND, GRAVEL, MIXED], ["2", "3 days"]),
        ([SAND, GRAVEL, MIXED, MIXED], None),
        ([TREATED, TREATED, MIXED], ["2", "3 days"]),  # days without a control
        ([TREATED, TREATED], None),
    ],
)
def test_a_factor_is_confounded_where_most_days_had_one_level_of_it(
    surfaces: Told, days: list[tuple[str, ...]], facts: list[str] | None
) -> None:
    """The runs had these surfaces, a tuple a day, and one drop height."""
    evidence = surfaces.made.measured.evidence
    runs = tuple(
        replace(evidence.runs[0], day=f"2021-07-{day:02d}", is_control=each == "sand", levels={"surface": each})
        for day, of_day in enumerate(days, start=1)
        for each in of_day
    )
    said = confounded_with_day(replace(evidence, runs=runs), "surface")
    assert len(said) == (facts is not None)
    says(said, *(facts or ()))
