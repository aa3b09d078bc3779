"""What stands beside every comparison is what the statistics say of its runs: by day, Holm, equivalence, the unit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from data_schema.outcomes import Outcome
from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.by_day import CONTROL, TREATED, DayComparison, compare_by_day
from labbook.analysis.comparison.comparing import ComparisonResult, compare
from labbook.analysis.comparison.comparisons import Compared, FamilyResult, adjust
from labbook.analysis.comparison.pairing import EACH, POOLED
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.results.result_cache import ResultCache
from labbook.analysis.study import VarianceAnalysed
from labbook.presenting.numbers import ShownNumbers
from labbook.presenting.report.comparisons import comparisons
from labbook.presenting.report.content import MadeReport
from labbook.presenting.report.preregistration import not_planned
from reports.numbers import Number
from reports.sentences import difference_claim
from stats.compare.equivalence import equivalence
from stats.compare.savings import percent_savings
from stats.compare.two_sample import compare_two
from stats.days.blocked import blocked_by_day
from stats.groups.multiple import holm
from stats.groups.variances import brown_forsythe
from tests.helpers.books import small_book
from tests.helpers.pages import quick_page
from tests.helpers.wording import says
from tests.labbook.conftest import CONFOUNDED, Reports


@pytest.fixture
def cache(tmp_path: Path) -> Iterator[ResultCache]:
    """A result cache of a book of its own, where nothing is stored yet."""
    with small_book(tmp_path).open() as book, book.reading() as connection:
        yield ResultCache(connection)


def value_of(number: Number) -> float:
    assert isinstance(number.value, float)
    return number.value


def values(side: tuple[ConditionValues, ...]) -> list[float]:
    return [item.value for condition in side for item in condition.runs]


def days(side: tuple[ConditionValues, ...]) -> list[str]:
    return [item.run.day for condition in side for item in condition.runs]


def compared(made: MadeReport, quantity: Outcome) -> list[Compared]:
    found = [item for item in made.analysis.compared if item.quantity is quantity]
    assert found
    return found


def with_control(made: MadeReport, quantity: Outcome) -> list[tuple[Compared, DayComparison]]:
    """The comparisons by day: those of every level and of all levels with the control."""
    found = [(item, item.by_day) for item in compared(made, quantity) if item.by_day is not None]
    assert {item.pair.family for item, _row in found} == {EACH, POOLED}
    return found


def test_by_day_is_the_comparison_of_the_runs_with_their_days(reports: Reports) -> None:
    for item, row in with_control(reports(), Outcome.APEX):
        control, treated = values(item.pair.a), values(item.pair.b)
        sides = [CONTROL] * len(control) + [TREATED] * len(treated)
        of_days = [*days(item.pair.a), *days(item.pair.b)]
        expected = blocked_by_day([*control, *treated], sides, of_days, control=CONTROL)
        (contrast,) = expected.contrasts
        difference = row.difference
        assert (difference.value, difference.se, difference.df) == (contrast.difference, contrast.se, contrast.df)
        assert (difference.ci_low, difference.ci_high) == contrast.interval
        assert (row.t.value, row.p.value) == (contrast.t, contrast.p)
        assert row.day_sd.value == pytest.approx(float(expected.day_variance) ** 0.5)  # type: ignore[arg-type]


def test_by_day_what_is_left_of_the_drain_lines_error_widens_the_interval(reports: Reports, cache: ResultCache) -> None:
    made = reports()
    item, _row = with_control(made, Outcome.JOULES)[0]

    def times(factor: float, one: ConditionValues) -> ConditionValues:
        return replace(one, runs=tuple(replace(run, shared=run.shared.times(factor)) for run in one.runs))

    pairs = [
        replace(item.pair, label=f"{factor}", b=tuple(times(factor, one) for one in item.pair.b))
        for factor in (1.0, 2.0)
    ]
    equal, unequal = (row.difference for row in compare_by_day(cache, pairs, Outcome.JOULES, {"trial": 1}, 0.05))
    assert equal.value == unequal.value
    assert equal.shared_se == pytest.approx(0.0, abs=1e-9)
    assert isinstance(unequal.shared_se, float)
    assert isinstance(unequal.ci_low, float)
    assert isinstance(equal.ci_low, float)
    assert unequal.shared_se > 1.0
    assert unequal.ci_low < equal.ci_low


def test_conditions_of_one_day_each_get_no_p_and_the_page_says_why(reports: Reports) -> None:
    made = reports(where=CONFOUNDED)
    for quantity in (Outcome.JOULES, Outcome.APEX):
        for item, row in with_control(made, quantity):
            p = row.p
            assert isinstance(p.value, Undefined)
            if item.pair.group["foot"] == "small":  # the large foot has a single run a side
                says(p.value.reason, "measured on one")
            assert isinstance(row.difference.value, float)
    page = quick_page(made.content).replace("\u00a0", " ")
    says(page, "conditions on shared")
    says(page, "Every day holds")
    assert all("cannot be told" in claim.text for claim in made.content.claims)
    says(made.content.tests_beside, "No comparison could")
    assert "mixed model" not in made.content.tests_beside


def test_a_day_that_was_corrected_is_another_result(reports: Reports, cache: ResultCache) -> None:
    made = reports()
    item, row = with_control(made, Outcome.APEX)[0]
    first = item.pair.a[0]
    moved = replace(first.runs[0], run=replace(first.runs[0].run, day="2030-01-01"))
    pair = replace(item.pair, a=(replace(first, runs=(moved, *first.runs[1:])),))
    same, other = compare_by_day(cache, [item.pair, pair], Outcome.APEX, row.origin.scope, 0.05)
    assert same == row
    assert other.origin.key != same.origin.key


@pytest.mark.parametrize(("family", "named"), [pytest.param("pooled", POOLED, marks=pytest.mark.soak), ("each", EACH)])
def test_holm_adjusts_the_welch_tests_of_the_family_that_was_decided_and_no_other(
    reports: Reports, family: str, named: str
) -> None:
    made = reports(f'family = "{family}"')
    for quantity in (Outcome.JOULES, Outcome.APEX):
        members = [item for item in compared(made, quantity) if item.pair.family == named]
        p = {item.pair.label: item.result.welch_p.value for item in members}
        expected = holm({label: value for label, value in p.items() if isinstance(value, float)}, named)
        for item, value in zip(members, expected.adjusted_p, strict=True):
            assert item.adjusted is not None
            found = item.adjusted.adjusted_p[item.pair.label]
            assert (found.value, found.n) == (value, len(members))
        assert all(item.adjusted is None for item in compared(made, quantity) if item not in members)
    shown = [comparison for comparison in made.content.comparisons if comparison.adjusted is not None]
    # With one treated level all levels against the control are the comparisons of each, which are shown for them.
    assert {comparison.family for comparison in shown} == {named} | {POOLED}
    assert len({comparison.lead.adjusted.provenance for comparison in shown if comparison.lead.adjusted}) == 4
    says("".join(made.content.methods), "over the family", named, "2", "joules a jump")


def test_holm_takes_the_logarithm_where_p_is_below_all_doubles(reports: Reports, cache: ResultCache) -> None:
    made = reports()
    members = [item for item in compared(made, Outcome.APEX) if item.pair.family == POOLED]
    tiny = [
        (item.pair, replace(item.result, welch_t=replace(item.result.welch_t, value=-t, df=800.0),
                                 welch_p=replace(item.result.welch_p, value=0.0, df=800.0)))
        for item, t in zip(members, (80.0, 90.0), strict=True)
    ]  # fmt: skip
    row = adjust(cache, tiny, POOLED, Outcome.APEX, {"trial": 2}, alpha=1e-13)
    assert [item.value for item in row.adjusted_p.values()] == [0.0, 0.0]
    assert all(row.rejected[pair.label] for pair, _result in tiny)


def test_a_p_that_is_exactly_alpha_is_shown_in_the_result_and_on_the_page(reports: Reports, cache: ResultCache) -> None:
    """One rule, p <= alpha, for a single test and for Holm's p, in the family of a command and in a report."""
    made = reports()
    members = [item for item in compared(made, Outcome.APEX) if item.pair.family == POOLED]
    item, tested = members[0], [(one.pair, one.result) for one in members]
    label, p = item.pair.label, {pair.label: value_of(row.welch_p) for pair, row in tested}

    def claimed(result: ComparisonResult, by_holm: FamilyResult | None) -> str:
        """The sentence of a report on these results."""
        found = [replace(item, result=result, adjusted=by_holm, decided=None)]
        (shown,) = comparisons(replace(made.analysis, compared=found), ShownNumbers())
        return difference_claim(made.content, shown).text

    for alpha, verdict in ((p[label], True), (math.nextafter(p[label], 0.0), False)):
        (row,) = compare(cache, [item.pair], Outcome.APEX, {"trial": 3}, alpha)
        assert row.rejected is verdict
        assert ("tell from zero" not in claimed(row, None)) is verdict
    (single,) = compare(cache, [item.pair], Outcome.APEX, {"trial": 3}, 0.999)
    adjusted_p = dict(zip(p, holm(p, POOLED).adjusted_p, strict=True))[label]
    assert isinstance(adjusted_p, float)
    for alpha, verdict in ((adjusted_p, True), (math.nextafter(adjusted_p, 0.0), False)):
        assert holm(p, POOLED, alpha=alpha).rejected[list(p).index(label)] is verdict
        row = adjust(cache, tested, POOLED, Outcome.APEX, {"trial": 3}, alpha)
        assert row.rejected[label] is verdict
        assert ("once the 2" not in claimed(single, row)) is verdict


