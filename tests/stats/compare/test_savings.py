import math

import numpy as np
import pytest
import scipy.optimize
import scipy.stats
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.compare.savings import Savings, percent_savings
from stats.compare.shared_error import ENOUGH_DEGREES, SharedError, joints
from stats.compare.two_sample import compare_two
from tests.helpers.wording import says

CONTROL = [42.0, 44.5, 40.1, 43.3, 41.6]
TREATED = [36.0, 37.9, 35.2, 38.8, 36.1, 35.5]
JOULES = st.lists(st.floats(20.0, 60.0), min_size=2, max_size=10)


def with_shared(control, treated, se, df=math.inf, **others) -> Savings:
    """Savings of groups that carry one error alike."""
    error = SharedError({("drain", "level"): se}, {"drain": df})
    return percent_savings(control, treated, shared_in_control=error, shared_in_treated=error, **others)


def test_savings_are_a_ratio_of_means():
    found = percent_savings([40.0, 60.0], [40.0, 45.0])
    assert found.percent == pytest.approx(15.0)
    assert (found.control_mean, found.treated_mean, found.n_control, found.n_treated) == (50.0, 42.5, 2, 2)


@pytest.mark.parametrize("shared_df", [1.0, 4.0])
def test_fiellers_ends_are_where_the_test_just_rejects(shared_df):
    """At each end (T - rho C)^2 is the quantile squared times its variance: the definition of the interval.

    Of those with the shared error and without it the interval holds both.
    """
    found = with_shared(CONTROL, TREATED, 0.7, shared_df)
    c, t = np.mean(CONTROL), np.mean(TREATED)
    var_c, var_t = np.var(CONTROL, ddof=1) / 5, np.var(TREATED, ddof=1) / 6
    left = SharedError({("drain", "level"): 0.7 * (1.0 - t / c)}, {"drain": shared_df})
    ways = joints([(var_t, 5.0), ((t / c) ** 2 * var_c, 4.0)], left, 0.95)

    def squared_half_width(rho: float) -> float:
        return max(w.quantile**2 * (var_t + rho**2 * var_c + w.more * 0.7**2 * (1.0 - rho) ** 2) for w in ways)

    for end in found.percent_ci:
        rho = 1.0 - end / 100.0
        assert (t - rho * c) ** 2 == pytest.approx(squared_half_width(rho), rel=1e-9)
    half = found.delta_ci[1] - found.percent
    assert half == pytest.approx(100.0 * math.sqrt(squared_half_width(t / c)) / c)


def level_and_slope(level: float, slope: float, df: float) -> SharedError:
    return SharedError({("drain", "level"): level, ("drain", "slope"): slope}, {"drain": df})


@pytest.mark.parametrize(
    ("in_control", "in_treated"),
    [((2.0, 1.0), (1.0, -1.0)), ((0.5, -1.5), (2.5, 0.4)), ((-1.0, 2.0), (1.5, 0.0)), ((0.0, 0.0), (1.0, 2.0))],
)
@pytest.mark.parametrize("shared_df", [2.0, 4.0, 50.0])
def test_fiellers_ends_by_hand_where_each_group_has_errors_of_its_own(in_control, in_treated, shared_df):
    """The roots of the definition, (T - rho C)^2 = t^2 (Var(T) + rho^2 Var(C) + m sum of (t_k - rho c_k)^2).

    t and m are written out here: each error's own quantile below four degrees of freedom, else one quantile after
    Welch and Satterthwaite, and the interval of the scatter alone beside it.
    """
    found = percent_savings(
        CONTROL,
        TREATED,
        shared_in_control=level_and_slope(*in_control, shared_df),
        shared_in_treated=level_and_slope(*in_treated, shared_df),
    )
    c, t = np.mean(CONTROL), np.mean(TREATED)
    var_c, var_t = np.var(CONTROL, ddof=1) / 5, np.var(TREATED, ddof=1) / 6
    at, rho_found = scipy.stats.t.ppf, t / c

    def shared(rho: float) -> float:
        return sum((t_k - rho * c_k) ** 2 for c_k, t_k in zip(in_control, in_treated, strict=True))

    parts = [(var_t, 5.0), (rho_found**2 * var_c, 4.0)]
    scatter_df = sum(part for part, _ in parts) ** 2 / sum(part**2 / df for part, df in parts)
    parts.append((shared(rho_found), shared_df))
    joint_df = sum(part for part, _ in parts) ** 2 / sum(part**2 / df for part, df in parts)
    of_scatter, own, joint = (at(0.975, df) for df in (scatter_df, shared_df, joint_df))
    ways = [(of_scatter, own)] if shared_df < 4.0 else [(of_scatter, 0.0), (joint, joint)]

    def surplus(rho: float, way: tuple[float, float]) -> float:
        return (t - rho * c) ** 2 - way[0] ** 2 * (var_t + rho**2 * var_c) - way[1] ** 2 * shared(rho)

    low = min(1.0 - scipy.optimize.brentq(surplus, rho_found, rho_found + 0.7, (way,), xtol=1e-14) for way in ways)
    high = max(1.0 - scipy.optimize.brentq(surplus, rho_found - 0.7, rho_found, (way,), xtol=1e-14) for way in ways)
    assert found.percent_ci == pytest.approx((100.0 * low, 100.0 * high), abs=1e-9)


