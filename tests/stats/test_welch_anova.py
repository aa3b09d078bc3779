import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused
from stats.two_sample import compare_two
from stats.welch_anova import welch_anova

GROUPS = {"0": [42.1, 39.8, 44.0], "50": [36.9, 38.2, 35.1, 37.7], "100": [37.0, 39.5]}
SCATTERING = st.lists(st.integers(-99, 99), min_size=2, max_size=6).filter(lambda group: len(set(group)) > 1)


def test_agrees_with_welchs_formulas_in_forty_digits():
    with mpmath.workdps(40):
        groups = [[mpmath.mpf(x) for x in values] for values in GROUPS.values()]
        k, n = 3, [len(values) for values in groups]
        means = [sum(values) / len(values) for values in groups]
        weights = [
            len(values) * (len(values) - 1) / sum((x - mean) ** 2 for x in values)
            for values, mean in zip(groups, means, strict=True)
        ]
        grand = sum(w * mean for w, mean in zip(weights, means, strict=True)) / sum(weights)
        above = sum(w * (mean - grand) ** 2 for w, mean in zip(weights, means, strict=True)) / (k - 1)
        doubt = sum((1 - w / sum(weights)) ** 2 / (size - 1) for w, size in zip(weights, n, strict=True))
        f, df = above / (1 + 2 * (k - 2) * doubt / (k * k - 1)), (k * k - 1) / (3 * doubt)
        p = mpmath.betainc(df / 2, 1, 0, df / (df + 2 * f), regularized=True)
    found = welch_anova(GROUPS)
    assert (found.f, found.df_within, found.p) == pytest.approx((float(f), float(df), float(p)), rel=1e-14)
    assert found.log10_p == pytest.approx(float(mpmath.log10(p)), rel=1e-14)
    assert found.df_between == 2
    assert found.sentence("gain").startswith("Welch ANOVA over gain: F(2, ")


def test_two_groups_are_welchs_t_squared():
    a, b = GROUPS["0"], GROUPS["50"]
    found, welch = welch_anova({"a": a, "b": b}), compare_two(a, b, route="welch")
    assert (found.f, found.df_within, found.p) == pytest.approx((welch.t**2, welch.df, welch.p), rel=1e-13)


@pytest.mark.parametrize("constant", ["0", "50", "100"])
def test_one_group_without_scatter_has_a_limit(constant):
    """W13: scipy and statsmodels give nan, pingouin raises ValueError."""
    groups = {**GROUPS, constant: [38.0, 38.0, 38.0]}
    found = welch_anova(groups)
    near = welch_anova({**groups, constant: [38.0 - 1e-7, 38.0, 38.0 + 1e-7]})
    assert (found.f, found.df_within, found.p) == pytest.approx((near.f, near.df_within, near.p), rel=1e-8)
    assert found.constant_group == constant
    assert f"limit for '{constant}'" in found.sentence()


@pytest.mark.parametrize(
    ("groups", "reason"),
    [
        ({"a": [1.0, 1.0], "b": [1.0, 1.0], "c": [1.0, 2.0]}, "with two such F has no limit"),
        ({"a": [0.1] * 3, "b": [0.1] * 7, "c": [0.1] * 5}, "no group has any scatter"),  # W3: Welch gives p = 0.016
        ({"a": [1.0], "b": [1.0, 2.0]}, "'a' has a single value"),
        ({"a": [], "b": [1.0, 2.0], "c": [1.0, 3.0]}, "'a' is empty"),  # W12: others report F of the rest
        ({"b": [1.0, 2.0]}, "at least 2 groups"),
    ],
)
def test_what_has_no_test_says_why(groups, reason):
    found = welch_anova(groups)
    assert reason in found.f.reason
    assert found.f == found.df_within == found.p == found.log10_p
    assert reason in found.sentence()


@pytest.mark.parametrize("bad", [float("nan"), float("inf")])
def test_what_is_no_number_is_refused_by_group(bad):
    """W11: pingouin's welch_anova gives F = 2.11, p = 0.155 for a group with inf."""
    with pytest.raises(InputRefused, match="group 'b'"):
        welch_anova({"a": [1.0, 2.0], "b": [1.0, bad]})


def test_missing_values_are_counted_when_dropped():
    found = welch_anova({"a": [1.0, 2.0, float("nan")], "b": [1.0, 3.0]}, missing="drop")
    assert (found.missing, found.group_ns) == (1, (2, 2))
    assert "1 missing" in found.sentence()


@given(st.lists(SCATTERING, min_size=2, max_size=4), st.integers(-(2**40), 2**40), st.integers(-500, 500))
def test_shift_scale_order_and_labels_leave_p_as_it_is(groups, shift, exponent):
    one = welch_anova({str(k): group for k, group in enumerate(groups)})
    other = welch_anova(
        {f"other {k}": np.ldexp(np.array(g[::-1]) + float(shift), exponent) for k, g in enumerate(reversed(groups))}
    )
    assert other.p == pytest.approx(one.p, rel=1e-13)
    assert other.log10_p == pytest.approx(one.log10_p, rel=1e-13, abs=1e-14)


def test_rows_for_pandas_and_json():
    assert welch_anova(GROUPS).to_frame()["f"].item() == welch_anova(GROUPS).f
    assert '"f": null' in welch_anova({"a": [1.0]}).to_json()
