"""What an analysis recomputes, leaves out and says about it, on a small book."""

from __future__ import annotations

import json
import math
from dataclasses import fields, replace
from pathlib import Path

import pytest
from scipy import stats as scipy_stats

from data_schema.outcomes import Outcome
from data_schema.queries.study import PlannedRow
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.actions.report_command import state_report
from labbook.actions.runs.correcting import void
from labbook.analysis.comparison.comparing import compare
from labbook.analysis.comparison.deciding import DecisionResult
from labbook.analysis.comparison.robustness import WITHOUT_EXCLUSIONS, without_day
from labbook.analysis.outcomes.budget import budget
from labbook.analysis.outcomes.conditions import ConditionValues
from labbook.analysis.outcomes.run_energy import drain_lines, passive_drains, run_energies, unused_idle
from labbook.analysis.results.result_cache import ResultCache
from labbook.analysis.study import StudyAnalysis
from labbook.analysis.study_data import StudyData
from labbook.presenting.report.campaign import flow
from labbook.presenting.report.content import MadeReport
from labbook.presenting.report.methods import limitations
from reports.numbers import Number
from stats.compare.shared_error import SharedError
from stats.lines.passive_drain import PassiveDrain
from tests.helpers.books import ADA, reported_book, small_book
from tests.helpers.wording import says


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> MadeReport:
    folder: Path = tmp_path_factory.mktemp("study")
    with reported_book(folder).open() as book:
        return state_report(book, None, ADA, lambda _step: None)


@pytest.fixture
def analysis(made: MadeReport) -> StudyAnalysis:
    return made.analysis


def test_only_comparisons_of_joules_have_savings(analysis: StudyAnalysis) -> None:
    for item in analysis.compared:
        assert (item.result.savings is not None) == (item.quantity is Outcome.JOULES)


def test_sensitivity_as_reported_is_the_number_claimed(made: MadeReport) -> None:
    claimed = {uid for claim in made.content.claims for uid in claim.provenance}
    assert made.content.sensitivity
    assert {item.as_reported.provenance for item in made.content.sensitivity} <= claimed


def test_a_shared_error_that_differs_between_the_sides_widens_the_difference(analysis: StudyAnalysis) -> None:
    for item in analysis.compared:
        difference, p = item.result.welch_difference, item.result.welch_p.value
        assert (difference.shared_se is None) == (item.quantity is Outcome.APEX)
        assert item.result.difference.shared_se == difference.shared_se
        if isinstance(p, float) and isinstance(difference.ci_low, float) and isinstance(difference.ci_high, float):
            assert (p < 0.05) == (not difference.ci_low <= 0.0 <= difference.ci_high)


def side(condition: ConditionValues, df: float, *errors_j: float) -> tuple[ConditionValues, ...]:
    """The condition with a shared error of these sizes, a term each, known with `df` degrees of freedom."""
    shared = SharedError({("drain", f"{place}"): size for place, size in enumerate(errors_j)}, {"drain": df})
    return (replace(condition, runs=tuple(replace(item, shared=shared) for item in condition.runs)),)


@pytest.mark.parametrize("fit_df", [2.0, 3.0, 4.0, 20.0])
def test_what_remains_of_the_shared_error_joins_the_scatter_by_the_fits_degrees_of_freedom(
    tmp_path: Path, analysis: StudyAnalysis, fit_df: float
) -> None:
    """Below four in quadrature, each with its own quantile; else one quantile after Welch and Satterthwaite."""
    pair = next(item.pair for item in analysis.compared if item.quantity is Outcome.JOULES)
    a, b = pair.a[0], pair.b[0]
    pairs = [
        replace(pair, label=f"{errors_j}", a=side(a, fit_df, 1.0, 1.0), b=side(b, fit_df, *errors_j))
        for errors_j in ((1.0, 1.0), (1.0 + 1e-15, 1.0), (31.0, 1.0), (1.0, -29.0))
    ]
    with small_book(tmp_path).open() as book, book.reading() as connection:
        rows = compare(ResultCache(connection), pairs, Outcome.JOULES, {})
    equal, rounded, unequal, opposite = [row.welch_difference for row in rows]
    assert equal.shared_se == rounded.shared_se == 0.0
    assert (equal.ci_low, equal.ci_high) == (rounded.ci_low, rounded.ci_high)
    assert unequal.shared_se == opposite.shared_se == 30.0
    assert unequal.value == equal.value
    assert isinstance(equal.df, float)
    quantile = scipy_stats.t.ppf
    variance = (half_width(equal) / quantile(0.975, equal.df)) ** 2
    if fit_df < 4.0:
        expected = math.hypot(half_width(equal), quantile(0.975, fit_df) * 30.0)
    else:
        total_df = (variance + 900.0) ** 2 / (variance**2 / equal.df + 900.0**2 / fit_df)
        expected = quantile(0.975, total_df) * math.sqrt(variance + 900.0)
    assert half_width(unequal) == pytest.approx(expected)
    assert half_width(unequal) > half_width(equal)


