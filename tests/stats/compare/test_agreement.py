"""Bias of predictions by day, and limits of agreement: by hand, as published, and how often they hold."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy.stats
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.compare.agreement import Interval, PredictedRun, bias_by_day, joint_p, limits_of_agreement
from stats.compare.shared_error import SharedError

NONE = SharedError()
GROUPS, DAYS, LEVELS = 4, 5, 6


def run(day: str, measured: float, predicted: float, predicted_se: float = 0.0) -> PredictedRun:
    return PredictedRun(day, measured, NONE, predicted, predicted_se)


def known(about: Interval | Undefined) -> Interval:
    assert isinstance(about, Interval)
    return about


def test_by_hand() -> None:
    """Days lie 1 and 4 too high: 2.5 with a standard error of 1.5, one of the two days with two runs."""
    found = bias_by_day([run("a", 9.0, 10.0), run("a", 10.0, 11.0), run("b", 6.0, 10.0)])
    assert (found.bias, found.days, found.n) == (2.5, 2, 3)
    assert (found.measured, found.predicted) == (7.75, 10.25)
    assert known(found.in_all) == known(found.of_measured)
    assert known(found.in_all).se == pytest.approx(1.5, rel=1e-12)
    assert known(found.in_all).df == pytest.approx(1.0, rel=1e-12)


def test_without_common_errors_it_is_the_t_test_of_day_means() -> None:
    rng = np.random.default_rng(3)
    days = rng.normal(1.0, 2.0, 6)
    found = known(bias_by_day([run(str(day), -value, 0.0) for day, value in enumerate(days)]).in_all)
    oracle = scipy.stats.ttest_1samp(days, 0.0)
    assert found.p == pytest.approx(oracle.pvalue, rel=1e-9)
    assert found.ci == pytest.approx(tuple(oracle.confidence_interval(0.95)), rel=1e-9)


def test_common_errors_are_added_before_they_are_squared() -> None:
    shared = SharedError({("drain", "level"): 0.3}, {"drain": 4.0})
    runs = [PredictedRun(str(day), 1.0 + day % 2, shared, 0.0, 0.4) for day in range(50)]
    found = bias_by_day(runs)
    between = np.var([1.0 + day % 2 for day in range(50)], ddof=1) / 50
    assert known(found.of_measured).se == pytest.approx(math.sqrt(between + 0.09), rel=1e-12)
    assert known(found.in_all).se == pytest.approx(math.sqrt(between + 0.09 + 0.16), rel=1e-12)
    variances, dfs = np.array([between, 0.09, 0.16]), np.array([49.0, 4.0, np.inf])
    assert known(found.in_all).df == pytest.approx(variances.sum() ** 2 / (variances**2 / dfs).sum(), rel=1e-12)


def test_one_day_and_no_error_have_no_interval() -> None:
    assert bias_by_day([run("a", 1.0, 2.0), run("a", 2.0, 2.0)]).in_all == Undefined(Reason.ONE_DAY)
    exact = bias_by_day([run("a", 1.0, 2.0), run("b", 1.0, 2.0)])
    assert (exact.bias, exact.in_all) == (1.0, Undefined(Reason.BOTH_EXACT))
    assert joint_p([Undefined(Reason.ONE_DAY)]) == Undefined(Reason.ONE_DAY)
    assert joint_p([0.2, 0.01, 0.9, Undefined(Reason.ONE_DAY)]) == pytest.approx(0.03, rel=1e-15)  # Holm's least
    assert joint_p([0.6, 0.7]) == 1.0


def test_what_is_no_number_or_too_few_is_refused() -> None:
    for bad in ([run("a", math.nan, 1.0)], [run("a", 1.0, math.inf)], [run("a", 1.0, 1.0, -0.1)]):
        with pytest.raises(InputRefused, match="finite numbers"):
            bias_by_day(bad)
    with pytest.raises(InputRefused, match="without runs"):
        bias_by_day([])
    for values in ([1.0, 2.0], [1.0, 2.0, math.nan]):
        with pytest.raises(InputRefused, match="at least 3"):
            limits_of_agreement(values)


@given(st.lists(st.floats(-1e3, 1e3), min_size=2, max_size=8, unique=True), st.floats(-1e3, 1e3))
def test_turning_the_sign_turns_the_interval(values: list[float], predicted: float) -> None:
    runs = [run(str(day), value, predicted) for day, value in enumerate(values)]
    there = bias_by_day(runs)
    back = bias_by_day([run(one.day, one.predicted, one.measured) for one in runs])
    assert back.bias == -there.bias
    if isinstance(there.in_all, Interval):
        low, high = there.in_all.ci
        assert known(back.in_all).ci == (-high, -low)


@pytest.mark.soak
@pytest.mark.parametrize(("day_sd", "shared_days"), [(1.0, True), (0.0, False), (1.0, False), (0.5, True)])
def test_where_there_is_no_bias_it_is_found_as_rarely_as_it_says(day_sd: float, shared_days: bool) -> None:
    """Groups on the same days or on their own; 1 500 campaigns, within the 99.9 % band of a size of .05."""
    rng = np.random.default_rng(11)
    campaigns, singly, jointly = 1500, 0, 0
    for _ in range(campaigns):
        of_days = rng.normal(0.0, day_sd, (1 if shared_days else GROUPS, DAYS))
        ps = []
        for group in range(GROUPS):
            days = of_days[0 if shared_days else group]
            runs = [run(str(day), days[day] + rng.normal(), 0.0) for day in range(DAYS) for _level in range(LEVELS)]
            ps.append(known(bias_by_day(runs).in_all).p)
        singly += ps[0] < 0.05
        joint = joint_p(ps)
        assert isinstance(joint, float)
        jointly += joint < 0.05
    most = scipy.stats.binom.ppf(0.999, campaigns, 0.05)
    assert scipy.stats.binom.ppf(0.001, campaigns, 0.05) <= singly <= most
    assert jointly <= most


WRIGHT = (494, 395, 516, 434, 476, 557, 413, 442, 650, 433, 417, 656, 267, 478, 178, 423, 427)
MINI = (512, 430, 520, 428, 500, 600, 364, 380, 658, 445, 432, 626, 260, 477, 259, 350, 451)
"""Peak expiratory flow by two meters, l/min: Bland and Altman (1986), table 1."""


def test_the_published_example_has_its_published_numbers() -> None:
    found = limits_of_agreement([a - b for a, b in zip(WRIGHT, MINI, strict=True)])
    assert found.mean == pytest.approx(-2.1, abs=0.05)
    assert (found.high - found.low) / (2 * 1.959964) == pytest.approx(38.8, abs=0.05)
    assert found.se == pytest.approx(9.4, abs=0.05)
    assert found.ci == pytest.approx((-22.0, 17.8), abs=0.1)


@given(st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=40), st.sampled_from([0.9, 0.95, 0.99]))
def test_the_mean_has_students_interval_and_limits_lie_z_deviations_from_it(values: list[float], level: float) -> None:
    found, sd = limits_of_agreement(values, level), float(np.std(values, ddof=1))
    z, t = scipy.stats.norm.ppf(0.5 + level / 2), scipy.stats.t.ppf(0.5 + level / 2, len(values) - 1)
    assert found.mean == pytest.approx(np.mean(values), abs=1e-9)
    assert found.ci[1] - found.mean == pytest.approx(t * sd / len(values) ** 0.5, rel=1e-9, abs=1e-9)
    assert found.mean - found.low == pytest.approx(z * sd, rel=1e-9, abs=1e-9)
    assert found.high - found.mean == pytest.approx(z * sd, rel=1e-9, abs=1e-9)
    assert found.low_ci[1] - found.low_ci[0] == pytest.approx(2 * t * found.limit_se, rel=1e-9, abs=1e-9)


def test_intervals_of_limits_cover_the_true_ones() -> None:
    rng, covered, n = np.random.default_rng(4), 0, 2000
    for _ in range(n):
        low, high = limits_of_agreement(rng.normal(0.3, 1.0, 20).tolist()).low_ci
        covered += low <= 0.3 - 1.959964 <= high
    assert 0.935 < covered / n < 0.97