def test_savings_are_shown_where_their_own_interval_does_not_hold_0(reports: Reports) -> None:
    for one in reports().content.comparisons:
        if one.savings is None:
            continue
        if not isinstance(one.savings.ci_low, float) or not isinstance(one.savings.ci_high, float):
            assert one.savings_shown is None
        else:
            assert one.savings_shown is (not one.savings.ci_low <= 0.0 <= one.savings.ci_high)


@pytest.mark.parametrize(
    ("bounds", "unit", "low"),
    [
        pytest.param("apex_bounds_m = [-0.004, 0.006]", "m", -0.004, marks=pytest.mark.soak),
        ("apex_bounds_percent = [-2, 3]", "%", -2.0),
    ],
)
def test_heights_are_tested_against_the_bounds_that_were_decided(
    reports: Reports, bounds: str, unit: str, low: float
) -> None:
    made = reports(f'unit_of_analysis = "run"\n{bounds}')
    high = 0.006 if unit == "m" else 3.0
    for item in compared(made, Outcome.APEX):
        assert item.equivalent is not None
        expected = equivalence(
            values(item.pair.b), values(item.pair.a), low=low, high=high, bounds="raw" if unit == "m" else "percent"
        )
        estimate = item.equivalent.estimate
        assert (estimate.value, estimate.unit, estimate.ci_level) == (expected.estimate, unit, 0.9)
        assert (estimate.ci_low, estimate.ci_high) == expected.estimate_ci
        assert item.equivalent.p.value == expected.p
        assert item.equivalent.equivalent is expected.equivalent
    assert all(item.equivalent is None for item in compared(made, Outcome.JOULES))
    heights = [claim.text for claim in made.content.claims if claim.text.startswith("The apex")]
    verdicts = [
        c.equivalence.shown for c in made.content.comparisons if c.equivalence is not None and c.level == "pooled"
    ]
    assert len(heights) == len(verdicts) == 2
    for text, verdict in zip(heights, verdicts, strict=True):
        assert f"was {'shown' if verdict else 'not shown'} (90" in text
    assert made.content.no_equivalence == ""
    told = "".join((*made.content.methods, made.content.tests_beside)).replace("\u00a0", " ")
    says(told, "4 comparisons")
    says(told, "all pooled within")


