"""Power against R, PowerTOST and mpmath; that of the test by shared days against campaigns drawn and tested."""

from __future__ import annotations

import csv
import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from scipy import special

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.days.decision import contrast_by_day
from stats.planning.power import (
    Power,
    power_anova,
    power_by_day,
    power_equivalence,
    power_equivalence_by_day,
    power_t,
    power_welch,
    sample_size,
)
from tests.helpers.wording import refuses, says

with (Path(__file__).parents[1] / "r" / "power.csv").open() as file:
    ROWS = list(csv.DictReader(file))


def planned(row: dict[str, str]) -> Power:
    number = {name: float(text) for name, text in row.items() if name not in ("test", "means") and text}
    if row["test"] == "anova":
        return power_anova([float(x) for x in row["means"].split()], number["sd"], int(number["n_a"]), number["alpha"])
    sizes = int(number["n_a"]), int(number["n_b"])
    return power_t(number["difference"], number["sd"], *sizes, number["alpha"], int(number["sides"]))


BOUNDS = {"t": 1e-8, "anova": 2e-9}
"""What R itself is good to: its noncentral F sums until 1e-9 is left, its integrals stop at 1e-9 to 1e-11."""


@pytest.mark.parametrize("test", BOUNDS)
def test_agrees_with_r(test):
    rows = [row for row in ROWS if row["test"] == test]
    assert len(rows) >= 15
    for row in rows:
        assert planned(row).power == pytest.approx(float(row["power"]), abs=BOUNDS[test]), row


def test_without_effect_tests_reject_at_alpha():
    assert power_anova([1.0, 1.0, 1.0], 2.0, 4).power == pytest.approx(0.05, rel=1e-12)
    assert power_welch(0.0, 1.5, 1.0, 3, 10).power == pytest.approx(0.05, rel=1e-12)


@pytest.mark.parametrize(("sds", "sizes"), [((1.0, 1.0), (8, 8)), ((1.0, 2.0), (6, 12))])
def test_welchs_power_is_nearly_that_of_simulated_studies(sds, sizes):
    studies, rng = 100_000, np.random.default_rng(64)
    a, b = (rng.normal(0.0, sd, (studies, n)) for sd, n in zip(sds, sizes, strict=True))
    part_a, part_b = a.var(axis=1, ddof=1) / sizes[0], b.var(axis=1, ddof=1) / sizes[1]
    df = (part_a + part_b) ** 2 / (part_a**2 / (sizes[0] - 1) + part_b**2 / (sizes[1] - 1))
    t = (1.5 + a.mean(axis=1) - b.mean(axis=1)) / np.sqrt(part_a + part_b)
    found = float(np.mean(np.abs(t) > -special.stdtrit(df, 0.025)))
    assert power_welch(1.5, *sds, *sizes).power == pytest.approx(found, abs=0.01)


def test_large_samples_and_far_tails():
    for plan, ncp in (
        (power_t(0.005, 1.0, 1_000_000, 1_000_000), 0.005 / math.sqrt(2e-6)),
        (power_welch(0.01, 1.0, 2.0, 100_000, 50_000), 0.01 / math.sqrt(1e-5 + 8e-5)),
    ):
        normal = special.ndtr(ncp - 1.959963985) + special.ndtr(-ncp - 1.959963985)
        assert plan.power == pytest.approx(normal, rel=1e-4)
    assert power_equivalence(1.0, -1.0, 1.0, 2, 2, 1e-6).power < 1e-6
    assert power_equivalence(1.0, -1.0, 1.0, 50, 50, difference=5.0).power == pytest.approx(0.0, abs=1e-12)


def test_the_search_for_a_sample_size_plans_each_size_once():
    asked = []

    def plan(n: int) -> Power:
        asked.append(n)
        return power_t(0.5, 1.0, n, n)

    assert sample_size(plan).plan.group_ns == (64, 64)  # textbook, for d = 0.5 at 80 %
    assert sorted(asked) == sorted(set(asked))


def test_a_power_below_1_is_never_told_as_100_percent():
    says(power_t(0.5, 1.0, 649, 649).sentence(), "chance of over", "99.9 %")
    # whether a tail of 1e-16 rounds a power to 1 depends on the processor
    says(dataclasses.replace(power_t(1e9, 1.0, 5, 5), power=1.0).sentence(), "has a chance", "100 %")
    said = power_t(4.268321, 0.3247491, 5, 5, 0.05 / 3).sentence()
    says(said, "for a difference", "4.27", "0.325", "0.0167")  # in the digits that the scatter needs


def test_a_search_among_no_plans_is_refused():
    with refuses(InputRefused, "0", "give a whole", "2"):
        sample_size(lambda n: power_t(0.5, 1.0, n, n), largest=0)