def test_each_robot_has_its_own_drain_line(analysis: StudyAnalysis) -> None:
    evidence = analysis.evidence
    assert [drain.robot for drain in analysis.drains.values()] == ["hopper"]
    others = tuple(replace(run, robot="other", robot_uid="other", uid=f"{run.uid}b") for run in evidence.idle)
    charges = {f"{uid}b": [replace(item, charge_mah=2 * item.charge_mah) for item in charges]
               for uid, charges in evidence.charges.items()}  # fmt: skip
    both = replace(evidence, idle=(*evidence.idle, *others), charges={**evidence.charges, **charges})
    (one,) = drain_lines(evidence).values()
    first, second = drain_lines(both).values()
    assert isinstance(first, PassiveDrain)
    assert isinstance(second, PassiveDrain)
    assert first == one
    assert second.slope_mah_s == pytest.approx(2 * first.slope_mah_s)


def test_a_run_of_a_robot_without_idle_runs_has_no_joules(tmp_path: Path, analysis: StudyAnalysis) -> None:
    evidence = analysis.evidence
    first, *rest = evidence.runs
    moved = replace(evidence, runs=(replace(first, robot="other", robot_uid="other"), *rest))
    with small_book(tmp_path).open() as book, book.reading() as connection:
        cache = ResultCache(connection)
        found = run_energies(cache, moved, passive_drains(cache, moved))
    assert found.missing == {first.uid: Undefined(Reason.NO_DRAIN_FIT, robot="other")}
    assert set(found.results) == {run.uid for run in rest}


def test_without_exclusions_void_runs_are_back(tmp_path: Path) -> None:
    with reported_book(tmp_path).open() as book:
        before = state_report(book, None, ADA, lambda _step: None).analysis
        with book.session(ADA) as session:
            void(session, "r002", "rail loose")
        after = state_report(book, None, ADA, lambda _step: None).analysis
    as_first = {(item.pair.label, item.quantity): item.decided.result for item in before.compared if item.decided}
    without = [item for item in after.variations.varied if item.variant == WITHOUT_EXCLUSIONS]
    assert {item.quantity for item in without} == {Outcome.JOULES, Outcome.APEX}
    for item in without:
        first = as_first[item.headline, item.quantity]
        assert isinstance(item.result, DecisionResult)
        assert (item.result.n_control, item.result.n_treated) == (first.n_control, first.n_treated)
        if item.quantity is Outcome.JOULES:
            for number, before in zip(numbers_of(item.result), numbers_of(first), strict=True):
                assert number.n == before.n
                assert number.value == pytest.approx(before.value)


def numbers_of(result: DecisionResult) -> list[Number]:
    found = [getattr(result, one.name) for one in fields(result)]
    return [number for number in found if isinstance(number, Number)]


def half_width(item: Number) -> float:
    assert isinstance(item.ci_low, float)
    assert isinstance(item.ci_high, float)
    return (item.ci_high - item.ci_low) / 2.0


