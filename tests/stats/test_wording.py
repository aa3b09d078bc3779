import re

import pytest

from data_schema.vocabulary import Undefined
from stats.equivalence import equivalence
from stats.savings import percent_savings
from stats.tukey import compare_all_pairs
from stats.two_sample import compare_two
from stats.welch_anova import welch_anova
from stats.wording import df_text, interval_text, number_text, p_text


@pytest.mark.parametrize(
    ("value", "text"),
    [(42.6, "42.6"), (0.0, "0"), (-0.0, "0"), (123456.7, "123457"), (0.00012345, "0.0001234"), (-3.14159, "-3.142")],
)
def test_numbers_are_rounded_for_display_only(value, text):
    assert number_text(value) == text


def test_p_values():
    assert p_text(0.0412) == "p = 0.041"
    assert p_text(1e-7) == "p < 0.0001"
    assert p_text(Undefined("no scatter")) == "p undefined"


def test_intervals_name_their_level_and_unit():
    assert interval_text((1.0, 2.5), 0.9, "J") == "90 % CI 1 to 2.5 J"
    assert interval_text(Undefined("no scatter"), 0.95) == "95 % CI undefined"


def test_degrees_of_freedom_read_the_same_in_every_sentence():
    assert [df_text(df) for df in (64, 64.0, 20.93, 4.011, 3.9999999999999, 123456.7)] == [
        "64", "64", "20.9", "4.0", "4", "123457",
    ]  # fmt: skip
    a, b, c = [1.0, 2.0, 4.0, 3.5], [2.0, 2.5, 3.0], [5.0, 9.0, 5.5, 6.0, 5.1]
    texts = [
        compare_two(a, c, route="welch").sentence(),
        equivalence(a, c, -1.0, 1.0).sentence(),
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
