"""The order within days against all orders counted, and the adjusted difference against statsmodels' least squares."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pandas as pd
import pytest
import statsmodels.formula.api as formulas
from numpy.typing import NDArray

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.compare.shared_error import weighted_sum
from stats.days.order import AdjustedForPosition, PositionsCompared, adjust_for_position, compare_positions


def counted(days: list[tuple[list[int], int]]) -> float:
    """Return the share of all choices of treated places that are as far off as the first n of each day, or farther."""
    sums = [[sum(choice) for choice in itertools.combinations(places, n)] for places, n in days]
    expected = sum(n * sum(places) / len(places) for places, n in days)
    off = abs(sum(sum(places[:n]) for places, n in days) - expected)
    totals = [sum(each) for each in itertools.product(*sums)]
    return sum(abs(total - expected) >= off - 1e-9 for total in totals) / len(totals)


def compared(days: list[tuple[list[int], int]]) -> PositionsCompared:
    found = compare_positions(
        [place for places, _n in days for place in places],
        [at < n for places, n in days for at in range(len(places))],
        [str(day) for day, (places, _n) in enumerate(days) for _place in places],
    )
    assert isinstance(found, PositionsCompared)
    return found


def test_p_is_that_of_all_orders_of_each_day() -> None:
    rng = np.random.default_rng(1)
    for _case in range(60):
        days = []
        for _day in range(int(rng.integers(1, 4))):
            places = rng.choice(np.arange(1, 12), int(rng.integers(2, 7)), replace=False).tolist()
            days.append((places, int(rng.integers(1, len(places)))))
        assert compared(days).p == pytest.approx(counted(days), rel=1e-9)


def test_means_are_those_of_shared_days_by_their_weights() -> None:
    days = ["a", "a", "a", "b", "b", "b", "b", "c"]
    found = compare_positions([1, 2, 3, 1, 2, 3, 4, 9], [False, True, True, True, True, False, False, True], days)
    assert isinstance(found, PositionsCompared)
    of_a = (2 / 3) / (2 / 3 + 1.0)
    assert found.control == pytest.approx(of_a * 1.0 + (1 - of_a) * 3.5)
    assert found.treated == pytest.approx(of_a * 2.5 + (1 - of_a) * 1.5)
    assert compare_positions([1, 2, 1], [False, False, True], ["a", "a", "b"]) == Undefined(Reason.NO_SHARED_DAY)
    assert compared([([2, 3, 1, 4], 2), ([1, 4, 2, 3], 2)]).p == 1.0


def test_a_day_of_many_runs_has_the_p_of_the_sum_of_ranks() -> None:
    """Of 200 and 200 places the normal law; of 50 and 50, exact, as scipy's rank-sum test without ties."""
    from scipy.stats import mannwhitneyu

    rng = np.random.default_rng(2)
    for n in (50, 200):
        places = (rng.permutation(2 * n) + 1).tolist()
        expected = mannwhitneyu(places[:n], places[n:], method="exact" if n == 50 else "asymptotic").pvalue
        assert compared([(places, n)]).p == pytest.approx(expected, rel=1e-9 if n == 50 else 0.01)


def campaign(seed: int) -> tuple[NDArray[np.float64], list[int], list[bool], list[str], list[str]]:
    rng = np.random.default_rng(seed)
    rows = [(day, place) for day in range(4) for place in range(1, 9)]
    treated = [place > 3 for _day, place in rows]
    conditions = [str(rng.integers(2)) if side else "control" for side in treated]
    values = rng.normal(40.0, 2.0, len(rows)) + 0.5 * np.array([place for _day, place in rows])
    return values, [place for _day, place in rows], treated, [f"day {day}" for day, _place in rows], conditions


def frame(values: NDArray[np.float64], positions: list[int], treated: list[bool], days: list[str]) -> pd.DataFrame:
    cells = [f"{day} {side}" for day, side in zip(days, treated, strict=True)]
    return pd.DataFrame({"y": values, "x": positions, "cell": cells})


@pytest.mark.parametrize("seed", range(5))
def test_the_slope_is_that_of_least_squares_with_days_sides_and_conditions(seed: int) -> None:
    values, positions, treated, days, conditions = campaign(seed)
    found = adjust_for_position(values, positions, treated, days, conditions)
    assert isinstance(found, AdjustedForPosition)
    data = frame(values, positions, treated, days).assign(level=[each.replace("control", "0") for each in conditions])
    fit = formulas.ols("y ~ x + C(cell) + C(level)", data).fit()
    assert found.slope == pytest.approx(fit.params["x"], rel=1e-9)
    assert found.slope_se == pytest.approx(fit.bse["x"], rel=1e-9)
    assert found.df == fit.df_resid


def test_the_adjusted_difference_is_that_of_analysis_of_covariance_and_has_its_error() -> None:
    values, positions, treated, days, _conditions = campaign(1)
    found = adjust_for_position(values, positions, treated, days, treated)
    assert isinstance(found, AdjustedForPosition)
    sides = np.array(treated)
    own = np.where(sides, 1.0 / sides.sum(), -1.0 / (~sides).sum())  # of days that are alike
    fit = formulas.ols("y ~ x + C(cell)", frame(values, positions, treated, days)).fit()
    off = float(own @ np.array(positions, dtype=np.float64))
    assert own @ np.array(found.values) == pytest.approx(own @ values - fit.params["x"] * off, rel=1e-9)
    assert abs(weighted_sum(found.shared, own.tolist()).terms["position", "slope"]) == pytest.approx(fit.bse["x"] * off)


def test_means_of_days_stay_where_they_are_and_what_leaves_no_slope_is_undefined() -> None:
    values, positions, treated, days, conditions = campaign(2)
    found = adjust_for_position(values, positions, treated, days, conditions)
    assert isinstance(found, AdjustedForPosition)
    assert math.fsum(found.values) == pytest.approx(float(values.sum()))
    two_a_day = adjust_for_position(
        [1.0, 2.0, 3.0, 5.0], [1, 2, 1, 2], [False, True] * 2, ["a", "a", "b", "b"], list("ctct")
    )
    assert two_a_day == Undefined(Reason.POSITION_NOT_FREE)
