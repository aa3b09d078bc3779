"""Tails at a known standard deviation: the integrals against 25 digits, the polynomials against the integrals."""

import math

import numpy as np
import pytest
import scipy.special

from stats.exact.family_tails import log_mean_over_scale
from stats.groups.dunnett import LargestAgainstControl, largest_log_upper
from stats.groups.tukey import RangeOfNormals

STEEP = LargestAgainstControl(2, ((2, 1), (1_000_000, 1)), two_sided=True)
"""A treatment of a million values against a control of 2: its chance is a step, 700 times narrower than a normal."""
TWO_STEPS = LargestAgainstControl(25, ((100, 1), (10_000, 1)), two_sided=True)
ONE_SIDED = LargestAgainstControl(1, ((1, 1), (10, 1), (1000, 1)), two_sided=False)
THOUSAND = LargestAgainstControl(4, ((4, 1000),), two_sided=True)
MANY_LARGE = LargestAgainstControl(1, ((100, 300),), two_sided=False)
FAMILIES = (STEEP, TWO_STEPS, ONE_SIDED, THOUSAND, MANY_LARGE, RangeOfNormals(3), RangeOfNormals(20))


@pytest.mark.parametrize(
    ("family", "w", "log_g"),
    [
        (STEEP, 0.4, -0.13938552452491915),
        (STEEP, 2.5, -3.8264850781000437),
        (STEEP, 9.0, -42.241936544201942),
        (TWO_STEPS, 0.4, -0.19898949166861984),
        (TWO_STEPS, 2.5, -3.9856463047451869),
        (TWO_STEPS, 9.0, -42.257301027332317),
        (ONE_SIDED, -1.3, -0.038739458356687368),
        (ONE_SIDED, 2.5, -4.3604790139496194),
        (ONE_SIDED, 9.0, -42.583582076659775),
        (THOUSAND, 1.7, -7.6150000939097577e-9),
        (THOUSAND, 3.3, -1.717239604080615),
        (THOUSAND, 9.0, -36.027319016519265),
        (MANY_LARGE, -0.4, -0.28147721722782254),
        (MANY_LARGE, 2.5, -4.3345508479140185),
        (MANY_LARGE, 9.0, -41.381780802855216),
    ],
)
def test_tails_of_very_unequal_sizes_and_of_many_treatments(family, w, log_g):
    """The definition by mpmath to 22 digits, Gauss's rule over y on stretches of half a width of each step."""
    assert float(family.log_tail(np.array([w]))[0]) == pytest.approx(log_g, abs=2e-14)


@pytest.mark.parametrize("family", FAMILIES)
def test_the_polynomials_are_the_integrals(family):
    rng = np.random.default_rng(1)
    lowest = 0.0 if getattr(family, "two_sided", True) else -9.0
    w = np.concatenate([rng.uniform(lowest, 9.0, 200), 2.0 ** rng.uniform(3.0, 9.0, 20)])
    direct = family.log_chance(w)
    np.testing.assert_allclose(family.log_tail(w), direct, rtol=2e-15, atol=2e-14)
    rounding = 1e-13 + 1e-15 * w * w
    assert np.all(direct <= family.log_bound(w) + rounding)
    assert np.all(direct >= family.log_bound(w) - family.slack - rounding)


@pytest.mark.parametrize("family", FAMILIES)
def test_beyond_the_last_place_tails_fall_on(family):
    """There log g is -fall w^2 - log w and a constant, to the inverse of w^2."""
    near, far = family.log_tail(np.array([511.0, 2000.0]))
    fallen = family.fall * (2000.0**2 - 511.0**2) + math.log(2000.0 / 511.0)
    assert far == pytest.approx(near - fallen, rel=1e-9)


@pytest.mark.parametrize(("n_control", "n_treated"), [(2, (1_000_000, 2)), (25, (10_000, 100)), (5, (500, 5))])
@pytest.mark.parametrize(("c", "df"), [(0.7, 3), (2.5, 10), (6.0, 40)])
def test_p_of_very_unequal_sizes(n_control, n_treated, c, df):
    """Gauss's rule over the scale, the tail at each scale by integration rather than by the polynomials."""
    nodes, widths = np.polynomial.legendre.leggauss(160)
    s = 2.5 * (nodes + 1.0)
    density = 2.0 * (df / 2.0) ** (df / 2.0) / math.gamma(df / 2.0) * s ** (df - 1.0) * np.exp(-df * s * s / 2.0)
    family = LargestAgainstControl(n_control, tuple((n, 1) for n in sorted(n_treated)), two_sided=True)
    p = float(2.5 * widths @ (density * np.exp(family.log_chance(c * s))))
    found = largest_log_upper(c, n_control, n_treated, df, two_sided=True)
    assert math.exp(found) == pytest.approx(p, rel=1e-12)


@pytest.mark.parametrize("df", [1.0, 3.7, 31.9, 32.1, 1e4, 1e9, math.inf])
def test_the_mean_over_the_scale_at_any_number_of_degrees_of_freedom(df):
    """One treatment's largest T is t: scipy's own tail beside it."""
    found = log_mean_over_scale(LargestAgainstControl(3, ((5, 1),), two_sided=False), df, 2.0)
    exact = scipy.special.stdtr(df, -2.0) if math.isfinite(df) else scipy.special.ndtr(-2.0)
    assert math.exp(found) == pytest.approx(exact, rel=1e-13 if df < 1e6 else 1e-12)


@pytest.mark.parametrize("k", [2, 30, 100, 1000, 100_000])
def test_the_range_of_many_normals(k):
    """Gauss's rule on stretches of a quarter, where the trapezoidal rule at 0.2 lost seven digits for 1000 normals."""
    w = np.array([0.6, 1.5, 3.0, 4.4, 6.0, 9.0])
    nodes, widths = np.polynomial.legendre.leggauss(20)
    z = (np.arange(-9.5, 20.0, 0.25)[:, None] + 0.125 * (1.0 + nodes)).ravel()[:, None]
    phi, cdf = np.exp(-0.5 * z * z) / math.sqrt(2.0 * math.pi), scipy.special.ndtr(z)
    inside = np.log1p(-np.minimum(scipy.special.ndtr(z - w) / cdf, 1.0 - 2.0**-53))
    f = k * phi * np.exp((k - 1) * scipy.special.log_ndtr(z)) * -np.expm1((k - 1) * inside)
    g = 0.125 * np.tile(widths, 118) @ f
    np.testing.assert_allclose(np.exp(RangeOfNormals(k).log_tail(w)), g, rtol=1e-13)
