import math

import mpmath
import pytest
from scipy import special

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.compare.effect_size import (
    eta_squared_ci,
    hedges_factor,
    noncentral_f_interval,
    noncentral_t_interval,
)
from stats.exact.tails import f_tails, t_tails


def lower_t(t, df, delta):
    """P(T <= t) as an integral over S, at 25 digits."""
    with mpmath.workdps(25):
        scale = 2 * (mpmath.mpf(df) / 2) ** (mpmath.mpf(df) / 2) / mpmath.gamma(mpmath.mpf(df) / 2)
        width = 1 / math.sqrt(2 * df)
        marks = {max(0.0, 1 + k * width) for k in (-12, -6, -3, -1, 0, 1, 3, 6, 12, 40)} | {0.0}
        if t != 0 and delta / t > 0:
            marks |= {max(0.0, (delta + k) / t) for k in (-8, -3, 0, 3, 8)}

        def integrand(s):
            return mpmath.ncdf(t * s - delta) * scale * s ** (df - 1) * mpmath.exp(-df * s * s / 2)

        return mpmath.quad(integrand, sorted(marks))


@pytest.mark.parametrize(
    ("t", "df", "delta"),
    [(2.0, 4, 1.0), (2.0, 4, 5.0), (-1.0, 1, 0.5), (3.0, 18, 0.1), (30.0, 100, 24.0), (60.0, 4, 20.0), (0.3, 1, -2.0)],
)
def test_both_tails_of_the_noncentral_t(t, df, delta):
    lower, upper = t_tails(t, df, delta)
    right = lower_t(t, df, delta)
    assert lower == pytest.approx(float(right), rel=1e-13)
    assert upper == pytest.approx(float(1 - right), rel=1e-13)


@pytest.mark.parametrize("df_within", [3.0, 20.0, 500.0])
@pytest.mark.parametrize("noncentrality", [0.0, 0.7, 40.0, 5000.0])
def test_the_noncentral_f_of_one_degree_is_a_squared_t(df_within, noncentrality):
    for t in (0.4, 3.0, 60.0):
        delta = math.sqrt(noncentrality)
        lower, upper = f_tails(t * t, 1.0, df_within, noncentrality)
        both = t_tails(t, df_within, delta)[1] + t_tails(-t, df_within, delta)[0]
        assert upper == pytest.approx(both, rel=1e-11, abs=1e-15)
        assert lower + upper == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("level", [0.9, 0.95, 0.99])
@pytest.mark.parametrize(("t", "df"), [(0.0, 3.0), (2.0, 4.0), (-5.0, 8.0), (1e3, 4.0), (1e7, 8.0), (40.0, 1998.0)])
def test_the_ends_leave_the_stated_tails(t, df, level):
    low, high = noncentral_t_interval(t, df, level)
    assert t_tails(t, df, low)[1] == pytest.approx((1.0 - level) / 2.0, rel=1e-11)
    assert t_tails(t, df, high)[0] == pytest.approx((1.0 - level) / 2.0, rel=1e-11)


@pytest.mark.parametrize(("f", "a", "b"), [(3.0, 2.0, 27.0), (21.0, 8.0, 18000.0), (1e4, 3.0, 10.0), (300.0, 2.0, 1e5)])
def test_the_ends_of_f_leave_the_stated_tails(f, a, b):
    low, high = noncentral_f_interval(f, a, b, 0.95)
    assert low == 0.0 or f_tails(f, a, b, low)[1] == pytest.approx(0.025, rel=1e-10)
    assert f_tails(f, a, b, high)[0] == pytest.approx(0.025, rel=1e-10)
    assert 0.0 <= eta_squared_ci(f, a, b)[0] < eta_squared_ci(f, a, b)[1] < 1.0


def test_small_f_has_no_lower_end_and_undefined_stays_so():
    assert noncentral_f_interval(0.001, 3.0, 20.0, 0.95) == (0.0, 0.0)
    assert eta_squared_ci(Undefined(Reason.AS_SAID, said="no scatter"), 2, 20) == Undefined(
        Reason.AS_SAID, said="no scatter"
    )


def test_the_correction_at_all_sizes():
    assert hedges_factor(2.0) == pytest.approx(1.0 / math.gamma(0.5), rel=1e-15)
    assert hedges_factor(1e5) == pytest.approx(hedges_factor(1e5 + 1.0), rel=1e-9)
    assert 1.0 - 1e-5 < hedges_factor(1e5) < 1.0


@pytest.mark.parametrize("t", [1.0, 25.0, 50.0, 1e3, 1e80, 1e200])
@pytest.mark.parametrize("df", [2, 4, 10])
def test_the_interval_of_a_negative_effect_mirrors_that_of_a_positive_one(t, df):
    """Its upper end was 7e61 for t = -98 with 4 degrees of freedom."""
    low, high = noncentral_t_interval(t, df, 0.95)
    assert noncentral_t_interval(-t, df, 0.95) == pytest.approx((-high, -low), rel=1e-12)
    ends = [t * math.sqrt(2.0 * special.gammaincinv(df / 2.0, share) / df) for share in (0.025, 0.975)]
    if t > 1e9:
        assert (low, high) == pytest.approx(ends, rel=1e-12)


@pytest.mark.parametrize(("df_between", "df_within"), [(1, 4), (2, 9), (3, 200)])
@pytest.mark.parametrize("f", [1e8, 1e12, 1e20, 1e90])
def test_the_noncentrality_of_a_large_f(f, df_between, df_within):
    """Its upper end was 7e59 times too large from 1e18 on, and wrong by parts in a thousand from 1e14."""
    ends = noncentral_f_interval(f, df_between, df_within, 0.95)
    limits = [2.0 * special.gammaincinv(df_within / 2.0, share) / df_within for share in (0.025, 0.975)]
    moved = [df_between + df_within - 2.0 - limit * df_within for limit in limits]
    right = [f * df_between * limit - less for limit, less in zip(limits, moved, strict=True)]
    assert ends == pytest.approx(right, rel=1e-9)


def test_tails_of_many_join_the_sums_over_poissons_numbers():
    for df_between, df_within in ((2, 9), (1, 4), (5, 30)):
        start = 1.001e6 * df_within
        for share in (0.2, 1.0, 3.0):
            x = df_within * share
            many = f_tails(start * df_within / (df_between * x), df_between, df_within, start)
            with mpmath.workdps(30):
                # The mean over chi^2(df_between, lambda), which is normal to 1e-3 of its scatter.
                scale = mpmath.mpf(x) / start
                density = lambda y, df=df_within: (  # noqa: E731
                    mpmath.gammainc(mpmath.mpf(df) / 2, 0, y / 2, regularized=True)
                )
                nodes = [(-math.sqrt(3.0), 1 / 6), (0.0, 4 / 6), (math.sqrt(3.0), 1 / 6)]
                total = sum(
                    weight * density(scale * (start + df_between + node * math.sqrt(4 * start + 2 * df_between)))
                    for node, weight in nodes
                )
            assert many[1] == pytest.approx(float(total), rel=1e-9)
            assert sum(many) == pytest.approx(1.0, abs=1e-11)
