"""What the methods of a report name, and what they cite from the record against the methods at such designs."""

from __future__ import annotations

import html
import re
from collections.abc import Callable
from dataclasses import replace

import pytest

from data_schema.outcomes import Outcome
from labbook.config.model import UnitOfAnalysis
from labbook.presenting.report import tests_made as paragraph
from labbook.presenting.report.day_layout import layout_of
from labbook.presenting.report.error_rates import Use, known_error_rates, uses
from reports.content import Comparison, Source
from stats.lines.passive_drain import PassiveDrain
from stats.planning.recorded import weak_point
from tests.helpers.pages import quick_page
from tests.helpers.wording import says
from tests.labbook.conftest import CONFOUNDED, Reports

WORDS = {
    "Student's t-test": lambda item: item.test.name == "Student",
    "Fieller's interval": lambda item: item.savings is not None,
    "Holm's method": lambda item: item.adjusted is not None,
    "(TOST)": lambda item: item.equivalence is not None,
    "exact test on runs, day held fixed": lambda item: item.by_day is not None and item.by_day.kind == "exact test",
    "mixed model (REML, degrees of freedom after Satterthwaite)": lambda item: (
        item.by_day is not None and item.by_day.kind == "mixed model"
    ),
}


UNBALANCED = "foot == small and run != r001"


@pytest.mark.parametrize(
    ("analysis", "where"),
    [
        ("", None),
        ("apex_bounds_percent = [-3, 3]", None),
        pytest.param("", UNBALANCED, marks=pytest.mark.soak),
    ],
)
def test_the_methods_name_what_was_used_and_nothing_else(reports: Reports, analysis: str, where: str | None) -> None:
    made = reports(analysis, where)
    methods = "".join((*made.content.methods, made.content.tests_beside)).replace("\u00a0", " ")
    uses: dict[str, Callable[[Comparison], bool]] = WORDS
    for words, used in uses.items():
        assert (words in methods) == any(used(item) for item in made.content.comparisons), words
    assert "analysis of variance" not in methods  # one treated level a group leaves nothing to analyse
    assert "Tukey" not in methods
    assert "Dunnett" not in methods


NAMES = {
    Source.THESIS: "thesis",
    Source.BROWN_FORSYTHE: "Brown and Forsythe",
    Source.FIELLER: "Fieller",
    Source.HOLM: "Holm",
    Source.PAIRED_ON_DAY_MEANS: "paired t on day means",
    Source.MIXED_MODEL: "mixed model",
    Source.SATTERTHWAITE: "Satterthwaite",
    Source.TOST: "TOST",
    Source.WELCH: "Welch",
}


@pytest.mark.parametrize(
    ("analysis", "where"),
    [
        ("", None),
        pytest.param("", CONFOUNDED, marks=pytest.mark.soak),
        pytest.param("", UNBALANCED, marks=pytest.mark.soak),
        ("apex_bounds_percent = [-3, 3]", None),
        ('unit_of_analysis = "shared_days"', None),
        pytest.param('unit_of_analysis = "shared_days"', CONFOUNDED, marks=pytest.mark.soak),
    ],
)
def test_what_the_methods_name_is_cited_and_nothing_else(reports: Reports, analysis: str, where: str | None) -> None:
    content = reports(analysis, where).content
    text = " ".join((*content.methods, content.tests_beside))
    assert content.sources == tuple(source for source, name in NAMES.items() if name in text)


def test_the_methods_cite_what_is_on_record_against_a_method_at_such_a_design(reports: Reports) -> None:
    apart = reports(where=CONFOUNDED)
    worst = weak_point("f_then_t", (2, 2), "own", 1)
    assert worst is not None
    assert worst.value > 0.06
    methods = " ".join(apart.content.known_errors).replace("\u00a0", " ")
    says(methods, "F-test chooses rejects", "without an effect", "each group on", "1 day")
    page = html.unescape(quick_page(apart.content))
    assert [said for said in apart.content.known_errors[1:] if f"<li>{said}</li>" not in page] == []
    sentences = [sentence for sentence in methods.split(". ") if sentence.startswith("At n = ")]
    designs = [sentence.partition(": ")[0] for sentence in sentences]
    assert len(set(designs)) == len(designs) >= 1
    assert all(re.search(r" % stated\).* uses?( of each)? here(, .* less)?\)", one) for one in sentences)
    together = " ".join(reports().content.known_errors).replace("\u00a0", " ")
    assert "day of its" not in together
    assert "docs/statistics.md" in together
    assert known_error_rates(uses(replace(apart.analysis, compared=[], anovas=[], drains={}))) == ()


