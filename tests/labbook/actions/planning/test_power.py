"""How many runs a study needs: R's numbers through the whole command, and what is taken from the book's own runs."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

from data_schema.errors import UsageError
from data_schema.rounding import number_text
from data_schema.vocabulary import Undefined
from labbook.actions.planning.asked import PlanRequest, PowerRequest
from labbook.actions.planning.plan import make_plan
from labbook.actions.planning.power import Needed, StudyPower, power_foot, power_table, study_power
from labbook.actions.planning.power_tests import Assumed
from labbook.demo.truth import Condition
from stats.lines.passive_drain import PassiveDrain, fit_passive_drain
from stats.planning.power import power_equivalence_by_day
from tests.helpers.books import ADA, TRUTH, SmallBook, small_book, small_runs
from tests.helpers.statements import said_alike
from tests.helpers.wording import refuses, says

R = Path(__file__).parents[3] / "stats" / "r" / "power.csv"
EACH = '\n[analysis]\nfamily = "each"\nalpha = {alpha:g}\n'


def asked(**given: Any) -> PowerRequest:
    lists = {name: [given.pop(name)] for name in ("sd", "mean", "n") if given.get(name) is not None}
    return PowerRequest(**{**given, **lists})


def power_of(made: SmallBook, analysis: str = "", gains: str = "[0, 100]", **given: float | int | None) -> StudyPower:
    text = made.toml.read_text().split("\n[analysis]")[0].replace("levels = [0, 100]", f"levels = {gains}")
    made.toml.write_text(text + analysis)
    with made.open() as book:
        before = len(said_alike(book))
        found = study_power(book, asked(**given))
        assert len(said_alike(book)) == before
    return found


def joules_drawn() -> dict[Condition, list[float]]:
    """Joules a jump of the small book's runs by condition, from what the charger showed."""
    idle = [run for run in small_runs() if run.condition is None]
    drain = fit_passive_drain([run.duration_s for run in idle], [run.charge_mah for run in idle])
    assert isinstance(drain, PassiveDrain)
    found: dict[Condition, list[float]] = {}
    for run in small_runs():
        if run.condition is not None:
            active_mah = run.charge_mah - drain.at(run.duration_s).charge_mah
            found.setdefault(run.condition, []).append(3.6 * TRUTH.reference_voltage_v * active_mah / run.jumps_made)
    return found


def row(found: StudyPower, begin: str) -> Needed:
    (item,) = [item for item in found.needed if item.test.startswith(begin)]
    return item


@pytest.fixture
def fresh(tmp_path: Path) -> SmallBook:
    return small_book(tmp_path, runs=False, ingested=False)


def test_equal_apexes_are_planned_by_the_shared_days_where_these_decide(fresh: SmallBook) -> None:
    """Four days hold 12 controls and 12 treated runs a group: paired on day means, by what each day holds."""
    bounds = "\n[analysis]\napex_bounds_percent = [-3, 3]\n"
    found = power_of(fresh, bounds, n=12, difference=1.0, sd=1.0, apex_sd=0.008, apex_mean=0.3)
    equal = row(found, "no loss")
    layouts = [(4, 4), (3, 3), (4, 4), (1, 1)], [(4, 4), (2, 2), (4, 4), (2, 2)]
    powers = [power_equivalence_by_day(0.008, -3.0, 3.0, layout, control_mean=0.3).power for layout in layouts]
    assert equal.powers[12] == min(powers)
    assert "the equivalence test (TOST) by " in equal.sentence
    assert "shared days between -3 and 3 % of the control's mean, itself estimated" in equal.sentence


def test_anova_over_the_treated_levels_needs_what_r_says(fresh: SmallBook) -> None:
    """R: power.anova.test(groups = 4, between.var = 1, within.var = 3): n = 11.92613 for 0.80, 0.3535594 at n = 5."""
    gains = "[0, 50, 100, 150, 200]"
    found = power_of(fresh, "", gains, difference=math.sqrt(6.0), sd=math.sqrt(3.0), n=5)
    assert row(found, "ANOVA over 4").n == 12
    assert row(found, "ANOVA over 4").powers[5] == pytest.approx(0.3535594, abs=1e-7)


def test_pooled_levels_count_together_and_holm_costs_runs(fresh: SmallBook) -> None:
    gains = "[0, 50, 100, 150, 200]"
    pooled = power_of(fresh, "", gains, difference=1.0, sd=1.0, n=7)
    assert row(pooled, "by shared days, Holm over 2").alpha == 0.025
    each = power_of(fresh, EACH.format(alpha=0.05), gains, difference=1.0, sd=1.0, n=7)
    strict, loose = row(each, "by shared days, Holm over 8"), each.needed[0]
    assert strict.alpha == 0.05 / 8
    assert isinstance(strict.n, int)
    assert isinstance(loose.n, int)
    assert strict.n > loose.n


