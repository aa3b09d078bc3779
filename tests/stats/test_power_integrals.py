"""Powers at designs whose integrands turn sharply: unequal sizes, unequal scatter, far tails, very many values.

Held to mpmath, to integrals made otherwise (`planned_integrals`) and to numbers of 300 nodes or of other programs.
"""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from scipy import special

from stats.exact.tails import t_upper_quantile, t_upper_quantiles
from stats.planning.estimated_scatter import normal_between
from stats.planning.power import power_equivalence, power_welch
from stats.planning.power_percent import between_lines, power_percent_equivalence
from tests.stats import planned_integrals

OF_ITSELF, PERCENT = 1e-10, 1e-9
"""What the docstrings promise."""


def owens_q(low: float, high: float, critical: float, df: int) -> float:
    """Return both one-sided tests' chance from mpmath, in panels as wide as the integrand's turns."""
    with mpmath.workdps(30):
        last, half = (mpmath.mpf(high) - low) / (2 * mpmath.mpf(critical)), mpmath.mpf(df) / 2
        log_at_1 = mpmath.log(2) + half * mpmath.log(half) - mpmath.loggamma(half)

        def integrand(u: mpmath.mpf) -> mpmath.mpf:
            density = mpmath.exp(log_at_1 + (df - 1) * mpmath.log(u) - half * u * u)
            return density * (mpmath.ncdf(high - critical * u) - mpmath.ncdf(low + critical * u))

        width = 1 / mpmath.sqrt(2 * mpmath.mpf(df))
        cuts = [1 + width * k for k in (-12, -6, -3, 0, 3, 6, 12)] + [last * k / 8 for k in range(9)]
        cuts += [(end + k) / mpmath.mpf(critical) for end in (-low, high) for k in (-6, -3, 0, 3, 6)]
        return float(mpmath.quad(integrand, sorted({cut for cut in cuts if 0 <= cut <= last}), method="gauss-legendre"))


@pytest.mark.parametrize(
    ("difference", "bound", "n", "alpha"),
    [
        (0.0, 1.0, 10, 0.05),
        (0.0, 0.3, 5, 0.05),
        (0.0, 1.0, 10, 1e-10),
        (0.0, 1e-3, 10, 0.05),
        (3.0, 1.0, 10, 0.05),
        (0.99, 1.0, 200_000, 0.05),
        (0.0, 100.0, 2, 1e-3),
        (0.0, 1.0, 3, 1e-6),
        (0.0, 0.1, 10, 0.49),
    ],
)
def test_students_equivalence_test_is_mpmaths(difference, bound, n, alpha):
    error = math.sqrt(2.0 / n)
    ends = [(end - difference) / error for end in (-bound, bound)]
    truth = owens_q(ends[0], ends[1], t_upper_quantile(alpha, 2 * n - 2), 2 * n - 2)
    power = power_equivalence(difference, 1.0, -bound, bound, n, n, alpha, route="student").power
    assert power == pytest.approx(truth, rel=OF_ITSELF, abs=0.0)


def test_students_equivalence_test_of_very_many_values_and_of_narrow_bounds():
    assert power_equivalence(0.0, 1.0, -1.0, 1.0, 200_000, 200_000, route="student").power == pytest.approx(
        1.0, abs=1e-13
    )
    # 9.7419373142645e-54 from a series in the bound.
    power = power_equivalence(0.0, 1.0, -1e-3, 1e-3, 10, 10, route="student").power
    assert power == pytest.approx(9.741937314264541e-54, rel=OF_ITSELF, abs=0.0)