def test_fiellers_ends_do_not_jump_as_the_shared_error_grows():
    """Where the wider of two symmetrical intervals was the other, both asymmetrical ends went to that one."""
    errors = np.linspace(0.0, 12.0, 400)
    ends = np.array([with_shared([42.0, 40.0, 41.0], [36.0, 35.0, 37.5], se, 5.0).percent_ci for se in errors])
    assert (np.diff(ends[:, 0]) <= 1e-12).all()
    assert (np.diff(ends[:, 1]) >= -1e-12).all()
    assert np.abs(np.diff(ends, axis=0)).max() < 0.3


def test_the_shared_error_has_the_sensitivity_of_the_derivation():
    """dS/de = -(C - T) / C^2, checked against shifting both groups by e."""
    c, t, e = np.mean(CONTROL), np.mean(TREATED), 1e-4
    shifted = percent_savings(np.array(CONTROL) + e, np.array(TREATED) + e).percent
    slope = (shifted - percent_savings(CONTROL, TREATED).percent) / e
    assert slope == pytest.approx(-100.0 * (c - t) / c**2, rel=1e-4)
    assert with_shared(CONTROL, TREATED, 0.7).shared_se_percent == pytest.approx(0.7 * abs(slope), rel=1e-4)


def test_a_shared_error_without_savings_changes_nothing():
    alone, shared = percent_savings(CONTROL, CONTROL), with_shared(CONTROL, CONTROL, 5.0)
    assert shared.shared_se_percent == 0.0
    assert shared.delta_ci == pytest.approx(alone.delta_ci)


@given(JOULES, JOULES, st.floats(0.1, 10.0), st.floats(0.0, 2.0))
def test_a_common_factor_cancels(control, treated, factor, shared_se):
    one = with_shared(control, treated, shared_se, 4.0)
    other = with_shared(
        np.array(control) * factor, np.array(treated) * factor, shared_se * factor, 4.0, scale_relative_se=0.02
    )
    assert other.percent == pytest.approx(one.percent, abs=1e-9)
    assert other.scale_relative_se == 0.02
    if isinstance(one.percent_ci, tuple) and isinstance(other.percent_ci, tuple):
        assert other.percent_ci == pytest.approx(one.percent_ci, rel=1e-6, abs=1e-6)


@given(JOULES, JOULES)
def test_a_shared_error_is_kept_apart_from_the_scatter(control, treated):
    one, other = percent_savings(control, treated), with_shared(control, treated, 0.5)
    assert other.se_percent == one.se_percent
    assert other.shared_se_percent == pytest.approx(0.5 * abs(one.percent) / one.control_mean, rel=1e-9, abs=1e-12)


def test_a_shared_error_may_be_that_of_one_group():
    error = SharedError({("drain", "level"): 0.5}, {"drain": 4.0})
    found = percent_savings(CONTROL, TREATED, shared_in_treated=error)
    assert found.shared_se_percent == pytest.approx(100.0 * 0.5 / np.mean(CONTROL))


def test_what_does_not_exist_is_undefined_field_by_field():
    single = percent_savings([40.0], [30.0, 31.0])
    assert single.percent == pytest.approx(23.75)
    assert isinstance(single.percent_ci, Undefined)
    constant = percent_savings([40.0, 40.0], [30.0, 30.0])
    assert (constant.percent, constant.se_percent) == (25.0, 0.0)
    assert isinstance(constant.percent_ci, Undefined)
    assert isinstance(percent_savings([], [1.0]).percent, Undefined)
    says(percent_savings([1.0], []).sentence(), "treated is empty")
    empty = percent_savings([], [])
    says(empty.sentence(), "control is empty")
    says(empty.treated_mean.reason, "treated is empty")
    assert "not positive" in percent_savings([-1.0, 1.0], [1.0, 2.0]).sentence()
    noisy = percent_savings([1.0, 100.0, -70.0], [30.0, 31.0, 29.0])
    assert isinstance(noisy.percent_ci, Undefined)
    assert isinstance(noisy.delta_ci, tuple)


def test_wrong_input_is_refused():
    with pytest.raises(InputRefused, match="group 'treated'"):
        percent_savings(CONTROL, [1.0, float("nan")])
    with pytest.raises(InputRefused, match="scale_relative_se"):
        percent_savings(CONTROL, TREATED, scale_relative_se=-1.0)


