"""Nonlinear least squares: known truth, intervals that cover, what cannot be identified, and scipy as a second way."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import optimize
from scipy import stats as scipy_stats

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.lines.nonlinear import NonlinearFit, fit_nonlinear, profile_interval

Floats = NDArray[np.float64]
TIMES = np.linspace(0.1, 3.0, 25)
TRUTH = np.array([2.0, 0.7])
LOW, HIGH = [1e-3, 1e-3], [100.0, 100.0]


def decay(table: Floats) -> Floats:
    """a exp(-b t) for each row (a, b)."""
    return table[:, :1] * np.exp(-table[:, 1:2] * TIMES)


def fitted(y: Floats, error: float, start: tuple[float, float] = (1.0, 1.0)) -> NonlinearFit:
    return fit_nonlinear(lambda table: (decay(table) - y) / error, start, LOW, HIGH)


def test_it_agrees_with_scipy_curve_fit() -> None:
    y = decay(TRUTH[np.newaxis])[0] + np.random.default_rng(1).normal(0.0, 0.05, TIMES.size)
    found = fitted(y, 0.05)
    values, covariance = optimize.curve_fit(
        lambda t, a, b: a * np.exp(-b * t), TIMES, y, (1.0, 1.0), np.full(TIMES.size, 0.05), absolute_sigma=True
    )
    assert found.values == pytest.approx(values, rel=1e-5)
    assert not isinstance(found.covariance, Undefined)
    assert found.covariance == pytest.approx(covariance * found.spread, rel=1e-3)
    assert found.chi_squared == pytest.approx(float(np.sum(((decay(values[np.newaxis])[0] - y) / 0.05) ** 2)), rel=1e-6)


@pytest.mark.soak
def test_the_profile_covers_the_truth_as_often_as_it_says() -> None:
    n, rng, covered = 1000, np.random.default_rng(2), 0
    for _ in range(n):
        y = decay(TRUTH[np.newaxis])[0] + rng.normal(0.0, 0.1, TIMES.size)
        found = fitted(y, 0.1)
        low, high = profile_interval(lambda table, y=y: (decay(table) - y) / 0.1, found, 1, LOW, HIGH, 0.95)
        covered += (low or math.inf) <= TRUTH[1] <= (high or -math.inf)
    assert covered >= scipy_stats.binom.ppf(0.0005, n, 0.95)


def test_of_a_line_the_profile_is_students_interval() -> None:
    x = np.linspace(1.0, 4.0, 12)
    y = 3.0 * x + np.random.default_rng(3).normal(0.0, 2.0, x.size)

    def left(table: Floats) -> Floats:
        return (table * x - y) / 0.5  # errors stated too small: widened

    found = fit_nonlinear(left, [1.0], [1e-6], [1e6])
    slope = float(x @ y / (x @ x))
    se = math.sqrt(float(np.sum((y - slope * x) ** 2)) / (x.size - 1) / float(x @ x))
    half = scipy_stats.t.ppf(0.975, x.size - 1) * se
    assert found.values == pytest.approx([slope], rel=1e-6)
    assert found.ses == pytest.approx([se], rel=1e-6)
    interval = profile_interval(left, found, 0, [1e-6], [1e6], 0.95)
    assert interval == pytest.approx((slope - half, slope + half), rel=3e-3)


def one_product(table: Floats) -> Floats:
    """Of the first two, whose product alone counts; the third is told."""
    return table[:, :1] * table[:, 1:2] * np.exp(-table[:, 2:] * TIMES)


def two_products(table: Floats) -> Floats:
    first, second, third = (table[:, place : place + 1] for place in range(3))
    return np.concatenate([first * second * np.exp(-TIMES), second * third * np.exp(-2.0 * TIMES)], axis=1)


@pytest.mark.parametrize(("model", "unknown"), [(one_product, [0, 1]), (two_products, [0, 1, 2])])
def test_parameters_that_only_count_together_are_not_identified(
    model: Callable[[Floats], Floats], unknown: list[int]
) -> None:
    y = model(np.array([[2.0, 0.7, 0.7]]))
    y += np.random.default_rng(7).normal(0.0, 0.1, y.shape)

    def left(table: Floats) -> Floats:
        return (model(table) - y) / 0.1

    box = [0.1, 0.01, 0.01], [20.0, 100.0, 100.0]
    found = fit_nonlinear(left, [1.0, 1.0, 1.0], *box)
    assert isinstance(found.covariance, Undefined)
    assert found.condition > 1e7
    for place in range(3):
        low, high = profile_interval(left, found, place, *box, 0.95)
        if place in unknown:
            assert (low, high) == (None, None)
        else:
            assert (low or math.inf) < 0.7 < (high or -math.inf)


def test_a_model_that_gives_nothing_somewhere_is_turned_back_from() -> None:
    y = decay(TRUTH[np.newaxis])[0]

    def left(table: Floats) -> Floats:
        found = (decay(table) - y) / 0.1
        found[table[:, 1] > 1.5] = np.nan
        return found

    assert fit_nonlinear(left, [1.0, 1.4], LOW, HIGH).values == pytest.approx(TRUTH, rel=1e-4)
    with pytest.raises(InputRefused):
        fit_nonlinear(left, [1.0, 2.0], LOW, HIGH)
    with pytest.raises(InputRefused):  # as many parameters as numbers
        fit_nonlinear(lambda table: table - 1.0, [2.0, 2.0], LOW, HIGH)
