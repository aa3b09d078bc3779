"""Ten thousands of runs: the same answer as sums of squares and matrices day by day give, in little memory."""

from __future__ import annotations

import tracemalloc
from fractions import Fraction

import numpy as np
import pytest
from scipy import special

from stats.days.blocked import blocked_by_day
from stats.days.blocked_result import BlockedByDay, ExactTest

MEBIBYTE = 2**20


def numbers(days: int, runs: int, conditions: int, times: int, *, of_run: bool) -> np.ndarray:
    """Whole numbers of shape (days, runs, conditions, times); with `of_run` the conditions take turns by run."""
    rng = np.random.default_rng([days, runs, conditions, times])
    scatter = [rng.normal(0.0, 40.0, (days, 1, 1, 1)), rng.normal(0.0, 30.0, (days, runs, 1, 1))]
    if of_run:
        scatter[1] = rng.normal(0.0, 30.0, (days, runs, conditions, 1))
    values = rng.normal(0.0, 20.0, (days, runs, conditions, times)) + sum(scatter)
    return np.round(values + np.arange(conditions)[:, None]).astype(np.int64)


def squares(values: np.ndarray, *kept: int) -> Fraction:
    """Sum of squares of the means over all but the kept axes, each as often as it has values."""
    others = tuple(axis for axis in range(values.ndim) if axis not in kept)
    sums = np.ravel(values.sum(axis=others)).tolist()
    return Fraction(sum(each * each for each in sums), values.size // len(sums))


def labels(values: np.ndarray, *axes: int) -> np.ndarray:
    return np.ravel_multi_index([np.indices(values.shape)[axis] for axis in axes], [values.shape[a] for a in axes])


def table(values: np.ndarray, run_axes: tuple[int, ...]) -> dict[str, tuple[Fraction, int]]:
    """Mean squares and degrees of freedom of a balanced design: conditions, days, runs in days, values in runs."""
    days, runs, conditions, _times = values.shape
    grand, n = squares(values), values.size
    between, by_day = squares(values, 2) - grand, squares(values, 0) - grand
    n_runs = days * runs * (conditions if 2 in run_axes else 1)
    by_run = squares(values, *run_axes) - grand - by_day
    total = int((values * values).sum()) - grand
    df_run = n_runs - days
    if 2 in run_axes:  # conditions differ between runs
        by_run, df_run = by_run - between, df_run - (conditions - 1)
    df_rest = n - days - (conditions - 1) - df_run
    rest = total - by_day - by_run - between
    return {
        "condition": (between / (conditions - 1), conditions - 1),
        "day": (by_day / (days - 1), days - 1),
        "run": (by_run / df_run, df_run),
        "rest": (rest / df_rest, df_rest),
    }


@pytest.mark.parametrize(
    ("of_run", "shape"),
    [
        (True, (200, 17, 3, 4)),
        pytest.param(False, (200, 50, 3, 2), marks=pytest.mark.soak),
        pytest.param(True, (4, 900, 3, 2), marks=pytest.mark.soak),
    ],
)
def test_ten_thousand_runs_have_the_variances_and_the_f_of_their_sums_of_squares(of_run, shape):
    """Runs that hold every condition, runs of one condition each, and few days of very many runs."""
    values = numbers(*shape, of_run=of_run)
    run_axes = (0, 1, 2) if of_run else (0, 1)
    found = blocked_by_day(
        values.ravel(), labels(values, 2).ravel(), labels(values, 0).ravel(), labels(values, *run_axes).ravel()
    )
    expected = table(values, run_axes)
    below, df = expected["run" if of_run else "rest"]
    f = float(expected["condition"][0] / below)
    size = values.size // np.unique(labels(values, *run_axes)).size
    assert expected["day"][0] > expected["run"][0] > expected["rest"][0]  # so that no variance is 0
    assert found.residual_variance == pytest.approx(float(expected["rest"][0]), rel=1e-10)
    assert found.run_variance == pytest.approx(float(expected["run"][0] - expected["rest"][0]) / size, rel=1e-9)
    of_day = float(expected["day"][0] - expected["run"][0]) / (values.size // shape[0])
    assert found.day_variance == pytest.approx(of_day, rel=1e-9)
    assert (found.mixed.f, found.mixed.df_within) == pytest.approx((f, df), rel=1e-9)
    assert found.mixed.p == pytest.approx(float(special.fdtrc(shape[2] - 1, df, f)), rel=1e-7)
    assert isinstance(found.exact, ExactTest)
    assert (found.exact.f, found.exact.df_within) == (pytest.approx(f, rel=1e-11), df)


def uneven(days: int, runs: int) -> tuple[np.ndarray, ...]:
    """Runs of 1 to 3 values on days of any number of runs, a condition for each value."""
    rng = np.random.default_rng([days, runs])
    run = np.repeat(np.arange(runs), rng.integers(1, 4, runs))
    day = np.sort(rng.integers(0, days, runs))[run]
    condition = rng.integers(0, 3, run.size)
    values = rng.normal(size=run.size) + 0.7 * rng.normal(size=runs)[run] + 2.0 * rng.normal(size=days)[day]
    return values + 0.05 * condition, condition, day, run


def by_matrices(data: tuple[np.ndarray, ...], variances: tuple[float, ...]) -> tuple[float, np.ndarray, np.ndarray]:
    """REML criterion, means and their covariance from the covariance matrix of each day's values, written down."""
    values, condition, day, run = data
    of_day, of_run, rest = variances
    design = np.eye(3)[condition]
    log_det, cross, along, squares_ = 0.0, np.zeros((3, 3)), np.zeros(3), 0.0
    for number in np.unique(day):
        chosen = day == number
        x, y, of = design[chosen], values[chosen], run[chosen]
        matrix = of_day + of_run * (of[:, None] == of) + rest * np.eye(y.size)
        solved = np.linalg.solve(matrix, np.column_stack([x, y]))
        log_det += np.linalg.slogdet(matrix)[1]
        cross, along, squares_ = cross + x.T @ solved[:, :3], along + x.T @ solved[:, 3], squares_ + y @ solved[:, 3]
    means = np.linalg.solve(cross, along)
    criterion = log_det + np.linalg.slogdet(cross)[1] + squares_ - along @ means
    return criterion + (values.size - 3) * np.log(2.0 * np.pi), means, np.linalg.inv(cross)


def variances_of(found: BlockedByDay) -> np.ndarray:
    return np.array([found.day_variance, found.run_variance, found.residual_variance])


def test_uneven_runs_have_the_criterion_and_the_means_of_matrices_day_by_day():
    data = uneven(60, 1200)
    found = blocked_by_day(*data)
    at = variances_of(found)
    criterion, means, covariance = by_matrices(data, at)
    assert found.reml_criterion == pytest.approx(criterion, rel=1e-12)
    assert [each.estimate for each in found.conditions] == pytest.approx(means, rel=1e-9)
    assert [each.se for each in found.conditions] == pytest.approx(np.sqrt(np.diag(covariance)), rel=1e-9)
    for place in range(3):
        step = 1e-3 * np.eye(3)[place]
        after, before = (by_matrices(data, at * (1.0 + side * step))[0] for side in (1.0, -1.0))
        # At the minimum the criterion rises to both sides alike: a slope would show in the difference.
        assert min(after, before) > criterion
        assert abs(after - before) < 1e-2 * (after + before - 2.0 * criterion)


@pytest.mark.soak
def test_twenty_thousand_runs_need_no_matrix_of_runs_by_runs():
    data = uneven(400, 20_000)
    tracemalloc.start()
    try:
        found = blocked_by_day(*data)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert found.n_runs == 20_000
    assert peak < 100 * MEBIBYTE < 20_000**2 * 8 / 20
