"""Stiffness and damping from trajectories, and lines over gains: known truth, statsmodels, and what is refused."""

import numpy as np
import pytest
import statsmodels.api as sm

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.compare.summary import autocorrelation
from stats.lines.stiffness import fit_gain_line, fit_stiffness, force_points, velocity_over_rate
from tests.helpers.wording import refuses

GAINS = np.array([50.0, 100.0, 150.0, 200.0, 250.0])


def oscillation(k, d, mass_kg, seconds=1.0, rate_hz=300.0, start_m=0.03):
    """A mass on a spring and damper, pushed down and let go: displacement and velocity about rest."""
    t = np.arange(0.0, seconds, 1.0 / rate_hz)
    decay, frequency = d / (2.0 * mass_kg), np.sqrt(k / mass_kg - (d / (2.0 * mass_kg)) ** 2)
    wave, quarter = np.cos(frequency * t), np.sin(frequency * t)
    x = start_m * np.exp(-decay * t) * (wave + decay / frequency * quarter)
    v = -start_m * np.exp(-decay * t) * (frequency + decay**2 / frequency) * quarter
    return t, x, v


def trajectories(k, d, masses, noise_m_s=0.0, seed=0):
    rng = np.random.default_rng(seed)
    parts = []
    for mass in masses:
        t, x, v = oscillation(k, d, mass)
        parts.append(force_points(t, x, v + rng.normal(0.0, noise_m_s, v.size), mass))
    return [np.concatenate(column) for column in zip(*parts, strict=True)]


@pytest.mark.parametrize(("k", "d"), [(195.4, 20.0), (323.4, 35.0), (579.4, 53.0), (1091.4, 86.0)])
def test_stiffness_and_damping_come_out_of_trajectories(k, d):
    """At 300 Hz the differences cost less than 1 % of either (thesis 4.2.6: several masses a condition)."""
    found = fit_stiffness(*trajectories(k, d, [6.0, 9.0, 12.0]))
    assert found.n == 897
    assert found.coefficients[1:] == pytest.approx((k, d), rel=0.01)
    assert found.coefficients[0] == pytest.approx(0.0, abs=1e-3)


def test_the_plane_far_from_the_origin_is_that_of_statsmodels_about_0():
    """W18: at an offset of 1e6 others return F0 = 0.02 and 5 digits of k."""
    rng = np.random.default_rng(18)
    x, v = 1e6 + rng.uniform(-0.02, 0.02, 300), rng.uniform(-1.0, 1.0, 300)
    force = 20000.0 * (x - 1e6) + 15.0 * v + rng.normal(0.0, 2.0, 300)
    right, found = sm.OLS(force, sm.add_constant(np.column_stack([x - 1e6, v]))).fit(), fit_stiffness(x, v, force)
    at_zero = right.t_test([1.0, -1e6, 0.0])
    assert found.coefficients == pytest.approx((at_zero.effect[0], *right.params[1:]), rel=1e-9)
    assert found.standard_errors == pytest.approx((at_zero.sd.item(), *right.bse[1:]), rel=1e-9)


@pytest.mark.parametrize("carried", [0.8, -0.5])
def test_the_correlation_of_neighbouring_values_is_that_of_lag_1(carried):
    """Noise of which each value carries a share of the one before: lag 2 would show the square of it."""
    noise = np.random.default_rng(21).normal(0.0, 1.0, 2000)
    for place in range(1, noise.size):
        noise[place] += carried * noise[place - 1]
    assert autocorrelation(noise) == pytest.approx(carried, abs=4.0 * ((1.0 - carried**2) / 2000) ** 0.5)


def test_w20_a_plane_that_is_not_fixed_is_refused_by_name():
    """Others: k = 766 and d = -3832 for 20000 and 15, without a word."""
    with refuses(InputRefused, "249 points", "250"):
        fit_stiffness(*(part[:249] for part in trajectories(579.4, 53.0, [6.0])))
    x = np.linspace(-0.02, 0.02, 300)
    with refuses(InputRefused, "'displacement'", "'velocity'"):
        fit_stiffness(x, -5.0 * x, 20000.0 * x)
    with refuses(InputRefused, "'velocity'"):
        fit_stiffness(x, np.zeros(300), 20000.0 * x)


@pytest.mark.parametrize(("slope", "offset"), [(2.56, 67.36), (3.32, 19.67)])
def test_the_published_lines_come_out_of_points_on_them(slope, offset):
    """Thesis 5.1.1: k = 2.56 g + 67.36 N/m and d = 3.32 g + 19.67 kg/s; gain 300 stands for 835.36 N/m."""
    found = fit_gain_line(GAINS, offset + slope * GAINS)
    assert (found.slope, found.offset) == pytest.approx((slope, offset), rel=1e-12)
    assert found.gains == (50.0, 250.0)
    scattered = fit_gain_line(GAINS, offset + slope * GAINS + np.array([4.0, -3.0, 1.0, -5.0, 3.0]))
    assert scattered.slope_ci[0] < slope < scattered.slope_ci[1]


ERRORS = np.array([0.2, 0.5, 1.0, 2.0, 3.0])