def test_without_bounds_no_equivalence_is_tested_and_the_page_says_how_to_ask_for_it(reports: Reports) -> None:
    made = reports()
    assert all(item.equivalent is None for item in made.analysis.compared)
    page = quick_page(made.content)
    says(page, "states no bounds", "apex_bounds_m = [-0.005,", "[analysis]")
    assert "TOST" not in page


def test_alpha_rules_levels_and_the_choice_of_the_test(reports: Reports) -> None:
    made = reports("alpha = 0.01\napex_bounds_m = [-0.005, 0.005]")
    for item in made.analysis.compared:
        a, b = values(item.pair.a), values(item.pair.b)
        expected = compare_two(b, a, "f_then_t", alpha=0.01)
        difference = item.result.welch_difference
        assert difference.ci_level == 0.99
        assert item.result.test == expected.test
        if item.quantity is Outcome.APEX:
            assert (difference.ci_low, difference.ci_high) == expected.welch_ci
        if item.by_day is not None:
            assert item.by_day.difference.ci_level == 0.99
        if item.equivalent is not None:
            assert item.equivalent.estimate.ci_level == pytest.approx(0.98)
    assert {c.savings.ci_level for c in made.content.comparisons if c.savings is not None} == {0.99}
    methods = "".join(made.content.methods)
    says(methods, "95 %", "those of comparisons", "99 %", "98 %")


