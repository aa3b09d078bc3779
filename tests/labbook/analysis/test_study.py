"""What an analysis recomputes, leaves out and says about it, on a small book."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from data_schema.outcomes import Outcome
from data_schema.queries.study import PlannedRow
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from labbook.actions.runs.correcting import void
from labbook.analysis.comparison.robustness import WITHOUT_EXCLUSIONS, without_day
from labbook.analysis.measured import Measured, flow
from labbook.analysis.methods import limitations
from labbook.analysis.outcomes.budget import budget
from labbook.analysis.outcomes.run_energy import drain_lines, passive_drains, run_energies, unused_idle
from labbook.analysis.results import Results
from labbook.analysis.study import Analysis
from reports.numbers import Number
from reports.results import Decision
from stats.lines.passive_drain import PassiveDrain
from tests.helpers.books import ADA, reported_book
from tests.helpers.decided import reports
from tests.helpers.wording import says

Change = Callable[[Measured], Measured]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Analysis:
    return reports(reported_book(tmp_path_factory.mktemp("study")))


@pytest.fixture
def measured(made: Analysis) -> Measured:
    return made.measured


def test_sensitivity_as_reported_is_the_number_claimed(made: Analysis) -> None:
    claimed = {uid for claim in made.results.claims for uid in claim.provenance}
    assert made.results.headlines
    assert {one.decision.headline.provenance for one, _varied in made.results.headlines} <= claimed


def test_each_robot_has_its_own_drain_line(measured: Measured) -> None:
    evidence = measured.evidence
    assert [drain.robot for drain in measured.drains.values()] == ["hopper"]
    others = tuple(replace(run, robot="other", robot_uid="other", uid=f"{run.uid}b") for run in evidence.idle)
    charges = dict(evidence.charges)
    for run in evidence.idle:
        charges[f"{run.uid}b"] = [replace(item, charge_mah=2 * item.charge_mah) for item in charges[run.uid]]
    both = replace(evidence, idle=(*evidence.idle, *others), charges=charges)
    (one,) = drain_lines(evidence).values()
    first, second = drain_lines(both).values()
    assert isinstance(first, PassiveDrain)
    assert isinstance(second, PassiveDrain)
    assert first == one
    assert second.slope_mah_s == pytest.approx(2 * first.slope_mah_s)


def test_a_run_of_a_robot_without_idle_runs_has_no_joules(measured: Measured) -> None:
    evidence = measured.evidence
    first, *rest = evidence.runs
    moved = replace(evidence, runs=(replace(first, robot="other", robot_uid="other"), *rest))
    computed = Results()
    found = run_energies(computed, moved, passive_drains(computed, moved))
    assert found.missing == {first.uid: Undefined(Reason.NO_DRAIN_FIT, robot="other")}
    assert set(found.results) == {run.uid for run in rest}


def test_without_exclusions_void_runs_are_back(made: Analysis, tmp_path: Path) -> None:
    other = reported_book(tmp_path)
    with other.open() as book, book.session(ADA) as session:
        void(session, "r002", "rail loose")
    as_first = {(item.label, item.quantity): item.decision for item in made.results.comparisons}
    without = [item for item in reports(other).results.variations if item.variant == WITHOUT_EXCLUSIONS]
    assert {item.quantity for item in without} == {Outcome.JOULES, Outcome.APEX}
    for item in without:
        first = as_first[item.headline, item.quantity]
        assert (item.result.n_control, item.result.n_treatment) == (first.n_control, first.n_treatment)
        if item.quantity is Outcome.JOULES:
            for number, before in zip(numbers_of(item.result), numbers_of(first), strict=True):
                assert (number.n, number.value) == (before.n, pytest.approx(before.value))


def numbers_of(result: Decision) -> list[Number]:
    found = (result.difference, result.t, result.p, result.control_mean, result.run_sd, result.savings)
    return [number for number in found if number is not None]


def test_the_budget_takes_the_coarsest_resolution_of_the_charges(made: Analysis, measured: Measured) -> None:
    evidence = measured.evidence
    condition = max(measured.conditions[Outcome.JOULES], key=lambda item: len(item.runs))
    uid = condition.runs[0].run.uid
    (charge,) = evidence.charges[uid]
    coarse = replace(evidence, charges={**evidence.charges, uid: [replace(charge, resolution_mah=1000.0)]})
    row = budget(Results(), coarse, measured.conditions[Outcome.JOULES])
    assert row is not None
    assert made.results.budget is not None
    (name,) = (name for name in row.one_run if "resolution" in name or "charger" in name)
    before, after = (each.one_run[name].value for each in (made.results.budget, row))
    assert isinstance(before, float)
    assert isinstance(after, float)
    assert after > 100.0 * before


def test_leaving_a_day_out_leaves_its_idle_runs_out_of_the_drain_line(measured: Measured) -> None:
    evidence = measured.evidence
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


def charged(names: Sequence[str], change: Callable[[list[Any]], list[Any]]) -> Change:
    """Let runs have other charges."""

    def changed(measured: Measured) -> Measured:
        evidence = measured.evidence
        uids = {run.uid for run in (*evidence.runs, *evidence.idle) if run.name in names}
        found = {uid: change([*items]) if uid in uids else items for uid, items in evidence.charges.items()}
        return replace(measured, evidence=replace(evidence, charges=found))

    return changed


def with_the_log_of_another(measured: Measured) -> Measured:
    logs, uids = measured.evidence.logs, {run.name: run.uid for run in measured.evidence.runs}
    logs = {**logs, uids["r002"]: logs[uids["r001"]]}
    return replace(measured, evidence=replace(measured.evidence, logs=logs))


def without_heights(*names: str) -> Change:
    def changed(measured: Measured) -> Measured:
        missing = {run.uid: Undefined(Reason.NO_HEIGHT_LOG) for run in measured.evidence.runs if run.name in names}
        apexes = replace(measured.results[Outcome.APEX], missing=missing)
        return replace(measured, results={**measured.results, Outcome.APEX: apexes})

    return changed


def made_jumps(jumps: int) -> Change:
    def changed(measured: Measured) -> Measured:
        runs = tuple(replace(run, jumps_made=jumps) if run.name == "r002" else run for run in measured.evidence.runs)
        return replace(measured, evidence=replace(measured.evidence, runs=runs))

    return changed


def added(charges: list[Any]) -> list[Any]:
    return [*charges, *(replace(each, added=1) for each in charges)]


@pytest.mark.parametrize(
    ("change", "facts"),
    [
        (charged(["r007"], lambda charges: charges * 2), ["1 idle run", "2 charges", "r007"]),
        (charged(["r007"], added), []),
        (
            charged(["r001", "r002"], lambda charges: [replace(each, charge_mah=10.0) for each in charges]),
            ["below the passive charge", "2 runs (r001, r002)"],
        ),
        (with_the_log_of_another, ["r001, r002", "same samples", "labbook files withdraw"]),
        (without_heights("r005"), ["1 run (r005) has", "no apex heights"]),
        (without_heights("r002", "r005"), ["2 runs (r002, r005) have", "no apex heights"]),
        (made_jumps(5), ["jumps found", "1 run", "not the jumps", "r002", "3", "5"]),
        (made_jumps(0), ["jumps found", "1 run", "not the jumps", "r002", "3 of 0", "labbook correct"]),
    ],
)
def test_runs_whose_facts_are_in_doubt_are_named_with_the_way_out(
    measured: Measured, change: Change, facts: list[str]
) -> None:
    further = [note for note in limitations(change(measured)) if note not in limitations(measured)]
    assert len(further) == bool(facts), further
    says(further, *facts)


def test_idle_runs_that_are_not_in_the_fit_are_listed_with_the_reason(measured: Measured) -> None:
    evidence = measured.evidence
    first, second, *others = evidence.idle
    lacking = replace(
        evidence,
        idle=(replace(first, duration_s=None), second, *others),
        charges={uid: items for uid, items in evidence.charges.items() if uid != second.uid},
    )
    assert unused_idle(lacking)[0][1] == Undefined(Reason.NO_DURATION)
    notes = limitations(replace(measured, evidence=lacking))
    for run in (first, second):
        says(notes, "1 idle", run.name)


def test_planned_runs_are_those_of_the_selected_conditions(measured: Measured) -> None:
    keys = list(dict.fromkeys(run.condition_key for run in measured.evidence.runs))
    planned = [PlannedRow(f"p{i}", f"p{i}", i, "1", key, None) for i, key in enumerate([*keys, None])]
    assert flow(measured, planned).runs_planned == len(keys) + 1
    runs = tuple(run for run in measured.evidence.runs if run.condition_key == keys[0])
    evidence = replace(measured.evidence, selection="foot=small", selected=runs, runs=runs)
    assert flow(replace(measured, evidence=evidence), planned).runs_planned == 1
    assert flow(measured, planned, {"p8", "p9"}).runs_withdrawn == 2
    # The plan has conditions, but neither the days nor the runs that were made.
    for selection in ("day=2021-06-14", "foot=small and not (run in (r001, r002) or foot=large)"):
        selected = replace(measured, evidence=replace(measured.evidence, selection=selection))
        counted = flow(selected, planned, {"p9"})
        assert (counted.runs_planned, counted.runs_withdrawn) == (None, 0)


def test_a_day_that_the_drain_line_cannot_do_without_is_said(made: Analysis, measured: Measured) -> None:
    days = sorted({run.day for run in measured.evidence.runs})
    (note,) = [note for note in made.results.limitations if note.startswith("Without the idle runs")]
    assert all(day in note for day in days)
    assert {item.quantity for item in made.results.variations if item.variant == f"without {days[0]}"} == {Outcome.APEX}