@pytest.mark.parametrize(
    ("difference", "sds", "sizes", "alpha"),
    [
        (1.0, (1.0, 0.1), (2, 2), 0.05),
        (1.0, (1.0, 0.01), (2, 2), 0.05),
        (1.0, (1.0, 0.001), (2, 2), 0.05),
        (3.0, (0.001, 1.0), (3, 2), 0.05),
        (1.0, (1.0, 0.01), (10, 3), 0.05),
        (0.37, (1.0, 1.4), (674, 70), 0.001),
        (1.0, (1.0, 2.0), (2, 5000), 0.05),
    ],
)
def test_welchs_test_is_that_of_other_integrals(difference, sds, sizes, alpha):
    truth = planned_integrals.welch(None, difference, sds, sizes, alpha / 2.0)
    assert power_welch(difference, *sds, *sizes, alpha).power == pytest.approx(truth, rel=OF_ITSELF, abs=0.0)


@pytest.mark.parametrize(
    ("difference", "sds", "ends", "sizes", "alpha"),
    [
        (0.0, (1.0, 0.1), (-1.0, 1.0), (3, 1000), 0.05),
        (0.5, (1.0, 1.03), (-3.9, 3.1), (4, 2), 0.01),
        (0.0, (1.0, 3.0), (-3.0, 2.5), (3, 10), 0.05),
        (0.02, (1.0, 0.011), (-0.26, 0.23), (145, 2), 0.05),
        (0.0, (1.0, 1.0), (-0.2, 0.2), (5, 5), 0.05),
    ],
)
def test_welchs_equivalence_test_is_that_of_other_integrals(difference, sds, ends, sizes, alpha):
    truth = planned_integrals.welch(ends, difference, sds, sizes, alpha)
    power = power_equivalence(difference, sds[0], *ends, *sizes, alpha, sd_b=sds[1]).power
    assert power == pytest.approx(truth, rel=OF_ITSELF, abs=0.0)


@pytest.mark.parametrize(
    "sizes", [(100_000, 100_000), (100_000, 5), (10_000_000, 1000), (1_000_000_000, 1_000_000_000)]
)
def test_welchs_tests_of_very_many_values_keep_their_digits(sizes):
    sds, error = (1.0, 2.0), math.hypot(1.0 / math.sqrt(sizes[0]), 2.0 / math.sqrt(sizes[1]))
    truth = planned_integrals.welch(None, 2.0 * error, sds, sizes, 0.025)
    assert power_welch(2.0 * error, *sds, *sizes).power == pytest.approx(truth, rel=2e-12, abs=0.0)
    ends, difference = (-3.0 * error, 3.0 * error), 0.3 * error
    truth = planned_integrals.welch(ends, difference, sds, sizes, 0.05)
    power = power_equivalence(difference, sds[0], *ends, *sizes, sd_b=sds[1]).power
    assert power == pytest.approx(truth, rel=2e-12, abs=0.0)


ATTACKED = [
    ((0.0, 10.0, 1.0, -10.0, 10.0, 10_000, 3), 0.12935, 0.00034),
    ((0.0, 10.0, 1.0, -10.0, 10.0, 100_000, 2), 0.08766, 0.00028),
    ((0.0, 10.0, 1.0, -1.0, 1.0, 1_000_000, 1000), 0.870100, 0.00034),
    ((0.0, 10.0, 1.0, -10.0, 10.0, 200, 4), 0.204230, 0.0004),
    ((0.0, 100.0, 1.0, -3.0, 3.0, 2, 2), 0.2635684, 3e-7),
]
"""Chances that simulations found, with their standard errors; the last is that of 300 nodes a side."""


@pytest.mark.parametrize(("design", "simulated", "error"), ATTACKED)
def test_percent_bounds_of_unequal_groups_are_as_simulated(design, simulated, error):
    assert power_percent_equivalence(*design).power == pytest.approx(simulated, abs=3.0 * error)


