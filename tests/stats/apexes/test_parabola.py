import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stats.apexes.flights import fit_parabolas

GRAVITY = 9.80665
HALF_WINDOW_S = 0.055


def hops(n, rate_hz, sd_m, rng):
    """One array with n separate apexes of 15 cm hops, each at a random phase of the sampling grid."""
    spacing = 1.0
    apex_s = np.arange(n) * spacing + 0.5 + rng.uniform(0.0, 1.0 / rate_hz, n)
    time_s = np.concatenate([np.arange(-0.1, 0.1, 1.0 / rate_hz) + k * spacing + 0.5 for k in range(n)])
    which = np.repeat(np.arange(n), time_s.size // n)
    height_m = 0.42 - 0.5 * GRAVITY * (time_s - apex_s[which]) ** 2 + rng.normal(0.0, sd_m, time_s.size)
    return time_s, height_m, apex_s


def fit(time_s, height_m, around_s):
    return fit_parabolas(time_s, height_m, around_s, around_s - HALF_WINDOW_S, around_s + HALF_WINDOW_S)


@pytest.mark.parametrize(("rate_hz", "bias_m", "rmse_m"), [(1000.0, 0.02e-3, 0.2e-3), (300.0, 0.03e-3, 0.3e-3)])
@pytest.mark.parametrize(
    "spoilt", [*(pytest.param(each, marks=pytest.mark.soak) for each in ("clean", "dropouts")), "spikes"]
)
def test_monte_carlo_of_a_15_cm_hop(rate_hz, bias_m, rmse_m, spoilt):
    """1 mm of noise, 0.11 s window; a moving average of the same window is 5 mm low, a raw maximum 1.8 mm high."""
    rng = np.random.default_rng(21)
    n = 4000
    time_s, height_m, apex_s = hops(n, rate_hz, 0.001, rng)
    if spoilt == "dropouts":
        kept = rng.random(time_s.size) > 0.1
        time_s, height_m = time_s[kept], height_m[kept]
    if spoilt == "spikes":
        hit = rng.random(time_s.size) < 0.02
        height_m[hit] += rng.choice([-0.45, 0.45], int(hit.sum()))
    found = fit(time_s, height_m, apex_s + rng.normal(0.0, 0.004, n))
    errors = found.apex_height_m - 0.42
    assert found.defined.all()
    assert abs(errors.mean()) < bias_m
    assert np.sqrt(np.mean(errors**2)) < rmse_m
    # The stated standard error is that of the errors found.
    assert np.sqrt(np.mean((errors / found.apex_height_se_m) ** 2)) == pytest.approx(1.0, abs=0.1)
    assert found.curvature_m_s2.mean() == pytest.approx(GRAVITY, abs=0.05)


@given(
    st.floats(0.2, 0.6),
    st.floats(5.0, 15.0),
    st.floats(-0.01, 0.01),
    st.floats(0.0, 1e6),
)
def test_an_exact_parabola_is_returned_exactly(height, curvature, apex, origin):
    time_s = np.round(np.arange(-0.06, 0.06, 1 / 300), 9) + round(origin)
    apex_s = round(origin) + apex
    found = fit(time_s, height - 0.5 * curvature * (time_s - apex_s) ** 2, np.array([float(round(origin))]))
    assert found.apex_height_m[0] == pytest.approx(height, abs=1e-9)
    assert found.apex_s[0] == pytest.approx(apex_s, abs=1e-7)
    assert found.curvature_m_s2[0] == pytest.approx(curvature, rel=1e-5)
    assert found.apex_height_se_m[0] < 1e-9


def test_least_squares_is_the_limit_without_outliers():
    """Bisquare keeps 95 % of the precision of least squares on normal noise; numpy's polyfit is the second method."""
    rng = np.random.default_rng(2)
    time_s = np.arange(-0.055, 0.055, 0.001)
    height_m = 0.4 - 0.5 * GRAVITY * time_s**2 + rng.normal(0.0, 0.001, time_s.size)
    found = fit(time_s, height_m, np.array([0.0]))
    square, linear, constant = np.polyfit(time_s, height_m, 2)
    assert found.apex_height_m[0] == pytest.approx(constant - linear**2 / (4 * square), abs=0.05e-3)
    assert found.curvature_m_s2[0] == pytest.approx(-2 * square, abs=0.2)
    assert found.samples_before[0] + found.samples_after[0] == time_s.size


def test_what_is_no_maximum_or_has_too_few_samples_is_not_defined():
    time_s = np.arange(0.0, 1.0, 0.01)
    valley = fit(time_s, 0.3 + (time_s - 0.5) ** 2, np.array([0.5]))
    assert not valley.defined[0]
    assert not fit(time_s[:3], np.array([0.3, 0.4, 0.3]), np.array([0.01])).defined[0]
    assert not fit(time_s, np.full(time_s.size, 0.3), np.array([99.0])).defined[0]
    assert fit(time_s, time_s, np.empty(0)).defined.shape == (0,)
