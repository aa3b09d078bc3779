import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.rounding import USUAL_ALPHAS, level_text
from data_schema.vocabulary import Undefined
from stats.compare.equivalence import equivalence
from stats.compare.savings import percent_savings
from stats.compare.summary import describe
from stats.compare.two_sample import compare_two
from stats.groups.tukey import compare_all_pairs
from stats.groups.welch_anova import welch_anova
from stats.lines.regression import fit_linear
from stats.wording import df_text, estimate_texts, interval_text, number_text, p_text


@pytest.mark.parametrize(
    ("value", "text"),
    [(42.6, "42.6"), (0.0, "0"), (-0.0, "0"), (123456.7, "123457"), (0.00012345, "0.0001234"), (-3.14159, "-3.142")],
)
def test_numbers_are_rounded_for_display_only(value, text):
    assert number_text(value) == text


@pytest.mark.parametrize(
    ("value", "within", "text"),
    [
        (1000000.3456, 0.42, "1000000.35"),
        (1000000.3456, 4200.0, "1000000"),
        (3.14159, 10.0, "3.142"),
        (0.1, 1e-30, "0.1"),
        (0.1 + 0.2, 1e-30, "0.30000000000000004"),
        (1e19, 3.25, "1e+19"),
        (1234567890123456789.0, 512.0, "1.2345678901234568e+18"),
        (0.0, 1e-9, "0"),
        (2.5, math.inf, "2.5"),
    ],
)
def test_a_number_has_the_digits_of_what_it_lies_within_and_no_more_than_a_double_has(value, within, text):
    assert number_text(value, within=within) == text


@pytest.mark.parametrize(
    ("values", "se", "texts"),
    [
        ([26.3148, 25.1, 27.52], 0.42, ["26.31", "25.10", "27.52"]),
        ([2.0, 2.0 - 4e-16, 2.0 + 4e-16], 2e-16, ["2.00000000000000"] * 3),
        ([0.62], 0.0, ["0.620"]),
        ([1.25e-9], 0.0, ["0.00000000125"]),
        ([1.25e-30, 1.2e-30], 1e-32, ["1.25e-30", "1.2e-30"]),
        ([3e200], 1e198, ["3e+200"]),
        ([0.0, 0.0], 0.0, ["0", "0"]),
    ],
)
def test_an_estimate_has_the_decimals_of_its_error_and_no_more_than_a_double_holds(values, se, texts):
    assert estimate_texts(values, se) == texts


def test_p_values():
    assert p_text(0.0412) == "p = 0.041"
    assert p_text(1e-7) == "p < 0.0001"
    assert p_text(Undefined("no scatter")) == "p undefined"


@pytest.mark.parametrize(
    ("p", "alpha", "text"),
    [
        (0.05, 0.05, "p = 0.05"),
        (0.0503, 0.05, "p = 0.0503"),
        (0.0496, 0.05, "p = 0.0496"),
        (0.05000001, 0.05, "p = 0.05000001"),
        (math.nextafter(0.05, 1.0), 0.05, "p = 0.05000000000000001"),
        (0.01004, 0.05, "p = 0.01004"),
        (0.0334, 0.05, "p = 0.033"),
        (0.0334, 0.033, "p = 0.0334"),
        (0.0126, 0.0125, "p = 0.013"),
        (0.0125, 0.0125, "p = 0.0125"),
        (4e-6, 1e-5, "p < 1e-05"),
        (4e-5, 1e-5, "p = 4e-05"),
        (0.05, 1.0 - 0.95, "p = 0.05"),
    ],
)
def test_no_p_value_is_rounded_onto_a_level_or_past_it(p, alpha, text):
    assert p_text(p, alpha=alpha) == text


@given(st.floats(1e-4, 1.0), st.floats(1e-6, 0.5))
def test_a_p_value_reads_on_its_side_of_every_level(p, alpha):
    shown = float(p_text(p, alpha=alpha).removeprefix("p = "))
    for level in (*USUAL_ALPHAS, alpha):
        assert ((shown > level) - (shown < level)) == ((p > level) - (p < level))