HEAD = (
    "Simulated at the sizes and days on record nearest to these (docs/statistics.md), not every method keeps what it "
    "states whatever the standard deviations of runs and days, which so few runs do not tell. "
)


def test_the_methods_cite_how_often_the_interval_of_the_passive_drain_covers(reports: Reports) -> None:
    analysis = replace(reports().analysis, compared=[], anovas=[])
    ((robot, drain),) = analysis.drains.items()
    assert isinstance(drain.line, PassiveDrain)
    long, middle, short = (
        replace(drain, line=replace(drain.line, n=25, duration_min_s=shortest, duration_max_s=longest))
        for shortest, longest in ((0.0, 1e-3), (0.0, 1e5), (-1e5, 1e5))
    )
    lasting = analysis.evidence.configuration.protocol.run_duration_s
    assert lasting is not None
    assert [use.method for use in uses(replace(analysis, drains={robot: long}))][-1] == "passive_drain_at_ci"
    assert [use.method for use in uses(replace(analysis, drains={robot: short}))][-1] == "passive_drain_middle_ci"
    assert [use.method for use in uses(replace(analysis, drains={robot: middle}))][-1] == "passive_drain_intercept_ci"
    told = " ".join(known_error_rates(uses(replace(analysis, drains={robot: long, "another": long})))).replace(
        "\u00a0", " "
    )
    says(told, HEAD, "25 idle", "3 times", "87.7 %", "95 %", "2 uses")
    nothing = replace(analysis, drains={robot: long})
    assert paragraph.tests_used(nothing, "").startswith("Nothing is compared")
    assert known_error_rates(uses(nothing))[0] == HEAD.rstrip()


def test_joules_whose_difference_keeps_the_lines_error_are_looked_up_by_the_idle_runs(reports: Reports) -> None:
    analysis = reports().analysis
    ((robot, drain),) = analysis.drains.items()
    assert isinstance(drain.line, PassiveDrain)
    other = replace(drain, line=replace(drain.line, n=3))
    found = uses(replace(analysis, drains={robot: drain, "a robot that compares nothing": other}))
    of_savings = {use.idle_runs for use in found if use.method == "fieller"}
    assert of_savings == {drain.line.n}  # what is left in the denominator
    joules = [item for item in analysis.compared if item.quantity is Outcome.JOULES]
    left = any(item.result.difference.shared_se for item in joules)
    assert {use.idle_runs for use in found if use.method == "welch"} == ({0, drain.line.n} if left else {0})
    assert {use.idle_runs for use in found if use.method == "brown_forsythe"} <= {0}


def test_a_design_without_days_in_common_is_looked_up_among_such_designs() -> None:
    own, shared = Use("welch", (10, 10), 1, "own"), Use("welch", (10, 10), 1, "shared")
    assert own.weak_points() == (weak_point("welch", (10, 10), "own", 1),)
    assert weak_point("welch", (10, 10)) is None
    assert shared.weak_points() == ()
    assert Use("fieller", (5, 5), 1, "own").weak_points() == (weak_point("fieller", (5, 5), "own", 1),)
    assert Use("welch", (10, 10), 2, "partly").weak_points() == (weak_point("welch", (10, 10), "partly", 2),)
    assert Use("brown_forsythe", (3, 3), 1, "shared").weak_points() == ()


def test_days_are_shared_only_where_all_of_them_are() -> None:
    a, b, c, d, e, f = "abcdef"
    assert layout_of([{a, b}, {c, d}]) == "own"
    assert layout_of([{a, b, c}, {a, d, e}]) == layout_of([{a}, {a, b, c, d, e}]) == "partly"
    assert layout_of([{a, b, c}, {a, b, c}]) == "shared"
    assert layout_of([{a, b, c, d, e}, {a, b, c, d, f}]) == layout_of([{a, b, c}, {a, b, d}]) == "mostly"
    assert layout_of([{a}, {a}, {b}]) == "partly"  # two of three levels have their day in common
    assert layout_of([{a}, {b}, {c}]) == "own"


def test_day_means_on_days_of_their_own_are_not_taken_for_runs_of_such_days(reports: Reports) -> None:
    """Welch's test errs in .178 of studies on five runs of five days each, and in .045 on five day means."""
    by_run = reports(where=CONFOUNDED).analysis
    settings = replace(by_run.planned.settings, unit_of_analysis=UnitOfAnalysis.DAY)
    by_day = replace(by_run, planned=replace(by_run.planned, settings=settings))
    assert "of its own" in " ".join(known_error_rates(uses(by_run)))
    assert "of its own" not in " ".join(known_error_rates(uses(by_day)))
    assert Use("welch", (5, 5)).weak_points() == ()
    assert Use("welch", (25, 25), 5, "own").weak_points() != ()
