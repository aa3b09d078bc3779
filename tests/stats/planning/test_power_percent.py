"""Power at bounds in percent of the control's mean: held to the test itself on drawn values, and to its limits."""

from __future__ import annotations

import math

import numpy as np
import pytest

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.compare.equivalence import equivalence
from stats.planning.power import power_equivalence
from stats.planning.power_percent import power_percent_equivalence
from tests.helpers.wording import says

STUDIES = 3000


@pytest.mark.soak
@pytest.mark.parametrize(
    ("difference", "mean", "sd", "low", "high", "n_a", "n_b"),
    [
        (0.0, 0.3, 0.0075, -3.0, 3.0, 6, 6),
        (0.001, 0.3, 0.0075, -3.0, 3.0, 20, 5),
        (0.0, 1.0, 0.5, -50.0, 60.0, 20, 5),
        (0.0, 1.0, 0.6, -60.0, 90.0, 3, 4),
        (0.0, 1.0, 0.25, -20.0, 40.0, 40, 8),
    ],
)
def test_the_test_itself_finds_as_much(
    difference: float, mean: float, sd: float, low: float, high: float, n_a: int, n_b: int
) -> None:
    random = np.random.default_rng(20211005)
    found = 0
    for _study in range(STUDIES):
        a, b = random.normal(mean + difference, sd, n_a), random.normal(mean, sd, n_b)
        found += equivalence(a, b, low=low, high=high, bounds="percent").equivalent is True
    power = power_percent_equivalence(difference, mean, sd, low, high, n_a, n_b).power
    assert isinstance(power, float)
    assert abs(found / STUDIES - power) < 3.5 * math.sqrt(power * (1.0 - power) / STUDIES)


def test_a_mean_taken_as_known_would_claim_too_much_or_too_little() -> None:
    """With a tenth of scatter the control's own error counts; with a thousandth it does not."""
    known = power_equivalence(0.0, 0.3, -0.3, 0.3, 12, 12).power
    estimated = power_percent_equivalence(0.0, 1.0, 0.3, -30.0, 30.0, 12, 12).power
    assert isinstance(known, float)
    assert isinstance(estimated, float)
    assert known - estimated > 0.01
    known = power_equivalence(0.0, 0.001, -0.001, 0.001, 12, 12).power
    assert power_percent_equivalence(0.0, 1.0, 0.001, -0.1, 0.1, 12, 12).power == pytest.approx(known, abs=1e-3)


def test_what_has_no_power_says_why() -> None:
    assert isinstance(power_percent_equivalence(0.0, 1.0, 0.1, -3, 3, 1, 5).power, Undefined)
    never = power_percent_equivalence(0.05, 1.0, 0.1, -3, 3, 5, 5).never
    assert never is not None
    says(never.text, "5 %", "not lie between", "-3", "3 %")
    for mean, low, alpha, said in (
        (0.0, -3.0, 0.05, "mean"),
        (1.0, -100.0, 0.05, "low"),
        (1.0, -3.0, 0.5, "below 0.5"),
    ):
        with pytest.raises(InputRefused, match=said):
            power_percent_equivalence(0.0, mean, 0.1, low, 3.0, 5, 5, alpha)
