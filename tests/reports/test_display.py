import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from reports.display import (
    as_shown,
    common_places,
    decimal_text,
    decimals_for,
    degrees_text,
    general_text,
    interval_text,
    number_text,
    p_text,
    significance_text,
    value_text,
)
from reports.numbers import Number, SignificanceTest
from tests.helpers.wording import says
from tests.reports.made import plain


def test_a_number_is_written_with_its_error_interval_and_n():
    number = Number(16.3149, "J", se=0.4187, shared_se=0.2149, ci_low=15.364, ci_high=17.261, n=10)
    says(plain(number_text(number)), "16.31", "0.42 J", "shared by all", "0.21 J", "95 %", "15.36")


def test_apex_heights_are_shown_in_millimetres_and_stored_in_metres():
    number = Number(0.43812, "m", se=0.00042, ci_low=0.4372, ci_high=0.439)
    says(plain(number_text(number)), "438.12", "0.42 mm", "95 %", "437.20", "439.00 mm")
    assert as_shown(number).value == pytest.approx(438.12)
    assert number.value == 0.43812


def test_a_test_in_words():
    test = SignificanceTest("Welch t", -3.4149, (18.23,), 0.0031)
    says(plain(significance_text(test)), "Welch", "t(18.2)", "−3.41", "p = .003")
    anova = SignificanceTest("one-way ANOVA", 1.317, (4.0, 45.0), 0.277)
    says(plain(significance_text(anova)), "one-way ANOVA", "F(4, 45)", "1.32", "p = .277")
    says(plain(significance_text(anova, name=False)), "F(4, 45)", "1.32", "p = .277")
    normal = SignificanceTest("Welch t", 2.1, (Undefined(Reason.NORMAL),), 0.036)
    says(plain(significance_text(normal)), "t(undefined)", "2.10", "p = .036")
    assert plain(degrees_text((4.0, 45.0))) == "4, 45"


def test_undefined_gives_its_reason_everywhere():
    nothing = Undefined(Reason.GROUPS_CONSTANT)
    says(number_text(Number(nothing, "J")), "groups are constant")
    says(plain(p_text(nothing)), "groups are constant")
    says(interval_text(Number(1.0, "%", ci_low=nothing, ci_high=nothing)), "groups are constant")
    says(plain(significance_text(SignificanceTest("Welch t", nothing, (nothing,), nothing))), "Welch t undefined")
    assert as_shown(Number(nothing, "m")).value == nothing
    assert value_text(None) == "–"


def test_no_negative_zero():
    assert decimal_text(-0.001, 2) == "0.00"
    assert decimal_text(-1.0, 1) == "−1.0"
    assert decimal_text(-math.inf, 1) == "−∞"


def test_a_column_has_one_number_of_decimals():
    assert common_places([Number(1.0, "J", se=se) for se in (0.31, 0.42, 0.0051)] + [None]) == 2
    assert common_places([]) == 2


@pytest.mark.parametrize(
    ("value", "text"),
    [(835.36, "835"), (185.67, "186"), (400.0, "400"), (0.038, "0.038"), (0.0, "0"), (1.5e-9, "1.5\u00a0×\u00a010⁻⁹")],
)
def test_general_text(value, text):
    assert general_text(value) == text


@given(st.floats(-1e6, 1e6), st.floats(1e-6, 1e4))
def test_what_is_shown_is_within_half_a_digit_of_the_value(value, se):
    text = plain(number_text(Number(value, "J", se=se))).split(" ")[0].replace("−", "-")
    assert abs(float(text) - value) <= 0.5 * 10.0 ** -decimals_for(se) * (1 + 1e-9) + 1e-9