@pytest.mark.parametrize(
    ("level", "text"),
    [
        (0.95, "95 %"),
        (1.0 - 0.07, "93 %"),
        (0.999, "99.9 %"),
        (0.9999999, "99.99999 %"),
        (1.0 - 1e-12, "99.9999999999 %"),
        (1.0 - 2.0 * 0.4999999999, "0.00000002 %"),
    ],
)
def test_a_level_keeps_the_digits_that_tell_it_from_all_and_nothing(level, text):
    assert level_text(level) == text


def test_intervals_name_their_level_and_unit():
    assert interval_text((1.0, 2.5), 0.9, "J") == "90 % CI 1 to 2.5 J"
    assert interval_text((1000000.3456, 1000001.1), 0.95) == "95 % CI 1000000.35 to 1000001.1"
    assert interval_text(Undefined("no scatter"), 0.95) == "95 % CI undefined"


def test_what_a_sentence_states_can_be_read_from_it_at_any_offset():
    """Four digits of means at 1e6 gave "mean 1000000 minus mean 1000001 is -0.4643", and an interval of no width."""
    a, b = np.array([0.3, 1.1, -0.4, 0.6, 0.2]) + 1e6, np.array([0.9, 0.5, 1.4, 1.2, 0.1]) + 1e6
    found = compare_two(a, b)
    means = [float(mean) for mean in re.findall(r"\(mean ([\d.]+),", found.sentence())]
    assert means[0] - means[1] == pytest.approx(found.difference, abs=0.01)
    told = describe(a).sentence()
    mean, low, high = map(float, re.search(r"mean ([\d.]+) .* CI ([\d.]+) to ([\d.]+),", told).groups())
    assert (mean, low, high) == pytest.approx((1000000.36, 999999.68, 1000001.04), abs=0.011)


def test_a_coefficient_and_its_interval_have_the_digits_of_the_interval():
    x = np.arange(6.0)
    text = fit_linear(2.0 + 3.0 * x + 1e-6 * np.array([1.0, -2.0, 0.5, 2.0, -1.5, 0.0]), {"x": x}).sentence()
    slope, low, high = map(float, re.search(r"x ([\d.]+) \(95 % CI ([\d.]+) to ([\d.]+),", text).groups())
    assert low < slope < high
    assert "R squared 1," not in text


def test_degrees_of_freedom_read_the_same_in_every_sentence():
    assert [df_text(df) for df in (64, 64.0, 20.93, 4.011, 3.9999999999999, 123456.7)] == [
        "64", "64", "20.9", "4.0", "4", "123457",
    ]  # fmt: skip
    a, b, c = [1.0, 2.0, 4.0, 3.5], [2.0, 2.5, 3.0], [5.0, 9.0, 5.5, 6.0, 5.1]
    texts = [
        compare_two(a, c, route="welch").sentence(),
        equivalence(a, c, low=-1.0, high=1.0).sentence(),
        welch_anova({"a": a, "b": b, "c": c}).sentence(),
        compare_all_pairs({"a": a, "b": b, "c": c}, variances="unequal").sentence(),
    ]
    for text in texts:
        assert re.search(r"[tFq]\((\d, )?\d+\.\d\)", text), text
        assert not re.search(r"[tFq]\((\d, )?\d+\.\d\d+\)", text), text
    assert "t(5)" in compare_two(a, b, route="student").sentence()


def test_a_sentence_gives_the_reason_of_an_interval_or_a_test_that_is_undefined():
    saved = percent_savings([3.0, -2.0, 5.0], [1.0, 2.0, 4.0]).sentence()
    assert "95 % CI undefined, because the control's mean is not distinguishable from 0 at this level" in saved
    pairs = compare_all_pairs({"a": [1.0, 2.0], "b": [3.0], "c": [3.0, 5.0]}, variances="unequal").sentence()
    assert "(no test, because group 'b' has a single value" in pairs
    assert "undefined" not in compare_all_pairs({"a": [1.0, 1.0], "b": [3.0, 3.0]}).sentence()