def test_the_budget_takes_the_coarsest_resolution_of_the_charges(tmp_path: Path, analysis: StudyAnalysis) -> None:
    evidence = analysis.evidence
    condition = max(analysis.conditions[Outcome.JOULES], key=lambda item: len(item.runs))
    uid = condition.runs[0].run.uid
    (charge,) = evidence.charges[uid]
    coarse = replace(evidence, charges={**evidence.charges, uid: [replace(charge, resolution_mah=1000.0)]})
    with small_book(tmp_path).open() as book, book.reading() as connection:
        row = budget(ResultCache(connection), coarse, analysis.conditions[Outcome.JOULES], {})
    assert row is not None
    assert analysis.budget is not None
    larger = [
        name
        for name, item in row.one_run.items()
        for before in [analysis.budget.one_run[name].value]
        if isinstance(item.value, float) and isinstance(before, float) and item.value > 100.0 * before
    ]
    assert any("resolution" in name or "charger" in name for name in larger), [*row.one_run]


def test_leaving_a_day_out_leaves_its_idle_runs_out_of_the_drain_line(analysis: StudyAnalysis) -> None:
    evidence = analysis.evidence
    first, second = sorted({run.day for run in evidence.runs})
    # Three idle runs on the second day, so that a line remains.
    idle = tuple(replace(run, day=second if index else first) for index, run in enumerate(evidence.idle))
    rest = without_day(replace(evidence, idle=idle), first)
    assert {run.day for run in (*rest.runs, *rest.idle)} == {second}
    (whole,), (refitted,) = drain_lines(evidence).values(), drain_lines(rest).values()
    assert isinstance(whole, PassiveDrain)
    assert isinstance(refitted, PassiveDrain)
    assert refitted.n == whole.n - 1
    assert refitted.slope_mah_s != whole.slope_mah_s


def test_a_day_that_is_left_out_stores_one_result_an_estimate(made: MadeReport) -> None:
    """Neither the lines nor the joules by them, which would be every run again for every day."""
    rows = {row.uid: row for row in (*made.cache.computed.values(), *made.cache.reused.values())}
    scopes = {uid: json.loads(row.scope_json) for uid, row in rows.items()}
    without = [uid for uid, scope in scopes.items() if scope.get("variant", "").startswith("without 2")]
    assert without
    assert {rows[uid].kind for uid in without} <= {"decision", "comparison"}
    for uid in without:
        (whole,) = [one for one in rows[uid].inputs if one.role == "all days"]
        assert {**scopes[whole.input_uid], "variant": scopes[uid]["variant"]} == scopes[uid]
        assert {one.role for one in rows[uid].inputs} == {"all days", "left out"}


def doubled(evidence: StudyData, *names: str) -> StudyData:
    """The evidence with a second charge for some runs."""
    uids = {run.uid for run in (*evidence.runs, *evidence.idle) if run.name in names}
    return replace(
        evidence,
        charges={uid: items * 2 if uid in uids else items for uid, items in evidence.charges.items()},
    )


def test_conflicting_charges_are_named_with_the_way_out(analysis: StudyAnalysis) -> None:
    one = limitations(replace(analysis, evidence=doubled(analysis.evidence, "r007")))
    two = limitations(replace(analysis, evidence=doubled(analysis.evidence, "r001", "r007")))
    says(one, "1 run", "conflicting charges", "r007")
    (note,) = [note for note in two if "conflicting" in note]
    says(note, "2 runs", "r001", "r007", "labbook correct charge:UID")
    assert not any("conflicting" in note for note in limitations(analysis))


def test_a_charge_that_was_added_conflicts_with_none(analysis: StudyAnalysis) -> None:
    evidence = doubled(analysis.evidence, "r007")
    added = {
        uid: [*items[:1], *(replace(item, added=1) for item in items[1:])] for uid, items in evidence.charges.items()
    }
    notes = limitations(replace(analysis, evidence=replace(evidence, charges=added)))
    assert notes == limitations(analysis)


def test_runs_with_a_log_of_the_same_samples_are_named(analysis: StudyAnalysis) -> None:
    evidence = analysis.evidence
    uids = {run.name: run.uid for run in evidence.runs}
    logs = {**evidence.logs, uids["r002"]: evidence.logs[uids["r001"]]}
    notes = limitations(replace(analysis, evidence=replace(evidence, logs=logs)))
    says(notes, "r001, r002", "same samples", "labbook files withdraw")


