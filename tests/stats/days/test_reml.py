"""The solver: exact in balanced designs, its derivatives those of the deviance."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from scipy import special

from stats.checks import as_sample
from stats.days.blocked import blocked_by_day
from stats.days.blocked_result import ExactTest
from stats.days.cells import cells_of
from stats.days.reml import RemlModel
from tests.helpers.shared_days import crossed


def by_hand(values: np.ndarray, conditions: int, days: int, times: int) -> tuple[float, float, float, int]:
    """Mean squares of conditions, days and the rest of a complete design, in exact arithmetic."""
    table = [[[Fraction(float(x)) for x in cell] for cell in day] for day in values.reshape(days, conditions, times)]
    grand = sum(x for day in table for cell in day for x in cell) / (days * conditions * times)
    of_day = [sum(x for cell in day for x in cell) / (conditions * times) for day in table]
    of_condition = [sum(x for day in table for x in day[c]) / (days * times) for c in range(conditions)]
    between_days = sum((m - grand) ** 2 for m in of_day) * conditions * times
    between = sum((m - grand) ** 2 for m in of_condition) * days * times
    rest = sum((x - grand) ** 2 for day in table for cell in day for x in cell) - between_days - between
    df = days * conditions * times - days - conditions + 1
    return float(between / (conditions - 1)), float(between_days / (days - 1)), float(rest / df), df


@pytest.mark.parametrize("day_sd", [0.5, 30.0, 1e6])
@pytest.mark.parametrize("offset", [0.0, 1e9])
def test_a_balanced_design_has_its_exact_f(day_sd, offset):
    """lmerTest puts the 54 degrees of freedom of such a design at 54.00016 for days a thousand times the scatter."""
    rng = np.random.default_rng(5)
    condition, day = crossed(3, 4, 5)
    values = np.round(rng.normal(size=60) + rng.normal(0.0, day_sd, 4)[day], 4) + offset
    between, between_days, rest, df = by_hand(values, 3, 4, 5)
    found = blocked_by_day(values, condition, day)
    assert between_days > rest
    assert (found.mixed.f, found.mixed.df_within) == pytest.approx((between / rest, df), rel=1e-9)
    assert found.mixed.p == pytest.approx(float(special.fdtrc(2, df, between / rest)), rel=1e-8)
    assert found.residual_variance == pytest.approx(rest, rel=1e-9)
    assert found.day_variance == pytest.approx((between_days - rest) / 15, rel=1e-9)
    assert isinstance(found.exact, ExactTest)
    assert (found.exact.f, found.exact.df_within, found.exact.unit) == (
        pytest.approx(between / rest, rel=1e-12),
        df,
        "value",
    )
    assert [c.t for c in found.exact.contrasts] == pytest.approx([c.t for c in found.mixed.contrasts], rel=1e-8)


def test_the_derivatives_are_those_of_the_deviance():
    rng = np.random.default_rng(8)
    day, run, condition = np.repeat(np.arange(4), 12), np.repeat(np.arange(12), 4), rng.integers(0, 3, 48)
    kept = rng.random(48) < 0.8
    model = RemlModel(cells_of(as_sample("values", rng.normal(size=48)[kept]), condition[kept], day[kept], run[kept]))
    here, step = np.array([0.3, 0.8]), 1e-5
    found = model.at(here)
    for i in range(2):
        aside = np.eye(2)[i] * step
        after, before = model.at(here + aside), model.at(here - aside)
        assert found.gradient[i] == pytest.approx((after.deviance - before.deviance) / (2 * step), rel=1e-7)
        assert found.hessian[i] == pytest.approx((after.gradient - before.gradient) / (2 * step), rel=1e-7)
        for weights in np.eye(3) - np.eye(3)[0]:
            change = after.estimates.variance(weights) - before.estimates.variance(weights)
            assert found.slope(i, weights) == pytest.approx(change / (2 * step), rel=1e-7)


def exact_derivatives(counts: np.ndarray, values: list[list[int]], gamma: Fraction) -> tuple[Fraction, Fraction]:
    """First and second derivative by the days' gamma of the deviance of two conditions, in fractions.

    `counts`, shape (days, 2), says how many values each condition has on each day; `values` has all values of a day.
    """
    sizes = [Fraction(int(each)) for each in counts.sum(axis=1)]
    cells = [[Fraction(int(each)) for each in row] for row in counts]
    shrinks = [1 / (1 + gamma * size) for size in sizes]
    of_days = [sum(map(Fraction, each)) for each in values]
    of_conditions = [sum(sum(each[: row[0]]) for each, row in zip(values, counts.tolist(), strict=True))]
    of_conditions.append(sum(of_days) - of_conditions[0])
    days, both = range(len(sizes)), range(2)

    def through(a: list[Fraction], b: list[Fraction]) -> Fraction:
        return sum(gamma * x * y * shrink for x, y, shrink in zip(a, b, shrinks, strict=True))

    columns = [[row[c] for row in cells] for c in both]
    cross = [[(sum(columns[c]) if c == d else 0) - through(columns[c], columns[d]) for d in both] for c in both]
    along = [of_conditions[c] - through(columns[c], of_days) for c in both]
    det = cross[0][0] * cross[1][1] - cross[0][1] ** 2
    inverse = [[cross[1][1] / det, -cross[0][1] / det], [-cross[0][1] / det, cross[0][0] / det]]
    means = [sum(inverse[c][d] * along[d] for d in both) for c in both]
    own = sum(Fraction(x) ** 2 for each in values for x in each) - through(of_days, of_days)
    squares = own - sum(m * a for m, a in zip(means, along, strict=True))
    reach = [[columns[c][day] * shrinks[day] for c in both] for day in days]
    pull = [of_days[day] * shrinks[day] - sum(reach[day][c] * means[c] for c in both) for day in days]
    m = [
        [
            (sizes[i] * shrinks[i] if i == j else 0)
            - sum(reach[i][c] * inverse[c][d] * reach[j][d] for c in both for d in both)
            for j in days
        ]
        for i in days
    ]
    nu, force = sum(sizes) - 2, sum(w * w for w in pull)
    bent = sum(pull[i] * m[i][j] * pull[j] for i in days for j in days)
    curve = nu * (2 * bent / squares - (force / squares) ** 2)
    return sum(m[i][i] for i in days) - nu * force / squares, curve - sum(m[i][j] ** 2 for i in days for j in days)


@pytest.mark.parametrize("gamma", [Fraction(0), Fraction(1, 64), Fraction(4)])
def test_days_that_hold_nearly_one_condition_only_keep_their_curvature(gamma):
    """What days tell of each other here, about 2, is what is left of 10000: sums less large squares would lose it."""
    rng = np.random.default_rng(3)
    counts = np.array([[10_000, 1], [1, 10_000], [2, 1]])
    day, condition = np.repeat([0, 0, 1, 1, 2, 2], counts.ravel()), np.repeat([0, 1] * 3, counts.ravel())
    numbers = np.round(50.0 * rng.normal(size=day.size)).astype(int)
    model = RemlModel(cells_of(as_sample("values", numbers), condition, day, day))
    found = model.at(np.array([float(gamma), 0.0]))
    slope, curve = exact_derivatives(counts, [numbers[day == each].tolist() for each in range(3)], gamma)
    assert found.gradient[0] == pytest.approx(float(slope), rel=1e-10)
    assert found.hessian[0, 0] == pytest.approx(float(curve), rel=1e-10)
