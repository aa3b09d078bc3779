"""From a point to its run: named on hover, linked to the run's row, and only text whatever a run is called."""

import dataclasses
import re

import pytest

from data_schema.outcomes import Outcome
from reports.display import general_text
from reports.figures.kind import draw_figure, svg_bytes
from reports.figures.registry import FIGURES
from reports.figures.style import ONE_COLUMN_IN
from reports.page.writing import inline_svg, render_page, report_files
from reports.results import Day, Run
from reports.tables import each_run as rows_of_runs
from reports.tables.each_run import each_run, name_points, points_drawn, run_anchors, run_days, run_names
from reports.tables.registry import tables_of
from tests.helpers.pages import DRAWN, with_summary
from tests.helpers.wording import says

POINT = re.compile(r'<a href="#(run-\d+)" tabindex="-1"><title>([^<]*)</title><use [^>]*/></a>')
EMPTY = dict.fromkeys(DRAWN, b'<svg viewBox="0 0 9 9"></svg>')
NASTY = "<script>x</script>&\"'"


def figure_of(content, outcome):
    name = f"{outcome.key}_by_level"
    svg = svg_bytes(draw_figure(FIGURES[name], content, ONE_COLUMN_IN))
    return name_points(inline_svg(svg, name, "t", "d"), name, content, run_anchors(content))


def page_of(content):
    return render_page(content, EMPTY, {kind.name: kind.make(content) for kind in tables_of(content)})


@pytest.fixture(scope="module")
def html(content):
    return page_of(content)


@pytest.mark.parametrize("outcome", [Outcome.JOULES, Outcome.APEX])
def test_every_point_names_its_run_day_and_value_and_leads_to_its_row(content, html, outcome):
    points = POINT.findall(figure_of(content, outcome))
    runs = [run for series in points_drawn(content, outcome) for run in series]
    assert len(points) == len(runs) > 100
    days, anchors = run_days(content), run_anchors(content)
    factor, unit = (1.0, "J") if outcome is Outcome.JOULES else (1000.0, "mm")
    for (target, title), (run, value) in zip(points, runs, strict=True):
        day = f", {days[run]}" if run in days else ""
        assert title == f"{run}{day}: {general_text(value * factor)} {unit}"
        assert target == anchors[run]
    assert {target for target, _ in points} <= set(re.findall(r'<tr id="([^"]*)"', html))


def test_a_point_stands_at_the_value_that_it_names(content):
    """The order of the points in the drawing is that of the runs: heights on the page fall as values rise."""
    heights = [
        (float(y), float(title.rpartition(": ")[2].split()[0]))
        for title, y in re.findall(
            r'<title>([^<]*)</title><use [^>]*\by="([\d.]+)"', figure_of(content, Outcome.JOULES)
        )
    ]
    assert len(heights) > 100
    (y_0, value_0), (y_1, value_1) = min(heights), max(heights)
    for y, value in heights:
        assert value == pytest.approx(value_0 + (y - y_0) * (value_1 - value_0) / (y_1 - y_0), abs=0.11)


def renamed(content, name):
    """The content with the first run of the first condition called something else, with its jumps."""
    first, *others = content.conditions
    joules = first.summaries[Outcome.JOULES]
    runs = ((name, joules.runs[0][1]), *joules.runs[1:])
    changed = with_summary(first, Outcome.JOULES, dataclasses.replace(joules, runs=runs))
    day = Day("2021-05-03", (name,), ())
    known = {**content.runs, name: Run("2021-05-03", 1, "A", "hopper", {2: 0.31, 4: 0.33})}
    return dataclasses.replace(content, conditions=(changed, *others), days=(day, *content.days), runs=known)


def test_a_run_of_any_name_stays_text(content):
    changed = renamed(content, NASTY)
    drawn = figure_of(changed, Outcome.JOULES)
    assert "<script" not in drawn
    assert "&lt;script&gt;x&lt;/script&gt;&amp;&quot;&#x27;, 2021-05-03: " in drawn
    page = page_of(changed)
    assert "<script>x" not in page
    assert "&lt;script&gt;x" in page
    assert "310.0" in page


def test_a_run_s_row_has_its_jumps(content):
    table = each_run(renamed(content, "the first"))
    (row,) = [row for row in table.rows if row.cells[0].text == "the first"]
    assert row.cells[1].text == "2021-05-03"
    assert row.cells[-1].values == (2, 0.31, 0.33)
    says(row.cells[-1].text, "2", "310", "330 mm")
    assert row.cells[-1].marks == (0.0, 1.0)
    assert row.cells[-1].details == ("2: 310.0, 4: 330.0", "labbook plot 'the first' --out 'the first.html'")


def test_points_of_too_many_runs_are_named_and_lead_nowhere(content, monkeypatch):
    monkeypatch.setattr(rows_of_runs, "MOST_RUNS", 100)
    drawn = figure_of(content, Outcome.JOULES)
    assert "<a " not in drawn
    assert len(re.findall(r"<g><title>[^<]*</title><use", drawn)) > 100
    assert 'id="run-1"' not in page_of(content)
    assert [row.cells[0].text for row in each_run(content).rows] == list(run_names(content))


def test_of_too_many_runs_the_files_for_programs_have_a_row_each_and_those_for_a_paper_none(content, monkeypatch):
    monkeypatch.setattr(rows_of_runs, "MOST_RUNS", 100)
    files = report_files(content)
    assert files["tables/each_run.csv"].count(b"\n") > 100
    assert files["tables/each_run.tex"].count(b"\n") < 20
