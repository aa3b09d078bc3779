"""The JZS Bayes factor against mpmath and R's BayesFactor, far beyond the range of doubles."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import pytest

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.compare.effect_size import bayes_factor
from tests.helpers.exact_tests import log10_bayes_factor
from tests.helpers.wording import refuses, says

CASES = [
    (2.5, 20, 20, 0.5**0.5),
    (3.0, 10, 0, 0.5**0.5),
    (1.5, 100_000, 100_000, 0.5**0.5),
    (1e6, 5, 5, 1.4),
]
FURTHER = [
    (0.0, 20, 20, 0.5**0.5),
    (-2.5, 20, 20, 0.5**0.5),
    (0.3, 2, 2, 1.0),
    (5.0, 3, 100, 0.2),
    (40.0, 200, 150, 0.5**0.5),
    (1464.0, 400, 400, 0.5**0.5),
    (12.0, 3, 0, 1.0),
]


@pytest.mark.parametrize(
    ("t", "n_a", "n_b", "r"), [*CASES, *(pytest.param(*case, marks=pytest.mark.soak) for case in FURTHER)]
)
def test_is_the_integral_of_its_definition(t, n_a, n_b, r):
    assert bayes_factor(t, n_a, n_b, r).log10_bf == pytest.approx(
        log10_bayes_factor(t, n_a, n_b, r), rel=1e-12, abs=1e-12
    )


def test_agrees_with_the_r_package():
    """R integrates to 1.2e-4 of the factor at worst (its default), so that no more digits can be asked for."""
    with (Path(__file__).parents[1] / "r" / "bayes_factor.csv").open() as file:
        for row in csv.DictReader(file):
            found = bayes_factor(float(row["t"]), int(row["n_a"]), int(row["n_b"]), float(row["scale"]))
            assert found.log10_bf * math.log(10.0) == pytest.approx(float(row["log_bf"]), abs=2e-5), row


def test_w8_it_never_overflows():
    """W8: pingouin's bayesfactor_ttest(1464, 400, 400) raises ZeroDivisionError, or returns 'inf'; true 3.6e1364."""
    found = bayes_factor(1464.0, 400, 400)
    says(found.sentence(), "3.6e1364", "times as likely")
    assert bayes_factor(1e300, 20, 20).log10_bf > 11_000.0


def test_sign_and_words():
    assert bayes_factor(0.0, 50, 50).log10_bf < 0.0
    assert "under no effect" in bayes_factor(0.0, 50, 50).sentence()
    assert "n = 12)" in bayes_factor(2.0, 12).sentence()


def test_a_mantissa_that_rounds_to_ten_becomes_the_next_power_of_ten():
    found = bayes_factor(8.16, 20, 20)
    assert 6.995 < found.log10_bf < 7.0
    says(found.sentence(), "1e7 times")


def test_too_few_values_and_refusals():
    assert isinstance(bayes_factor(1.0, 1).log10_bf, Undefined)
    assert isinstance(bayes_factor(1.0, 1, 1).log10_bf, Undefined)
    assert bayes_factor(1.0, 1).sentence().startswith("No Bayes factor")
    for wrong in (
        lambda: bayes_factor(float("inf"), 5, 5),
        lambda: bayes_factor(1.0, 5, 5, 0.0),
        lambda: bayes_factor(1.0, -1),
    ):
        with pytest.raises(InputRefused):
            wrong()


def test_samples_in_place_of_t_are_refused_without_their_values():
    with refuses(InputRefused, "3 values"):
        bayes_factor([1.0, 2.0, 3.0], [2.0, 3.0, 4.0])