@pytest.mark.soak
@pytest.mark.parametrize(
    "design",
    [
        (0.0, 10.0, 1.0, -10.0, 10.0, 200, 4, 0.05),
        (0.0, 100.0, 1.0, -3.0, 3.0, 2, 2, 0.05),
        (0.0, 10.0, 1.0, -10.0, 10.0, 10_000, 3, 0.05),
        (0.0, 0.7, 1.0, -90.0, 200.0, 5, 5, 0.05),
        (0.0, 2.0, 1.0, -60.0, 60.0, 40, 2, 0.2),
        (0.1, 0.5, 1.0, -95.0, 400.0, 100, 2, 0.2),
        (0.02, 12.5, 1.0, -22.0, 26.8, 734, 4, 0.2),
    ],
)
def test_percent_bounds_are_those_of_other_integrals(design):
    truth = planned_integrals.percent(*design)
    assert power_percent_equivalence(*design).power == pytest.approx(truth, abs=PERCENT)


@pytest.mark.soak
def test_drawn_designs_are_those_of_other_integrals():
    random = np.random.default_rng(1908)
    for _ in range(12):
        n_a, n_b = (int(n) for n in np.maximum(2.0, 10.0 ** random.uniform(0.3, 3.5, 2)))
        sds, alpha = (1.0, float(10.0 ** random.uniform(-3.0, 1.0))), float(random.choice([0.001, 0.01, 0.05, 0.2]))
        error, far = math.hypot(sds[0] / math.sqrt(n_a), sds[1] / math.sqrt(n_b)), float(random.uniform(0.5, 6.0))
        truth = planned_integrals.welch(None, far * error, sds, (n_a, n_b), alpha / 2.0)
        power = power_welch(far * error, *sds, n_a, n_b, alpha).power
        assert power == pytest.approx(truth, rel=OF_ITSELF, abs=0.0), (far, sds, n_a, n_b, alpha)
        ends, difference = (-(far + 1.0) * error, far * error), float(random.uniform(-0.5, 0.5)) * error
        truth = planned_integrals.welch(ends, difference, sds, (n_a, n_b), alpha)
        power = power_equivalence(difference, sds[0], *ends, n_a, n_b, alpha, sd_b=sds[1]).power
        assert power == pytest.approx(truth, rel=OF_ITSELF, abs=1e-14), (difference, sds, ends, n_a, n_b, alpha)


@pytest.mark.soak
@pytest.mark.parametrize(("design", "_simulated", "_error"), ATTACKED)
def test_percent_bounds_are_those_of_many_simulated_studies(design, _simulated, _error):
    difference, mean, sd, low, high, n_a, n_b = design
    studies, random = 4_000_000, np.random.default_rng(1908)
    found = 0
    for _ in range(8):
        each = studies // 8
        mean_a = random.normal(mean + difference, sd / math.sqrt(n_a), each)
        mean_b = random.normal(mean, sd / math.sqrt(n_b), each)
        part_a, part_b = (sd * sd * random.chisquare(n - 1, each) / (n - 1) / n for n in (n_a, n_b))
        shown = mean_b > -t_upper_quantile(0.95, n_b - 1) * np.sqrt(part_b)
        for sign, factor in ((1.0, 1.0 + low / 100.0), (-1.0, 1.0 + high / 100.0)):
            of_b = factor**2 * part_b
            df = planned_integrals.welch_df(part_a, of_b, n_a - 1.0, n_b - 1.0)
            t = (mean_a - factor * mean_b) / np.sqrt(part_a + of_b)
            shown &= special.stdtr(df, -sign * t) <= 0.05
        found += int(np.count_nonzero(shown))
    power = power_percent_equivalence(*design).power
    assert found / studies == pytest.approx(power, abs=4.0 * math.sqrt(power * (1.0 - power) / studies))


def test_one_sided_tests_at_levels_above_a_half_accept_what_the_others_reject():
    rejected = power_welch(0.4, 1.0, 2.0, 4, 7, 0.3, sides=1).power
    assert power_welch(-0.4, 1.0, 2.0, 4, 7, 0.7, sides=1).power == pytest.approx(1.0 - rejected, rel=1e-9)
    middle = power_welch(0.4, 1.0, 2.0, 4, 7, 0.5, sides=1).power
    error = math.sqrt(1.0 / 4.0 + 4.0 / 7.0)
    assert middle == pytest.approx(float(mpmath.ncdf(0.4 / error)), rel=1e-12)


