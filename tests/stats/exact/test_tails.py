import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
import scipy.stats

from stats.exact.tails import chi2_upper, f_two_sided, f_upper, normal_two_sided, t_two_sided, t_upper


def beta(a, b, x):
    return mpmath.betainc(mpmath.mpf(a), mpmath.mpf(b), 0, x, regularized=True)


def assert_tail(found, right):
    """12 digits, as is promised; where there is no double, of the logarithm."""
    if right > 1e-300:
        assert abs(found.p / right - 1) < 2e-12
    else:
        assert abs(mpmath.mpf(found.p) - right) < 1e-300
    log10_p = mpmath.log10(right)
    assert abs(found.log10_p - log10_p) <= 1e-12 * abs(log10_p) + 1e-16


@pytest.mark.parametrize("seed", range(40))
def test_t_and_f_from_the_middle_to_far_tails(seed):
    rng = np.random.default_rng(seed)
    with mpmath.workdps(60):
        df, t = float(np.exp(rng.uniform(0.0, 10.0))), float(np.exp(rng.uniform(-12.0, 8.0)))
        right = beta(df / 2, 0.5, mpmath.mpf(df) / (mpmath.mpf(df) + mpmath.mpf(t) ** 2))
        assert_tail(t_two_sided(t, df), right)
        assert_tail(t_upper(t, df), right / 2)
        assert_tail(t_upper(-t, df), 1 - right / 2)
        above, below = (float(np.floor(np.exp(rng.uniform(0.0, 8.0)))) for _ in range(2))
        f = float(np.exp(rng.uniform(-5.0, 6.0)))
        upper = beta(below / 2, above / 2, mpmath.mpf(below) / (below + mpmath.mpf(above) * f))
        assert_tail(f_upper(f, above, below), upper)
        lower = beta(above / 2, below / 2, mpmath.mpf(above) * f / (below + mpmath.mpf(above) * f))
        assert_tail(f_two_sided(f, above, below), 2 * min(upper, lower))


@pytest.mark.parametrize(("t", "df"), [(200.0, 1e5), (214.0, math.inf), (1e150, 3.0), (2e4, 800.0), (1e300, 33.0)])
def test_logarithms_down_to_1e_minus_10000(t, df):
    """Other programs print p = 0 and -inf for all of these."""
    with mpmath.workdps(60):
        if math.isinf(df):
            right = mpmath.erfc(mpmath.mpf(t) / mpmath.sqrt(2))
        else:
            right = beta(df / 2, 0.5, 1 / (1 + mpmath.mpf(t) ** 2 / df))
        found = t_two_sided(t, df)
        assert found.p == 0.0
        assert found.log10_p == pytest.approx(float(mpmath.log10(right)), rel=1e-14)
    assert -10_500.0 < found.log10_p < -300.0


@pytest.mark.parametrize(("x", "df"), [(3.0, 4), (0.001, 1), (900.0, 1000), (1e4, 7), (46_000.0, 3)])
def test_chi_squared(x, df):
    with mpmath.workdps(60):
        assert_tail(chi2_upper(x, df), mpmath.gammainc(mpmath.mpf(df) / 2, mpmath.mpf(x) / 2, regularized=True))


def test_the_normal_distribution():
    assert normal_two_sided(-2.0).p == pytest.approx(2.0 * scipy.stats.norm.sf(2.0), rel=1e-14)
    assert normal_two_sided(200.0).log10_p == pytest.approx(
        scipy.stats.norm.logsf(200.0) / math.log(10) + math.log10(2)
    )


def test_edges():
    assert (t_two_sided(0.0, 5.0).p, t_two_sided(0.0, 5.0).log10_p) == (1.0, 0.0)
    assert t_upper(0.0, 5.0).p == 0.5
    assert f_upper(0.0, 2, 9).p == chi2_upper(0.0, 3).p == 1.0
    assert f_two_sided(1.0, 7, 7).p == 1.0
    assert t_two_sided(Fraction(21, 10), Fraction(19, 2)).p == pytest.approx(t_two_sided(2.1, 9.5).p, rel=1e-14)
    assert t_two_sided(2.1, 1e8).p == pytest.approx(2.0 * scipy.stats.t.sf(2.1, 1e8), rel=1e-12)


@pytest.mark.parametrize(
    ("t", "ends"), [(0.01, (1e6, 1.0000001e6)), (30.0, (1e6, 1.0000001e6)), (1.7, (1.0000001e-12, 0.9999999e-12))]
)
def test_t_is_right_on_both_sides_of_where_its_series_begin(t, ends):
    for df in ends:
        with mpmath.workdps(60):
            assert_tail(t_two_sided(t, df), beta(df / 2, 0.5, 1 / (1 + mpmath.mpf(t) ** 2 / df)))


@pytest.mark.parametrize(("t", "df"), [(2.0, 2e6), (20.0, 3e6), (36.0, 1e7)])
def test_many_degrees_of_freedom_keep_their_digits(t, df):
    with mpmath.workdps(60):
        assert_tail(t_two_sided(t, df), beta(df / 2, 0.5, 1 / (1 + mpmath.mpf(t) ** 2 / df)))


@pytest.mark.parametrize("df", [1e17, 1e50, 1e300])
def test_many_degrees_of_freedom_are_a_normal(df):
    assert t_two_sided(2.0, df).p == normal_two_sided(2.0).p
    assert t_two_sided(1e3, df).log10_p == pytest.approx(normal_two_sided(1e3).log10_p, rel=1e-10)
