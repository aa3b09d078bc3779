"""The power of the test by shared days, against campaigns drawn and tested."""

import numpy as np
import pytest

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.days.decision import contrast_by_day
from stats.planning.power import power_by_day, power_equivalence_by_day

DRAWS = 1500


def in_a_soak(*cases):
    return [pytest.param(*case, marks=pytest.mark.soak) for case in cases]


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


def found_in(days, difference, sd, seed):
    """Return the share of campaigns in which the difference is found."""
    return sum(each.difference().p < 0.05 for each in contrasts_of(days, difference, sd, 500.0, seed)) / DRAWS


@pytest.mark.parametrize(
    ("percent", "days"),
    [
        (True, [(2, 4)] * 4),
        *in_a_soak(
            (False, [(4, 5)]), (False, [(3, 10)] * 5), (True, [(3, 10)] * 5), (False, [(2, 4)] * 4), (True, [(4, 5)])
        ),
        *in_a_soak((False, [(4, 12)] * 3), (True, [(4, 12)] * 3)),
    ],
)
def test_as_many_campaigns_show_equivalence_as_planned(days, percent):
    sd, mean, bound = 4.0, 100.0, 4.5
    power = power_equivalence_by_day(sd, -bound, bound, days, control_mean=mean if percent else None).power
    shown = [
        each.equivalence(-bound, bound, percent=percent).equivalent
        for each in contrasts_of(days, 0.0, sd, mean, 3, day_sd=0.5)
    ]
    assert sum(each is True for each in shown) / DRAWS == pytest.approx(power, abs=0.035)


@pytest.mark.parametrize(
    "days",
    [
        [(1, 3), (3, 10), (5, 15), (4, 12), (3, 10)],
        *(
            pytest.param(days, marks=pytest.mark.soak)
            for days in ([(8, 20)], [(3, 10)] * 5, [(5, 8)] * 5, [(4, 12)] * 3)
        ),
    ],
)
def test_as_many_campaigns_find_a_difference_as_planned(days):
    power = power_by_day(11.0, 10.0, days).power
    assert found_in(days, 11.0, 10.0, 7) == pytest.approx(power, abs=0.035)  # three standard errors at .5


def test_days_without_both_enter_nothing_and_days_that_claim_nothing_have_no_power():
    assert power_by_day(1.0, 1.0, [(3, 3)] * 4 + [(9, 0), (0, 9)]).power == power_by_day(1.0, 1.0, [(3, 3)] * 4).power
    for days in ([], [(5, 0), (0, 5)], [(1, 3)] * 3):
        assert isinstance(power_by_day(1.0, 1.0, days).power, Undefined)
    with pytest.raises(InputRefused):
        power_by_day(1.0, 1.0, [(-1, 2)])
    assert isinstance(power_equivalence_by_day(1.0, -1.0, 1.0, [(1, 3)] * 3).power, Undefined)
    with pytest.raises(InputRefused):
        power_equivalence_by_day(1.0, -1.0, 1.0, [(5, 5)], alpha=0.5)