def test_runs_charged_with_less_than_the_passive_charge_are_named(analysis: StudyAnalysis) -> None:
    evidence = analysis.evidence
    uids = {run.uid for run in evidence.runs if run.name in ("r001", "r002")}
    little = {
        uid: [replace(item, charge_mah=10.0) for item in items] if uid in uids else items
        for uid, items in evidence.charges.items()
    }
    notes = limitations(replace(analysis, evidence=replace(evidence, charges=little)))
    says(notes, "below the passive charge", "2 runs (r001, r002)")
    assert not any("below the passive charge" in note for note in limitations(analysis))


def test_idle_runs_that_are_not_in_the_fit_are_listed_with_the_reason(analysis: StudyAnalysis) -> None:
    evidence = analysis.evidence
    first, second, *others = evidence.idle
    lacking = replace(
        evidence,
        idle=(replace(first, duration_s=None), second, *others),
        charges={uid: items for uid, items in evidence.charges.items() if uid != second.uid},
    )
    assert unused_idle(lacking)[0][1] == Undefined(Reason.NO_DURATION)
    notes = limitations(replace(analysis, evidence=lacking))
    says(notes, "1 idle", first.name)
    says(notes, "1 idle", second.name)


def test_planned_runs_are_those_of_the_selected_conditions(analysis: StudyAnalysis) -> None:
    keys = list(dict.fromkeys(run.condition_key for run in analysis.evidence.runs))
    planned = [PlannedRow(f"p{i}", f"p{i}", i, 1, "1", key, None) for i, key in enumerate([*keys, None])]
    assert flow(analysis, planned).runs_planned == len(keys) + 1
    runs = tuple(run for run in analysis.evidence.runs if run.condition_key == keys[0])
    evidence = replace(analysis.evidence, selection="foot=small", selected=runs, runs=runs)
    assert flow(replace(analysis, evidence=evidence), planned).runs_planned == 1
    assert flow(analysis, planned, {"p8", "p9"}).runs_withdrawn == 2


@pytest.mark.parametrize("selection", ["day=2021-06-14", "foot=small and not (run in (r001, r002) or foot=large)"])
def test_no_planned_count_stands_beside_a_selection_that_no_plan_knows(analysis: StudyAnalysis, selection: str) -> None:
    """The plan has conditions, but neither the days nor the runs that were made."""
    planned = [PlannedRow("p1", "p1", 1, 1, "1", analysis.evidence.runs[0].condition_key, None)]
    counted = flow(replace(analysis, evidence=replace(analysis.evidence, selection=selection)), planned, {"p9"})
    assert (counted.runs_planned, counted.runs_withdrawn) == (None, 0)


def test_a_day_that_the_drain_line_cannot_do_without_is_said(analysis: StudyAnalysis) -> None:
    days = sorted({run.day for run in analysis.evidence.runs})
    (note,) = [note for note in limitations(analysis) if note.startswith("Without the idle runs")]
    assert all(day in note for day in days)
    assert {item.quantity for item in analysis.variations.varied if item.variant == f"without {days[0]}"} == {
        Outcome.APEX
    }


def test_single_jumps_are_tested_as_the_thesis_did_and_over_all_jumps_that_count(analysis: StudyAnalysis) -> None:
    assert len(analysis.jump_tests) == 2
    for item in analysis.jump_tests:
        sides = [
            [height for one in side for run in one.runs for height in analysis.apexes[run.run.uid].heights_m]
            for side in (item.pair.a, item.pair.b)
        ]
        assert [len(side) for side in sides] == [item.result.n_a, item.result.n_b]
        assert len(sides[0]) > sum(len(one.runs) for one in item.pair.a)
        expected = scipy_stats.ttest_ind(sides[1], sides[0], equal_var=False)
        assert item.result.welch_t.value == pytest.approx(expected.statistic)
        assert item.result.welch_p.value == pytest.approx(expected.pvalue)