def test_conditions_weigh_by_their_errors():
    """Where they scatter by less than their errors, the line is that of weighted least squares."""
    values = 67.36 + 2.56 * GAINS + ERRORS * np.array([0.5, -0.4, 0.6, -0.3, 0.2])
    right = sm.WLS(values, sm.add_constant(GAINS), weights=ERRORS**-2.0).fit()
    found = fit_gain_line(GAINS, values, standard_error=ERRORS)
    assert found.scatter_sd == 0.0
    assert (found.offset, found.slope) == pytest.approx(tuple(right.params), rel=1e-9)
    assert (found.offset_se, found.slope_se) == pytest.approx(tuple(right.bse), rel=1e-9)
    assert (found.fit.df, found.fit.n) == (3, 5)


def test_conditions_that_scatter_more_than_their_errors_weigh_nearly_alike():
    """The scatter is such that the weighted squares about the line are its degrees of freedom (Paule and Mandel)."""
    values = 67.36 + 2.56 * GAINS + np.array([20.0, -30.0, 10.0, -25.0, 15.0])
    found, plain = fit_gain_line(GAINS, values, standard_error=ERRORS), fit_gain_line(GAINS, values)
    left = (values - found.offset - found.slope * GAINS) / np.hypot(ERRORS, found.scatter_sd)
    assert left @ left == pytest.approx(found.fit.df, rel=1e-9)
    assert found.slope == pytest.approx(plain.slope, rel=1e-3)
    assert found.slope_se == pytest.approx(plain.slope_se, rel=0.02)


@pytest.mark.soak
@pytest.mark.parametrize("scatter", [0.0, 10.0])
def test_intervals_of_weighted_lines_cover_what_was_put_in(scatter):
    """Without weights the offset's covered .99 of lines through points whose errors differ."""
    rng, covered = np.random.default_rng(11), np.zeros(2)
    for _ in range(600):
        values = 67.36 + 2.56 * GAINS + rng.normal(0.0, ERRORS) + rng.normal(0.0, scatter, GAINS.size)
        found = fit_gain_line(GAINS, values, standard_error=ERRORS)
        for place, (interval, true) in enumerate(((found.offset_ci, 67.36), (found.slope_ci, 2.56))):
            covered[place] += interval[0] <= true <= interval[1]
    assert np.all(np.abs(covered / 600 - 0.95) < 3.29 * (0.95 * 0.05 / 600) ** 0.5)


@pytest.mark.parametrize(
    ("gains", "values", "options", "said"),
    [
        (GAINS, GAINS, {"standard_error": np.zeros(5)}, "standard errors"),
        (GAINS, GAINS, {"standard_error": np.ones(4)}, "5 gains.* 4 standard errors"),
        ([100.0, 200.0], [1.0, 2.0], {}, "has no uncertainty"),
        ([100.0, 200.0], [1.0, 2.0], {"standard_error": [1.0, 1.0]}, "has no uncertainty"),
        ([100.0, 200.0, 300.0], [1.0, 2.0, np.nan], {}, "NaN"),
        ([100.0, 200.0], [1.0, 2.0, 3.0], {}, "has 2 values and y has 3"),
        ([100.0] * 3, [1.0, 2.0, 3.0], {}, "'gain' is constant"),
        ([100.0] * 3, [1.0, 2.0, 3.0], {"standard_error": [1.0, 2.0, 3.0]}, "'gain' is constant"),
    ],
)
def test_gains_that_make_no_line_are_refused(gains, values, options, said):
    with pytest.raises(InputRefused, match=said):
        fit_gain_line(gains, values, **options)


def test_planes_and_lines_without_a_rest_have_no_intervals():
    line = fit_gain_line([1.0, 2.0, 3.0], [1.0, 2.0, 3.0])
    assert (line.slope, line.slope_se) == (pytest.approx(1.0), 0.0)
    assert isinstance(line.slope_ci, Undefined)
    assert line.offset_ci == line.slope_ci
    x, v = np.arange(250) % 5.0, np.arange(250) % 7.0
    plane = fit_stiffness(x, v, 2.0 * x + 3.0 * v)
    assert plane.coefficients[1:] == pytest.approx((2.0, 3.0))
    assert plane.ci == line.slope_ci


@pytest.mark.parametrize(
    ("t", "mass", "sentence"),
    [
        ([0.0, 1.0], 1.0, "2 times, 3 displacements"),
        ([0.0, 1.0, 1.0], 1.0, "does not increase"),
        ([0.0, 1.0, 2.0], 0.0, "the mass is 0"),
    ],
)
def test_trajectories_that_are_none_are_refused(t, mass, sentence):
    with pytest.raises(InputRefused, match=sentence):
        force_points(t, [0.0, 1.0, 2.0], [0.0, 1.0, 2.0], mass)


@pytest.mark.parametrize("factor", [1e-3, -1.0, 1.0, 3.6, 1000.0])
def test_a_velocity_of_another_unit_shows_by_its_factor(factor):
    t, x, v = oscillation(600.0, 8.0, 2.0)
    assert velocity_over_rate(t, x + 0.07, factor * v) == pytest.approx(abs(factor), rel=1e-3)
    # a leg at rest, and few samples, tell nothing of it
    assert velocity_over_rate(t, np.full(t.size, 0.07), np.zeros(t.size)) is None
    assert velocity_over_rate(t[:19], x[:19], v[:19]) is None
    assert velocity_over_rate(t, x, np.random.default_rng(1).permutation(v)) is None