def with_values(condition: ConditionValues, numbers: list[float]) -> tuple[ConditionValues, ...]:
    """The condition with a run for each of these numbers."""
    return (replace(condition, runs=tuple(replace(condition.runs[0], value=value) for value in numbers)),)


@pytest.mark.parametrize(("alpha", "test", "df"), [(0.05, "Welch", 500.0 / 82.0), (0.01, "Student", 10.0)])
def test_the_f_test_chooses_at_the_alpha_that_was_asked_for(
    reports: Reports, cache: ResultCache, alpha: float, test: str, df: float
) -> None:
    """Variances of 3.5 and 31.5 with n = 6: F(5, 5) = 9 has p = 0.031, and Welch's degrees of freedom are 500 / 82."""
    pair = compared(reports(), Outcome.APEX)[0].pair
    narrow, wide = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [3.0, 6.0, 9.0, 12.0, 15.0, 18.0]
    asked = replace(pair, a=with_values(pair.a[0], narrow), b=with_values(pair.b[0], wide))
    (row,) = compare(cache, [asked], Outcome.APEX, {"trial": alpha}, alpha)
    assert 0.01 < value_of(row.f_p) < 0.05
    assert row.test == test
    assert row.t.df == pytest.approx(df)
    assert row.difference.ci_level == pytest.approx(1.0 - alpha)


def test_brown_forsythe_and_the_sides_are_those_of_the_runs(reports: Reports) -> None:
    made = reports()
    for item in made.analysis.compared:
        a, b = values(item.pair.a), values(item.pair.b)
        expected = brown_forsythe({"b": b, "a": a})
        found = item.result.brown_forsythe
        if isinstance(found.value, float):
            assert found.value == expected.statistic
            assert item.result.brown_forsythe_p.value == expected.p
        assert item.result.mean_a.value == pytest.approx(sum(a) / len(a))
        assert item.result.sd_b.n == len(b)


def of_day_means(side: tuple[ConditionValues, ...]) -> list[float]:
    found: dict[str, list[float]] = {}
    for value, day in zip(values(side), days(side), strict=True):
        found.setdefault(day, []).append(value)
    return [sum(items) / len(items) for items in found.values()]