def test_sample_sizes_that_are_never_enough():
    for plan, reason in (
        (lambda n: power_t(0.0, 1.0, n, n), "the true difference is 0"),
        (lambda n: power_t(-1.0, 1.0, n, n, sides=1), "the true difference -1 lies below 0 and the one-sided test"),
        (lambda n: power_anova([2.0, 2.0, 2.0], 1.0, n), "the true means are equal"),
        (lambda n: power_equivalence(1.0, -1.0, 1.0, n, n, difference=2.0), "difference 2 does not lie between"),
        (lambda n: power_t(1e-3, 1.0, n, n), "the search ended at n = 1000"),
    ):
        never = sample_size(plan, largest=1000)
        assert isinstance(never.plan, Undefined)
        assert reason in never.plan.reason
        assert never.n == never.plan
        says(never.sentence(), "No n was", "80 %", never.plan.reason)
    assert sample_size(lambda n: power_t(0.0, 1.0, n, n), 0.04).n == 2  # alpha itself is reached
    assert sample_size(lambda n: power_t(50.0, 1.0, n, n)).plan == power_t(50.0, 1.0, 2, 2)
    for target in (0.5, 0.9, 0.99):
        plan = sample_size(lambda n: power_welch(1.0, 1.0, 2.0, n, 2 * n), target).plan
        assert plan.power >= target > power_welch(1.0, 1.0, 2.0, plan.group_ns[0] - 1, 2 * plan.group_ns[0] - 2).power


def test_what_no_plan_can_be_is_refused():
    for wrong in (
        lambda: power_t(1.0, 0.0, 5, 5),
        lambda: power_t(1.0, 1.0, 5, 5, sides=3),
        lambda: power_t(1.0, 1.0, 5, 5, alpha=1.5),
        lambda: power_anova([1.0], 1.0, 5),
        lambda: power_equivalence(1.0, 1.0, -1.0, 5, 5),
        lambda: power_equivalence(1.0, -1.0, 1.0, 5, 5, 0.6),
    ):
        with pytest.raises(InputRefused):
            wrong()


DRAWS = 1500


def contrasts_of(days, difference, sd, mean, seed, day_sd=2.0):
    """Draw campaigns whose days differ, and compare the sides of each."""
    rng = np.random.default_rng(seed)
    labels = [[f"day {day}" for day, counts in enumerate(days) for _ in range(counts[side])] for side in (0, 1)]
    for _ in range(DRAWS):
        shifts = {f"day {day}": shift for day, shift in enumerate(rng.normal(0.0, day_sd * sd, len(days)))}
        control, treated = ([rng.normal(shifts[day], sd) for day in side] for side in labels)
        yield contrast_by_day(
            np.array(treated) + difference + mean,
            np.array(control) + mean,
            days_treated=labels[1],
            days_control=labels[0],
        )


@pytest.mark.parametrize(
    ("percent", "days"),
    [
        (True, [(2, 4)] * 4),
        *(
            pytest.param(percent, days, marks=pytest.mark.soak)
            for percent in (False, True)
            for days in ([(4, 5)], [(3, 10)] * 5, [(4, 12)] * 3)
        ),
    ],
)
def test_as_many_campaigns_show_equivalence_as_planned(percent, days):
    sd, mean, bound = 4.0, 100.0, 4.5
    power = power_equivalence_by_day(sd, -bound, bound, days, control_mean=mean if percent else None).power
    contrasts = contrasts_of(days, 0.0, sd, mean, 3, day_sd=0.5)
    shown = [each.equivalence(-bound, bound, percent=percent).equivalent is True for each in contrasts]
    assert np.mean(shown) == pytest.approx(power, abs=0.035)


SOAKED = [(8, 20)], [(3, 10)] * 5, [(5, 8)] * 5, [(4, 12)] * 3


@pytest.mark.parametrize(
    "days",
    [[(1, 3), (3, 10), (5, 15), (4, 12), (3, 10)], *(pytest.param(days, marks=pytest.mark.soak) for days in SOAKED)],
)
def test_as_many_campaigns_find_a_difference_as_planned(days):
    found = [each.difference().p < 0.05 for each in contrasts_of(days, 11.0, 10.0, 500.0, 7)]
    assert np.mean(found) == pytest.approx(power_by_day(11.0, 10.0, days).power, abs=0.035)  # three standard errors


def test_days_without_both_enter_nothing_and_days_that_claim_nothing_have_no_power():
    assert power_by_day(1.0, 1.0, [(3, 3)] * 4 + [(9, 0), (0, 9)]).power == power_by_day(1.0, 1.0, [(3, 3)] * 4).power
    for days in ([], [(5, 0), (0, 5)], [(1, 3)] * 3):
        assert isinstance(power_by_day(1.0, 1.0, days).power, Undefined)
    with pytest.raises(InputRefused):
        power_by_day(1.0, 1.0, [(-1, 2)])
    assert isinstance(power_equivalence_by_day(1.0, -1.0, 1.0, [(1, 3)] * 3).power, Undefined)
    with pytest.raises(InputRefused):
        power_equivalence_by_day(1.0, -1.0, 1.0, [(5, 5)], alpha=0.5)
