"""What a report says of a study that is not the demonstration's: its own factors, two robots, no control level."""

from __future__ import annotations

import csv
import re

import pytest

from reports.figures.kind import draw_figure
from reports.figures.registry import FIGURES
from reports.figures.style import TWO_COLUMNS_IN
from reports.tables.formats.as_csv import csv_bytes
from reports.tables.registry import TABLES
from tests.helpers.wording import says
from tests.labbook.presenting.conftest import Told


def said(page: str) -> str:
    """The page's text, drawings and their descriptions left out."""
    html = re.sub(r"<style.*?</style>|<svg.*?</svg>", "", page, flags=re.DOTALL)
    text = re.sub(r"<[^>]+>", " ", html).replace("\u00a0", " ").replace("&#39;", "'")
    return re.sub(r"\s+", " ", text)


@pytest.fixture(scope="module")
def page(surfaces: Told) -> str:
    return said(surfaces.page)


@pytest.fixture(scope="module")
def page_without_control(without_control: Told) -> str:
    return said(without_control.page)


def test_a_claim_names_the_treatment_the_control_and_the_group_with_its_unit(surfaces: Told) -> None:
    saving, *others = [claim.text.replace("\u00a0", " ") for claim in surfaces.made.content.claims]
    says(saving, "2 days", "against the control", "30 cm", "95 %")
    untold = "Whether gravel saves energy with drop height = 45 cm cannot be told: "
    assert any(text.startswith(untold) for text in others)
    assert any("the apex height" in text for text in others)


def test_nothing_is_said_of_active_damping_where_none_was_used(page: str, page_without_control: str) -> None:
    for text in (page, page_without_control):
        assert not re.search(r"\b(CE|AD|[Aa]ctive damping)\b", text)
        assert "stands at 0" not in text
    says(page, "(control - treatment) / control")
    says(page, "with gravel against the control (sand)", "by the days")


def test_numbers_are_written_once_and_with_their_unit(page: str) -> None:
    says(page, "Drop height", "30 cm", "45 cm")
    assert "30 30" not in page


def test_the_control_stands_first_on_an_axis_of_labels(surfaces: Told) -> None:
    content = surfaces.made.content
    axes = draw_figure(FIGURES["joules_by_level"], content, TWO_COLUMNS_IN).axes[0]
    assert [label.get_text() for label in axes.get_xticklabels()] == ["control (sand)", "gravel"]
    says(FIGURES["joules_by_level"].caption(content), "The control (sand")
    assert "control (sand) " in FIGURES["joules_by_level"].alternative(content)


@pytest.mark.parametrize("name", ["joules_by_condition", "apex_by_condition"])
def test_control_and_treatment_of_a_group_stand_under_one_heading(surfaces: Told, name: str) -> None:
    blocks = TABLES[name].make(surfaces.made.content).blocks
    assert [block.replace("\u00a0", " ") for block, _ in blocks] == ["drop height = 30 cm", "drop height = 45 cm"]
    for _, rows in blocks:
        assert {row.cells[0].text for row in rows} == {"control (sand)", "gravel"}


def test_robots_are_counted_in_words_and_in_the_tables_of_conditions(surfaces: Told, page: str) -> None:
    says(page, "2 robots", "6 runs")
    table = csv_bytes(TABLES["joules_by_condition"].make(surfaces.made.content)).decode()
    robots = [row["robots"] for row in csv.DictReader(table.splitlines())]
    assert robots == ["flea 2, cricket 2", "flea 2, cricket 2", "flea 2", "cricket 2"]
    assert robots[0] in page


def test_a_control_of_another_robot_is_a_limitation(surfaces: Told) -> None:
    notes = [note.replace("\u00a0", " ") for note in surfaces.made.content.limitations if "may be" in note]
    says(notes, "45 cm", "flea (2)", "cricket (2)")


def test_the_drain_fits_error_is_shared_by_a_robots_runs(surfaces: Told, without_control: Told) -> None:
    table = TABLES["uncertainty_budget"].make(surfaces.made.content)
    shared = {row.cells[0].text: row.cells[3].text for row in table.rows}
    assert shared["drain fit"] == "a robot's runs"
    assert shared["reference voltage"] == "all runs"
    assert shared["scatter between runs"] == "no runs"
    one = {
        row.cells[0].text: row.cells[3].text
        for row in TABLES["uncertainty_budget"].make(without_control.made.content).rows
    }
    assert (one["drain fit"], one["scatter between runs"]) == ("yes", "no")


def test_the_caption_says_what_the_interval_holds_beside_the_scatter(surfaces: Told) -> None:
    content = surfaces.made.content
    says(TABLES["joules_by_condition"].make(content).caption, "interval also holds")
    assert "drain fit" not in TABLES["apex_by_condition"].make(content).caption


def test_without_a_control_level_the_page_says_why_it_claims_nothing(page_without_control: str) -> None:
    says(page_without_control, "Nothing is claimed")
    assert "`control = ...`" in page_without_control
    says(page_without_control, "Nothing is compared")
    for words in ("F-test", "Fieller", "Savings are", "through the control", "robots:", "all conditions"):
        assert words not in page_without_control


def test_without_a_control_level_all_conditions_share_one_panel(without_control: Told) -> None:
    for name in ("joules_by_level", "apex_by_level"):
        (axes,) = draw_figure(FIGURES[name], without_control.made.content, TWO_COLUMNS_IN).axes
        assert [label.get_text() for label in axes.get_xticklabels()] == ["30", "45"]
        assert axes.get_xlabel() == "Drop height (cm)"
        says(FIGURES[name].caption(without_control.made.content), "against the drop")
        words = FIGURES[name].alternative(without_control.made.content)
        assert "sand surface: " in words
        assert "treatment" not in words


def test_without_a_control_level_every_factor_has_a_column(without_control: Told) -> None:
    table = TABLES["joules_by_condition"].make(without_control.made.content)
    assert [column.head for column in table.heads][:2] == ["Surface", "Drop height (cm)"]
    assert [cell.text for row in table.rows for cell in table.cells(row)[:2]] == [
        "sand", "30", "sand", "45", "gravel", "30", "gravel", "45",
    ]  # fmt: skip
    assert [block for block, _ in table.blocks] == [""]
    days = TABLES["days"].make(without_control.made.content)
    says(days.rows[0].cells[2].text.replace("\u00a0", " "), "drop height =", "30 cm")