@pytest.mark.soak
def test_with_the_day_as_the_unit_comparisons_are_of_day_means(reports: Reports) -> None:
    made = reports('unit_of_analysis = "day"\napex_bounds_m = [-0.01, 0.01]')
    by_run = {(item.quantity, item.pair.label): item for item in reports().analysis.compared}
    for item in made.analysis.compared:
        a, b = of_day_means(item.pair.a), of_day_means(item.pair.b)
        assert len(a) == len(b) == 2
        expected = compare_two(b, a)
        assert item.result.difference.value == pytest.approx(expected.difference)
        if item.quantity is Outcome.APEX:
            assert item.result.welch_p.value == pytest.approx(expected.welch_p)
            assert item.equivalent is not None
            assert item.equivalent.p.value == pytest.approx(equivalence(b, a, low=-0.01, high=0.01).p)
        elif item.result.savings is not None:
            assert item.result.savings.value == pytest.approx(percent_savings(a, b).percent)
        if item.by_day is not None:
            as_runs = by_run[item.quantity, item.pair.label].by_day
            assert as_runs is not None
            assert item.by_day.difference.value == pytest.approx(as_runs.difference.value)
    for varied in made.analysis.variations.varied:
        assert (varied.result.difference.n or 0) <= 4
    page = quick_page(made.content).replace("\u00a0", " ")
    says(page, "n = 2", "2 treatment")
    says(page, "unit of analysis")


# --- what was planned, and what the report says that it did


def by_name(made: MadeReport) -> dict[tuple[Outcome, str], set[str]]:
    found: dict[tuple[Outcome, str], set[str]] = {}
    for item in made.content.comparisons:
        found.setdefault((item.quantity, item.family), set()).add(item.exploratory)
    return found


def test_what_was_not_decided_beforehand_is_called_exploratory_with_the_reason(reports: Reports) -> None:
    made = reports('primary_outcome = "joules"\nfamily = "pooled"\nunit_of_analysis = "run"', in_time=True)
    found = by_name(made)
    assert found.pop((Outcome.JOULES, POOLED)) == {""}
    assert all("" not in reasons for reasons in found.values())
    says([*found[Outcome.APEX, POOLED]], "primary outcome", "is joules")
    for claim in made.content.claims:
        assert ("an exploratory comparison" in claim.text) == claim.text.startswith("The apex")
    page = quick_page(made.content)
    says(page, "first measurement came")
    says(page, "Exploratory", "each level", "apex height")
    says(page, "pooled against", "(exploratory)")
    says(made.content.decided[1], "run is dated", "2021")
    assert made.content.decided[1] not in made.content.limitations
    said = "".join(made.content.not_planned)
    assert made.content.jump_comparisons
    says(said, "Exploratory", "the run", "not the jump", POOLED)
    for item in made.content.jump_comparisons:
        says(item.exploratory, "is the run", "not the jump")
    row = made.analysis.compared[0].result
    varied = replace(made.analysis, anovas=[VarianceAnalysed("all runs", {}, Outcome.JOULES, row)])
    says(not_planned(varied, made.content.comparisons)[-2], "analysis of variance")


def test_where_nothing_was_decided_all_is_exploratory_and_the_report_says_so(reports: Reports) -> None:
    made = reports()
    assert all("" not in reasons for reasons in by_name(made).values())
    assert all(", an exploratory" in claim.text or "cannot be told" in claim.text for claim in made.content.claims)
    says(quick_page(made.content), "Nothing was decided")


def test_a_family_of_one_test_is_left_as_it_is(reports: Reports) -> None:
    made = reports(where="foot == small")
    assert all(item.adjusted is None for item in made.analysis.compared)
    assert "Holm" not in "".join(made.content.methods)


def test_the_family_that_was_decided_on_comes_before_claims_of_another(reports: Reports) -> None:
    made = reports('family = "each"\nunit_of_analysis = "run"').content
    planned = [item for item in made.comparisons if item.family == EACH and item.adjusted is not None]
    shown = sum(item.adjusted_rejected is True for item in planned if item.quantity is Outcome.JOULES)
    first, *others = made.claims
    says(first.text, EACH, "difference is shown")
    assert f"{shown or 'none'} of " in first.text
    assert "pooled" not in first.text  # there is one treated level
    families = [
        {item.adjusted.provenance for item in planned if item.quantity is quantity and item.adjusted is not None}
        for quantity in (Outcome.JOULES, Outcome.APEX)
    ]
    assert [one in family for one, family in zip(first.provenance, families, strict=True)] == [True, True]  # one each
    assert all("exploratory" in claim.text for claim in others)
    assert not any("counted by Holm" in claim.text for claim in reports().content.claims)