def test_differences_and_scatter_at_the_ends_of_the_doubles():
    assert power_welch(1e300, 1e-300, 1e-300, 3, 3).power == pytest.approx(1.0, abs=1e-14)
    assert power_welch(1.0, 1e-200, 1.0, 3, 4).power == pytest.approx(
        power_welch(1.0, 1e-150, 1.0, 3, 4).power, rel=1e-9
    )
    assert power_welch(1.0, 1.0, 1e-200, 3, 4).power == pytest.approx(
        power_welch(1.0, 1.0, 1e-150, 3, 4).power, rel=1e-9
    )
    for route in ("welch", "student"):
        assert power_equivalence(0.0, 1e-300, -1e300, 1e300, 3, 3, route=route).power == pytest.approx(1.0, abs=1e-12)
        assert power_equivalence(1.0, 1e-300, -1.0, 0.5, 3, 3, route=route).power == 0.0
        tiny = power_equivalence(0.0, 1.0, -1.0, 1.0, 2, 2, 1e-100, route=route).power
        assert 0.0 < tiny < 1e-100
    never = power_percent_equivalence(0.0, 1e-200, 1.0, -10.0, 10.0, 4, 4).power
    assert never == pytest.approx(power_percent_equivalence(0.0, 1e-9, 1.0, -10.0, 10.0, 4, 4).power, abs=PERCENT)


def test_normal_probabilities_between_close_and_far_ends_keep_their_digits():
    for low, high in ((-1.0, 2.0), (5.0, 5.0 + 1e-9), (-30.0, -29.9), (37.0, 40.0), (-1e-12, 1e-12), (-3.0, -2.9)):
        with mpmath.workdps(400):
            truth = float(mpmath.ncdf(-mpmath.mpf(low)) - mpmath.ncdf(-mpmath.mpf(high)))
        found = normal_between(np.array([[low]]), np.array([[high]]))[0, 0]
        assert found == pytest.approx(
            truth, rel=2e-15 * (1.0 + high * high) + 4e-16 * abs(high) / (high - low), abs=0.0
        )


@pytest.mark.parametrize(
    ("low", "high", "slopes", "least"),
    [
        (-2.0, 1.5, (0.6, 2.0), -20.0),
        pytest.param(0.0, 7.0, (0.65, 5.3), -1.6, marks=pytest.mark.soak),
        (-3.0, 0.0, (50.0, 51.0), 0.0),
        pytest.param(2.0, -1.0, (0.5, 3.0), 0.4, marks=pytest.mark.soak),
        pytest.param(-3.7, -2.4, (108.0, 219.0), -4.2, marks=pytest.mark.soak),
    ],
)
def test_what_lies_between_two_lines_is_mpmaths(low, high, slopes, least):
    found = between_lines(np.array([low]), np.array([high]), *slopes, np.array([least]))[0]
    start = max(least, (low - high) / (slopes[1] - slopes[0]), -13.0)
    with mpmath.workdps(25):
        cuts = {-9.0, -3.0, 0.0, 3.0, 9.0}
        cuts |= {(k - end) / slope for end, slope in zip((low, high), slopes, strict=True) for k in (-9, -3, 0, 3, 9)}
        cuts = {cut for cut in cuts if start < cut < 13.0} | {start, 13.0}
        truth = mpmath.quad(
            lambda z: mpmath.npdf(z) * (mpmath.ncdf(high + slopes[1] * z) - mpmath.ncdf(low + slopes[0] * z)),
            sorted(cuts),
        )
    assert found == pytest.approx(float(truth), abs=1e-14)


def test_quantiles_of_many_degrees_of_freedom_are_those_of_one():
    df = np.array([1.0, 2.0000001, 3.7, 50.0, 1e4, 2e6])
    for tail in (0.45, 0.05, 1e-3, 1e-12, 1e-40):
        assert t_upper_quantiles(tail, df) == pytest.approx([t_upper_quantile(tail, each) for each in df], rel=1e-13)
