import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats as reference

from data_schema.errors import InputRefused
from stats.compare.limits_of_agreement import limits_of_agreement

WRIGHT = (494, 395, 516, 434, 476, 557, 413, 442, 650, 433, 417, 656, 267, 478, 178, 423, 427)
MINI = (512, 430, 520, 428, 500, 600, 364, 380, 658, 445, 432, 626, 260, 477, 259, 350, 451)
"""Peak expiratory flow by two meters, l/min: Bland and Altman (1986), table 1."""


def test_the_published_example_has_its_published_numbers() -> None:
    found = limits_of_agreement([a - b for a, b in zip(WRIGHT, MINI, strict=True)])
    assert found.mean == pytest.approx(-2.1, abs=0.05)
    assert (found.high - found.low) / (2 * 1.959964) == pytest.approx(38.8, abs=0.05)
    assert found.se == pytest.approx(9.4, abs=0.05)
    assert found.ci == pytest.approx((-22.0, 17.8), abs=0.1)


@given(st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=40), st.sampled_from([0.9, 0.95, 0.99]))
def test_the_mean_has_students_interval_and_limits_lie_z_deviations_from_it(values: list[float], level: float) -> None:
    found, sd = limits_of_agreement(values, level), float(np.std(values, ddof=1))
    z, t = reference.norm.ppf(0.5 + level / 2), reference.t.ppf(0.5 + level / 2, len(values) - 1)
    assert found.mean == pytest.approx(np.mean(values), abs=1e-9)
    assert found.ci[1] - found.mean == pytest.approx(t * sd / len(values) ** 0.5, rel=1e-9, abs=1e-9)
    assert found.mean - found.low == pytest.approx(z * sd, rel=1e-9, abs=1e-9)
    assert found.high - found.mean == pytest.approx(z * sd, rel=1e-9, abs=1e-9)
    assert found.low_ci[1] - found.low_ci[0] == pytest.approx(2 * t * found.limit_se, rel=1e-9, abs=1e-9)


def test_intervals_of_limits_cover_the_true_ones() -> None:
    rng, covered, n = np.random.default_rng(4), 0, 2000
    for _ in range(n):
        low, high = limits_of_agreement(rng.normal(0.3, 1.0, 20).tolist()).low_ci
        covered += low <= 0.3 - 1.959964 <= high
    assert 0.935 < covered / n < 0.97


@pytest.mark.parametrize("values", [[1.0, 2.0], [1.0, 2.0, float("nan")]])
def test_too_few_differences_are_refused(values: list[float]) -> None:
    with pytest.raises(InputRefused, match="at least 3"):
        limits_of_agreement(values)
