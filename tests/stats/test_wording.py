"""Numbers as they are shown: the digits of their error, and no p-value rounded onto a level or past it."""

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import stats
from data_schema.reasons import Reason
from data_schema.rounding import (
    USUAL_ALPHAS,
    df_text,
    given_text,
    interval_text,
    level_text,
    number_text,
    p_text,
    statistic_text,
)
from data_schema.vocabulary import Undefined
from tests.helpers.wording import says


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (42.64, None, "42.6"),
        (-0.0, None, "0"),
        (123456.7, None, "123457"),
        (0.00012345, None, "0.000123"),
        (26.3148, 0.42, "26.31"),
        (1000000.3456, 0.21, "1000000.35"),
        (3.14159, 5.0, "3.1"),
        (0.1, 1e-30, "0.1"),
        (1.25e-30, 1.2e-32, "1.25e-30"),
        (1e19, 3.25, "1e+19"),
        (0.0, 1e-9, "0.0000000000"),
        (2.5, math.inf, "2.5"),
        (0.62, 0.0, "0.62"),
    ],
)
def test_a_number_has_the_decimals_of_its_error_and_no_more_than_a_double_holds(value, error, text):
    assert (number_text(value) if error is None else number_text(value, error=error)) == text


def test_statistics_have_two_decimals_and_what_is_stated_its_own():
    assert [given_text(value) for value in (1.1 * 3, 835.36, 1e-5, 1250.0)] == ["3.3", "835.36", "1e-05", "1250"]
    assert statistic_text("t", -3.4149, (18.23,)) == "t(18.2) = -3.41"
    says(statistic_text("F", 1.317, (4, 45.0)), "F(4, 45)", "1.32")
    assert statistic_text("z", 2.1, ()) == "z = 2.10"
    assert statistic_text("t", Undefined(Reason.AS_SAID, said="no scatter"), (3,)) == "t undefined"


@pytest.mark.parametrize(
    ("p", "alpha", "text"),
    [
        (0.0412, 0.05, "p = .041"),
        (1e-7, 0.05, "p < .001"),
        (1.0, 0.05, "p > .999"),
        (Undefined(Reason.AS_SAID, said="no scatter"), 0.05, "p undefined"),
        (0.05, 0.05, "p = .050"),
        (0.0503, 0.05, "p = .0503"),
        (math.nextafter(0.05, 1.0), 0.05, "p = .05000000000000001"),
        (0.0334, 0.033, "p = .0334"),
        (4e-6, 1e-5, "p < .00001"),
        (0.05, 1.0 - 0.95, "p = .050"),
    ],
)
def test_no_p_value_is_rounded_onto_a_level_or_past_it(p, alpha, text):
    assert p_text(p, alpha) == text


@given(st.floats(0.001, 0.999), st.floats(1e-6, 0.5))
def test_a_p_value_reads_on_its_side_of_every_level(p, alpha):
    shown = float(p_text(p, alpha, name=False))
    for level in (*USUAL_ALPHAS, alpha):
        assert ((shown > level) - (shown < level)) == ((p > level) - (p < level))


@pytest.mark.parametrize(
    ("level", "text"),
    [(0.95, "95 %"), (1.0 - 0.07, "93 %"), (0.999, "99.9 %"), (1.0 - 2.0 * 0.4999999999, "0.00000002 %")],
)
def test_a_level_keeps_the_digits_that_tell_it_from_all_and_nothing(level, text):
    assert level_text(level) == text


def test_intervals_name_their_level_and_unit():
    says(interval_text((1.0, 2.5), 0.9, "J"), "90 %", "1.00", "2.50 J")
    says(interval_text((1000000.3456, 1000001.1), 0.95), "95 %", "1000000.35", "1000001.10")
    says(interval_text(Undefined(Reason.AS_SAID, said="no scatter"), 0.95), "95 %", "CI undefined")
    # Beside p = .046, "-4.7 to 0.0" hides the verdict
    assert interval_text((-4.67, -0.04), 0.95).endswith("-4.7 to -0.04")
    assert interval_text((-4.67, 0.0), 0.95).endswith("-4.7 to 0.0")


def test_what_a_sentence_states_can_be_read_from_it_at_any_offset():
    """Four digits of means at 1e6 gave "mean 1000000 minus mean 1000001 is -0.4643", and an interval of no width."""
    a, b = np.array([0.3, 1.1, -0.4, 0.6, 0.2]) + 1e6, np.array([0.9, 0.5, 1.4, 1.2, 0.1]) + 1e6
    found = stats.compare_two(a, b)
    means = [float(mean) for mean in re.findall(r"\(mean ([\d.]+),", found.sentence())]
    assert means[0] - means[1] == pytest.approx(found.difference, abs=0.01)


def test_degrees_of_freedom_read_the_same_in_every_sentence():
    numbers = {64: "64", 30.0: "30", 20.93: "20.9", 4.011: "4", 3.9999999999999: "4", 123456.7: "123456.7"}
    assert [df_text(df) for df in numbers] == list(numbers.values())
    a, b, c = [1.0, 2.0, 4.0, 3.6], [2.0, 2.5, 3.0], [5.0, 9.0, 5.5, 6.0, 5.1]
    groups = {"a": a, "b": b, "c": c}
    for found in (
        stats.compare_two(a, c),
        stats.welch_anova(groups),
        stats.compare_all_pairs(groups, variances="unequal"),
    ):
        text = found.sentence()
        assert re.search(r"[tFq]\((\d, )?\d+\.\d\)", text), text
        assert not re.search(r"[tFq]\((\d, )?\d+\.\d\d+\)", text), text
    assert "t(5)" in stats.compare_two(a, b, route="student").sentence()


def test_a_sentence_gives_the_reason_of_an_interval_or_a_test_that_is_undefined():
    pairs = stats.compare_all_pairs({"a": [1.0, 2.0], "b": [3.0], "c": [3.0, 5.0]}, variances="unequal").sentence()
    says(pairs, "'b'", "a single value")
    assert "undefined" not in stats.compare_all_pairs({"a": [1.0, 1.0], "b": [3.0, 3.0]}).sentence()