def test_the_sentence_says_more_or_less():
    text = percent_savings(CONTROL, TREATED).sentence("CE", "AD")
    says(text, "mean of AD", "13.5 %", "95 %", "n = 6", "against")
    says(percent_savings(TREATED, CONTROL).sentence(), "control (savings -")
    confounded = percent_savings(CONTROL, TREATED).sentence("CE", "AD", "a difference between days")
    says(confounded, "difference between days", "13.5 %", "n = 6", "against")


@pytest.mark.parametrize(
    ("control", "treated", "said"),
    [
        (
            [1.0, 2.0, 3.0],
            [1.0, 2.1, 3.0],
            "No difference between AD and CE is shown: the estimated savings are -2 %",
        ),
        ([1.0, 2.0, 3.0], [3.0, 2.0, 1.0], "The means of AD and CE are equal (savings 0 %, 95 % CI -"),
        ([1.0, 1.0], [1.0, 1.0], "The means of AD and CE are equal (savings 0 %, 95 % CI undefined, because neither"),
        (
            [100.0],
            [6000.0],
            "The savings of AD against CE cannot be bounded: the best estimate is -5900 % (95 % CI undef",
        ),
        ([3.0, -2.0, 5.0], [1.0, 2.0, 400.0], "The savings of AD against CE cannot be bounded: the best estimate is"),
        ([1e6, 1.1e6, 9e5], [1.0, 2.0, 3.0], "The mean of AD is 99.99980 % below that of CE (savings 99.99980 %"),
    ],
)
def test_the_sentence_claims_no_more_than_the_interval_bears_out(control, treated, said):
    assert percent_savings(control, treated).sentence("CE", "AD").startswith(said)


@pytest.mark.soak
@pytest.mark.parametrize("shared_df", [None, 1.0, 2.0, 4.0, 1e9])
def test_the_interval_covers_the_savings_as_often_as_it_says(shared_df):
    """n = 5, coefficient of variation 0.2, true savings 30 %; without a common error, or one known from few runs."""
    rng = np.random.default_rng(29)
    n, shared_se = 2500, 0.0 if shared_df is None else 6.0
    df = shared_df or 1.0
    shared = rng.normal(0.0, shared_se, (n, 1))
    estimated_se = shared_se * np.sqrt(rng.chisquare(df, n) / df)
    control, treated = rng.normal(50.0, 10.0, (n, 5)) + shared, rng.normal(35.0, 7.0, (n, 5)) + shared
    found = [with_shared(c, t, se, df).percent_ci for c, t, se in zip(control, treated, estimated_se, strict=True)]
    bounded = [ends for ends in found if not isinstance(ends, Undefined)]
    covered = sum(low <= 30.0 <= high for low, high in bounded) + len(found) - len(bounded)  # unbounded ones cover
    few = shared_df is not None and shared_df < ENOUGH_DEGREES  # then intervals are wide rather than too narrow
    assert 0.935 < covered / n < (0.995 if few else 0.968)


def test_the_intervals_beside_fiellers():
    """The delta interval lies about the estimate, the one of the logarithm about the logarithm of the ratio."""
    found = percent_savings(CONTROL, TREATED)
    low, high = found.log_ci
    ratio = 1.0 - found.percent / 100.0
    assert math.sqrt((1.0 - low / 100.0) * (1.0 - high / 100.0)) == pytest.approx(ratio, rel=1e-12)
    assert sum(found.delta_ci) / 2.0 == pytest.approx(found.percent, rel=1e-12)
    assert found.log_ci == pytest.approx(found.percent_ci, abs=0.1)
    wide = percent_savings([1.0, 100.0, -70.0], [30.0, 31.0, 29.0])
    assert wide.log_ci[1] < 100.0
    assert "no logarithm" in percent_savings(CONTROL, [-1.0, -2.0]).log_ci.reason
    assert percent_savings(CONTROL, TREATED).to_frame()["log_ci_low"].item() == low


def test_small_savings_keep_their_digits():
    """1 - T / C would leave three digits here."""
    found = percent_savings([1e9, 1e9 + 2.0], [1e9, 1e9 + 2.0 - 2.0**-10])
    assert found.percent == pytest.approx(100.0 * 2.0**-11 / (1e9 + 1.0), rel=1e-14)


@pytest.mark.parametrize(
    ("control", "treated", "shown"),
    [
        ([38.3, 46.5, 48.9, 37.5, 50.2, 47.0], [28.8, 38.1, 26.6], False),
        ([49.6, 48.3, 38.0], [28.5, 31.2, 31.6, 37.9, 39.2], True),
    ],
)
def test_savings_are_shown_by_their_own_interval_not_by_the_differences_p(control, treated, shown):
    """Welch's degrees of freedom are taken at equal means, Fieller's at the ratio found: near alpha they disagree."""
    found, other = percent_savings(control, treated), compare_two(control, treated, route="welch")
    assert (other.p < 0.05) is not shown
    assert found.shown is shown
    assert (found.percent_ci[0] > 0.0) is shown
    assert ("is shown" in found.sentence()) is not shown
    assert found.to_dict()["shown"] is shown