def test_runs_and_days_are_those_of_a_plan_that_is_drawn(fresh: SmallBook) -> None:
    found = power_of(fresh, difference=1.0, sd=1.0, per_day=8)
    needed = found.needed[0]
    assert isinstance(needed.n, int)
    with fresh.open() as book:
        sheet = fresh.folder / "runs.csv"
        drawn = make_plan(book, 5, PlanRequest(needed.n, 8, start="2021-06-01", out=sheet), ADA)
    assert (needed.runs, needed.days) == (drawn.runs, drawn.days)
    again = power_of(fresh, difference=1.0, sd=1.0, n=4, per_day=8)
    assert again.n_of_plan == needed.n
    assert sorted(again.needed[0].powers) == [4, needed.n]
    assert 0.8 <= again.needed[0].powers[needed.n] < 0.95


def test_the_scatter_is_that_of_the_runs_so_far(tmp_path: Path) -> None:
    made = small_book(tmp_path)
    found = power_of(made, "\n[analysis]\napex_bounds_percent = [-3, 3]\n", saving=10.0)
    joules = joules_drawn()
    squares = sum(float(np.var(values)) * len(values) for values in joules.values())
    df = sum(len(values) - 1 for values in joules.values())
    spread = found.primary.spread
    assert spread is not None
    assert (spread.n, spread.df, spread.control_n) == (12, df, 6)
    assert found.primary.sd == pytest.approx(math.sqrt(squares / df), rel=1e-12)
    low, high = (math.sqrt(squares / stats.chi2.ppf(p, df)) for p in (0.975, 0.025))
    assert (spread.sd_low, spread.sd_high) == pytest.approx((low, high), rel=1e-12)
    control = np.mean([value for condition, values in joules.items() if condition.is_control for value in values])
    assert found.difference == pytest.approx(0.1 * control, rel=1e-12)
    first = found.needed[0]
    assert first.n_over_sd is not None
    assert isinstance(first.n, int)
    assert list(first.n_over_sd) == sorted(first.n_over_sd)  # type: ignore[type-var]
    equal = row(found, "no loss")
    assert isinstance(found.apex, Assumed)
    assert not isinstance(found.apex.mean, Undefined)
    mean = number_text(found.apex.mean, error=found.apex.sd)
    says(equal.sentence, "-3", "3 %", "itself estimated and", mean, "in truth")
    says(equal.note, "of is estimated")
    assert equal.n_over_sd is not None


def test_apexes_as_the_primary_outcome_are_planned_in_metres(tmp_path: Path) -> None:
    made = small_book(tmp_path)
    analysis = '\n[analysis]\nprimary_outcome = "apex"\napex_bounds_m = [-0.005, 0.005]\n'
    found = power_of(made, analysis, difference=0.003)
    assert found.apex is found.primary
    assert found.unit == "m"
    assert 0.001 < found.primary.sd < 0.005
    with refuses(UsageError, "--saving"):
        power_of(made, analysis, saving=10.0)


def test_what_cannot_be_known_is_said(fresh: SmallBook) -> None:
    bounds = "\n[analysis]\napex_bounds_percent = [-3, 3]\n"
    found = power_of(fresh, bounds, saving=10.0, sd=4.0, mean=42.0)
    equal = row(found, "no loss")
    assert isinstance(equal.n, Undefined)
    says(equal.sentence, "no condition has", "--apex-sd", "--apex-mean")
    says(power_foot(found), "apex height (TOST")
    assert power_table(found)[1][-1][2:] == ("-", "", "-", "-", "-")
    no_mean = power_of(fresh, bounds, saving=10.0, sd=4.0, mean=42.0, apex_sd=0.002)
    says(row(no_mean, "no loss").sentence, "--apex-mean")
    with refuses(UsageError, "expected standard deviation", "--sd"):
        power_of(fresh, difference=4.0)
    with refuses(UsageError, "--mean", "--difference"):
        power_of(fresh, saving=10.0, sd=4.0)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "needs one effect"),
        ({"saving": 10.0, "difference": 4.0}, "needs one effect"),
        ({"saving": 100.0}, "--saving 100 is no saving"),
        ({"difference": 0.0}, "--difference 0 is none"),
        ({"difference": math.inf}, "--difference inf is none"),
        ({"difference": 4.0, "sd": 0.0}, "--sd 0 is not possible"),
        ({"difference": 4.0, "sd": math.nan}, "--sd nan is not possible"),
        ({"difference": 4.0, "sd": 1.0, "power": 1.0}, "--power 1 is no chance"),
        ({"difference": 4.0, "sd": 1.0, "n": 1}, "--n 1 has no scatter"),
        ({"difference": 4.0, "sd": 1.0, "per_day": 0}, "0 runs a day is too few"),
    ],
)
def test_what_no_study_has_is_refused(fresh: SmallBook, given: dict[str, float], said: str) -> None:
    with pytest.raises(UsageError, match=said):
        power_of(fresh, **given)
