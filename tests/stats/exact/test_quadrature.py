"""Gauss's rule on panels, the density of an estimated scale, critical values; tails are tested with their tests."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest

from stats.exact.quadrature import critical_values, gauss_nodes, log_scale_density, stirling_rest
from stats.exact.tails import t_upper, t_upper_quantile


def test_the_rule_is_exact_for_polynomials_on_panels_of_any_length():
    nodes, weights = gauss_nodes(np.array([[-1.0, -1.0, 2.0], [0.0, 0.25, 1.0]]))
    powers = (weights * nodes ** np.array([[30.0], [31.0]])).sum(axis=1)
    assert powers == pytest.approx([(2.0**31 + 1.0) / 31.0, 1.0 / 32.0], rel=1e-13)


@pytest.mark.parametrize("tail", [0.999, 0.05, 1e-12, 1e-200])
def test_the_critical_value_of_one_comparison_is_that_of_t(tail):
    df = np.array([1.0, 3.5, 80.0])

    def log_upper(t, rows):
        return np.array([math.log(10.0) * t_upper(each, n).log10_p for each, n in zip(t, df[rows], strict=True)])

    found = critical_values(log_upper, tail, df, 1, two_sided=False)
    assert found == pytest.approx([t_upper_quantile(tail, each) for each in df.tolist()], rel=1e-12)


def test_densities_keep_their_digits_with_many_degrees_of_freedom():
    with mpmath.workdps(40):
        for x in (0.5, 3.0, 15.9, 16.1, 1e6):
            exact = mpmath.mpf(x)
            rest = mpmath.loggamma(exact) - (exact - 0.5) * mpmath.log(exact) + exact - mpmath.log(2 * mpmath.pi) / 2
            assert stirling_rest(x) == pytest.approx(float(rest), abs=2e-15)
        for df in (1.0, 30.0, 2e3, 2e6):
            for steps in (-5.0, -0.5, 0.0, 2.0):
                at = steps / math.sqrt(2.0 * df)
                half, log_u = mpmath.mpf(df) / 2, mpmath.mpf(at)
                exact = mpmath.log(2) + half * mpmath.log(half) - mpmath.loggamma(half)
                exact += df * log_u - half * mpmath.exp(2 * log_u)
                assert log_scale_density(np.array([[at]]), np.array([df]))[0, 0] == pytest.approx(
                    float(exact), abs=1e-13
                )
