"""A report decides by shared days, and what stands beside that is what the statistics say of its runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.comparisons import Compared, adjust
from labbook.analysis.comparison.deciding import decide
from labbook.analysis.comparison.pairing import EACH, POOLED, pairs_with_control
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.results import Results
from labbook.analysis.study import Analysis
from labbook.config.model import AnalysisSettings
from reports.numbers import Number, Value
from reports.results import Source
from stats.compare.two_sample import compare_two
from stats.days.decision import contrast_by_day
from stats.groups.multiple import holm
from tests.helpers.charged_book import Made, charged_book
from tests.helpers.decided import decided_book
from tests.helpers.decided import reports as report_of
from tests.helpers.pages import quick_page
from tests.helpers.wording import says
from tests.labbook.conftest import CONFOUNDED, Reports


@pytest.fixture
def computed() -> Results:
    """Results of which none is computed yet."""
    return Results()


def values(side: tuple[ConditionValues, ...]) -> list[float]:
    return [item.value for condition in side for item in condition.runs]


def days(side: tuple[ConditionValues, ...]) -> list[str]:
    return [item.run.day for condition in side for item in condition.runs]


def compared(made: Analysis, quantity: Outcome) -> list[Compared]:
    pairs = pairs_with_control(made.measured.conditions[quantity], "b_ad_gain")
    shown = [one for one in made.results.comparisons if one.quantity is quantity]
    found = [Compared(pair, one, None) for pair, one in zip(pairs, shown, strict=True)]
    assert {item.pair.family for item in found} == {EACH, POOLED}
    return found


@pytest.mark.parametrize("alpha", [0.05, 0.01])
def test_a_comparison_is_decided_by_the_days_of_its_runs(reports: Reports, alpha: float) -> None:
    made = reports(f"alpha = {alpha}\napex_bounds_percent = [-2, 3]")
    for item in compared(made, Outcome.APEX):
        a, b = item.pair.a, item.pair.b
        contrast = contrast_by_day(values(b), values(a), days_treated=days(b), days_control=days(a))
        expected, found = contrast.difference(1.0 - alpha), item.shown.decision
        assert found.rule is contrast.rule
        assert found.difference.value == expected.value
        assert found.difference.se == expected.se or isinstance(expected.se, Undefined)
        assert found.difference.ci_level == 1.0 - alpha
        assert found.p.value == expected.p or isinstance(expected.p, Undefined)
        bounded = contrast.equivalence(-2.0, 3.0, alpha)
        assert found.equivalence is not None
        assert found.equivalence.estimate.value == bounded.value
        assert found.equivalence.estimate.ci_level == pytest.approx(1.0 - 2.0 * alpha)
        assert found.equivalence.p.value == bounded.p or isinstance(bounded.p, Undefined)
    assert all(item.shown.decision.equivalence is None for item in compared(made, Outcome.JOULES))
    assert made.results.no_equivalence == ""


def test_the_thesis_s_route_is_f_then_t_over_all_runs_whatever_their_days(reports: Reports) -> None:
    for quantity in (Outcome.JOULES, Outcome.APEX):
        for item in compared(reports(), quantity):
            expected, route = compare_two(values(item.pair.b), values(item.pair.a), "f_then_t"), item.shown.over_runs
            assert route.test == expected.test
            assert route.difference.value == expected.difference
            for found, one in ((route.f, expected.f), (route.t, expected.t), (route.p, expected.p)):
                assert found.value == one or isinstance(one, Undefined)
    pooled = [item.shown for item in compared(reports(), Outcome.APEX) if item.pair.family == POOLED]
    assert all(one.over_jumps is not None and one.over_jumps.n_control > one.over_runs.n_control for one in pooled)


def test_conditions_of_one_day_each_get_no_p_and_the_page_says_why(reports: Reports) -> None:
    made = reports(where=CONFOUNDED)
    for item in made.results.comparisons:
        assert isinstance(item.decision.p.value, Undefined)
        assert isinstance(item.decision.difference.value, float)
    assert all("cannot be told" in claim.text for claim in made.results.claims)


def test_a_day_that_was_corrected_is_another_result(reports: Reports, computed: Results) -> None:
    item = compared(reports(), Outcome.APEX)[0]
    first = item.pair.a[0]
    moved = replace(first.runs[0], run=replace(first.runs[0].run, day="2030-01-01"))
    pair = replace(item.pair, a=(replace(first, runs=(moved, *first.runs[1:])),))
    same, other = decide(computed.about(selection=""), [item.pair, pair], Outcome.APEX, AnalysisSettings())
    assert same.origin.key == item.shown.decision.origin.key
    assert other.origin.key != same.origin.key


@pytest.mark.parametrize(("family", "named"), [pytest.param("pooled", POOLED, marks=pytest.mark.soak), ("each", EACH)])
def test_holm_adjusts_the_tests_of_the_family_that_was_decided_and_no_other(
    reports: Reports, family: str, named: str
) -> None:
    made = reports(f'family = "{family}"')
    for quantity in (Outcome.JOULES, Outcome.APEX):
        members = [item.shown.decision for item in compared(made, quantity) if item.pair.family == named]
        expected = holm({str(at): one.p.value for at, one in enumerate(members)}, named)
        for one, value in zip(members, expected.adjusted_p, strict=True):
            assert one.adjusted is not None
            assert one.adjusted.n == len(members)
            assert one.adjusted.value == value or isinstance(value, Undefined)
    shown = [one for one in made.results.comparisons if one.decision.adjusted is not None]
    # With one treated level all levels against the control are the comparisons of each, which are shown for them.
    assert {one.family for one in shown} == {named} | {POOLED}
    says("".join(made.results.methods), "over the family", named, "2", "joules a jump")


def test_holm_takes_the_logarithm_where_p_is_below_all_doubles(reports: Reports, computed: Results) -> None:
    item = compared(reports(), Outcome.APEX)[0].shown.decision
    tiny = {f"{t}": replace(item, t=Number(-t, "1", df=800.0), p=Number(0.0, "1", df=800.0)) for t in (80.0, 90.0)}
    row = adjust(computed, tiny, POOLED, alpha=1e-13, trial="2")
    assert row is not None
    assert [one.value for one in row.adjusted_p.values()] == [0.0, 0.0]
    assert all(row.rejected.values())


def test_without_bounds_no_equivalence_is_tested_and_the_page_says_how_to_ask_for_it(reports: Reports) -> None:
    made = reports()
    assert all(item.decision.equivalence is None for item in made.results.comparisons)
    assert all("" not in reasons for reasons in by_name(made).values())
    page = quick_page(made.results)
    says(page, "states no bounds", "apex_bounds_m = [-0.005,", "[analysis]")
    assert "TOST" not in page
    says(page, "Nothing was decided")


# --- what was planned


def by_name(made: Analysis) -> dict[tuple[Outcome, str], set[str]]:
    found: dict[tuple[Outcome, str], set[str]] = {}
    for item in made.results.comparisons:
        found.setdefault((item.quantity, item.family), set()).add(item.exploratory)
    return found


def test_what_was_not_decided_beforehand_is_called_exploratory_with_the_reason(reports: Reports) -> None:
    made = reports('primary_outcome = "joules"\nfamily = "pooled"', in_time=True)
    found = by_name(made)
    assert found.pop((Outcome.JOULES, POOLED)) == {""}
    assert all("" not in reasons for reasons in found.values())
    says([*found[Outcome.APEX, POOLED]], "primary outcome", "is joules")
    page = quick_page(made.results)
    says(page, "first measurement came")
    says(page, "pooled against", "(exploratory)")
    says(made.results.plan.decided[1], "run is dated", "2021")


def test_a_family_of_one_test_is_left_as_it_is(reports: Reports) -> None:
    made = reports(where="foot == small")
    assert all(item.decision.adjusted is None for item in made.results.comparisons)
    assert "Holm" not in "".join(made.results.methods)


def test_the_family_that_was_decided_on_comes_before_claims_of_another(reports: Reports) -> None:
    made = reports('family = "each"').results
    first, *others = made.claims
    says(first.text, EACH, "difference is shown")
    assert "pooled" not in first.text  # there is one treated level
    assert others


NAMES = {
    Source.FIELLER: "Fieller",
    Source.HOLM: "Holm",
    Source.PAIRED_ON_DAY_MEANS: "paired t on day means",
    Source.TOST: "TOST",
}


@pytest.mark.parametrize(
    ("analysis", "where"),
    [("", None), ("apex_bounds_percent = [-3, 3]", None), pytest.param("", CONFOUNDED, marks=pytest.mark.soak)],
)
def test_what_the_methods_name_is_cited_and_nothing_else(reports: Reports, analysis: str, where: str | None) -> None:
    content = reports(analysis, where).results
    text = " ".join(content.methods)
    of_thesis = (Source.THESIS, Source.WELCH)  # the tests that stand beside
    assert [one for one in content.sources if one not in of_thesis] == [
        one for one, name in NAMES.items() if name in text
    ]
    tested = any(isinstance(one.over_runs.t.value, float) for one in content.comparisons)
    assert (Source.THESIS in content.sources) is tested


def test_the_methods_say_why_no_day_allows_a_test(tmp_path: Path) -> None:
    """They said that no day holds runs of both, above a table with three such days."""
    made = charged_book(tmp_path, [Made(day, "small", gain, 50.0 + day) for day in range(3) for gain in (0, 100)])
    content = report_of(made).results
    reasons = {
        one.decision.t.value.reason for one in content.comparisons if isinstance(one.decision.t.value, Undefined)
    }
    assert len(reasons) == 1
    says(" ".join(content.methods), *reasons, "3 days")


# --- a selection


def adjusted_p(made: Analysis, quantity: Outcome, family: str) -> dict[str, tuple[Value, int | None]]:
    """Holm's p of each comparison of a family, with the number of tests that it counts."""
    found = {}
    for item in made.results.comparisons:
        adjusted = item.decision.adjusted
        if (item.quantity, item.family) == (quantity, family) and adjusted is not None:
            found[item.label] = adjusted.value, adjusted.n
    return found


@pytest.mark.parametrize(("family", "named"), [("pooled", POOLED), ("each", EACH)])
def test_a_selection_has_the_adjusted_p_of_the_whole(tmp_path: Path, family: str, named: str) -> None:
    made = decided_book(tmp_path, f'\n[analysis]\nfamily = "{family}"\n')
    whole, part = report_of(made, None), report_of(made, "foot=small")
    for quantity in (Outcome.JOULES, Outcome.APEX):
        of_whole, of_part = adjusted_p(whole, quantity, named), adjusted_p(part, quantity, named)
        assert len(of_whole) == 2
        assert len(of_part) == 1
        assert of_part.items() <= of_whole.items()
    counted = [f"2 of {quantity}" for quantity in (Outcome.JOULES, Outcome.APEX)]
    says(" ".join(whole.results.methods), *counted)
    assert "not in this" not in " ".join(whole.results.methods)
    says(" ".join(part.results.methods), *(f"{each} (1 not in this selection)" for each in counted))
    assert all("large" not in item.label for item in part.results.comparisons)

    less = report_of(made, "foot=small or b_ad_gain=0").results.comparisons  # levels left out of a group count, too
    assert {one.n for item in less if (one := item.decision.adjusted) is not None} == {2}
