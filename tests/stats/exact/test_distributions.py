import math

import pytest
import scipy.stats

from stats.exact.distributions import f_upper_p, t_quantile, t_two_sided_p


@pytest.mark.parametrize("df", [1.0, 2.5, 9.0, 48.7, 1e6])
@pytest.mark.parametrize("t", [0.0, 0.3, -2.2, 12.0])
def test_t_tails_agree_with_the_distribution_object(t, df):
    assert t_two_sided_p(t, df) == pytest.approx(2.0 * scipy.stats.t.sf(abs(t), df), rel=1e-10)


@pytest.mark.parametrize("level", [0.5, 0.9, 0.95, 0.999])
@pytest.mark.parametrize("df", [1.0, 3.3, 24.0, 300.0, math.inf])
def test_quantiles_invert_the_tails(level, df):
    quantile = t_quantile(level, df)
    tail = scipy.stats.norm.sf(quantile) if df == math.inf else scipy.stats.t.sf(quantile, df)
    assert 2.0 * tail == pytest.approx(1.0 - level, rel=1e-9)


@pytest.mark.parametrize("f", [0.01, 0.7, 1.0, 5.0, 80.0])
def test_f_tails(f):
    assert f_upper_p(f, 4, 45) == pytest.approx(scipy.stats.f.sf(f, 4, 45), rel=1e-10)


def test_a_two_sided_p_is_at_most_one():
    assert t_two_sided_p(0.0, 3) == 1.0
