import pytest

from data_schema.vocabulary import Undefined
from stats.wording import interval_text, number_text, p_text


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
