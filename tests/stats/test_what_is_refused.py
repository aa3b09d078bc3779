"""What no function of several inputs can take is refused with a sentence, and what is no error is taken."""

from decimal import Decimal
from math import inf, nan

import numpy as np
import pandas as pd
import pytest

import stats
from data_schema.errors import InputRefused
from tests.helpers.wording import says

Y = [41.2, 39.9, 44.1, 38.2]
RAGGED = [[1, 2], [3]]


@pytest.mark.parametrize(
    "call",
    [
        lambda: stats.permutation_test(RAGGED, Y),
        lambda: stats.bootstrap_difference(RAGGED, Y),
        lambda: stats.fit_linear(RAGGED, {"x": [1.0, 2.0]}),
        lambda: stats.fit_polynomial([1.0, 2.0], RAGGED, 1),
        lambda: stats.fit_passive_drain(RAGGED, [1.0, 2.0]),
        lambda: stats.fit_gain_line(RAGGED, [1.0, 2.0]),
        lambda: stats.rmse_over_iqr(RAGGED, [1.0, 2.0]),
        lambda: stats.blocked_by_day(RAGGED, ["a", "b"], ["mon", "mon"]),
    ],
)
def test_lists_of_unequal_lengths(call):
    with pytest.raises(InputRefused, match="unequal lengths"):
        call()


@pytest.mark.parametrize("missing", ["refuse", "drop"])
def test_infinite_values_are_not_to_be_dropped(missing):
    columns = {"t": [1.0, 2.0, 3.0, 5.0]}
    for call in (
        lambda: stats.compare_two([1.0, inf], Y, missing=missing),
        lambda: stats.permutation_test([1.0, inf], Y, missing=missing),
        lambda: stats.fit_linear([1.0, 2.0, inf, 3.0], columns, missing=missing),
    ):
        with pytest.raises(InputRefused, match="infinite") as refusal:
            call()
        assert "drop" not in str(refusal.value)
    with pytest.raises(InputRefused, match="never dropped"):
        stats.compare_two([1.0, nan, inf], Y)


@pytest.mark.parametrize(
    ("value", "sentence"),
    [(Decimal("1e400"), "beyond 1.8e308"), (10**400, "beyond 1.8e308"), (Decimal("1e-400"), "below 5e-324")],
)
def test_numbers_without_a_double(value, sentence):
    with pytest.raises(InputRefused, match=sentence):
        stats.compare_two([value, 2 * value, 3 * value], Y)


@pytest.mark.parametrize("p", [None, "a", "0.5", True, 10**400, 0.5 + 0j, np.complex128(0.5)])
def test_no_p_values(p):
    with pytest.raises(InputRefused, match="p-value of 'one'"):
        stats.holm({"one": p, "two": 0.5}, "family")


@pytest.mark.parametrize(
    "call",
    [
        lambda: stats.permutation_test(Y, Y, seed="x"),
        lambda: stats.bootstrap_difference(Y, Y, seed=1.5),
        lambda: stats.autocorrelation(Y, lag=1.5),
        lambda: stats.autocorrelation(Y, lag=-1),
        lambda: stats.autocorrelation([1.0, float("nan"), 3.0]),
        lambda: stats.autocorrelation(RAGGED),
        lambda: stats.additive_residuals(RAGGED, ["a", "b"], ["mon", "tue"]),
        lambda: stats.additive_residuals([1.0, float("nan")], ["a"], ["mon", "tue"], missing="drop"),
        lambda: stats.SharedError(0.1, 5),
        lambda: stats.one_way_anova([1.0, 2.0, 3.0]),
        lambda: stats.levene("abc"),
        lambda: stats.bartlett(None),
        lambda: stats.describe_shared(Y, 0.1),
        lambda: stats.sample_size(5),
        *(
            lambda test=test, names=names: test(Y, Y, names=names)
            for test in (stats.compare_two, stats.f_test, stats.percent_savings)
            for names in (("CE",), ("a", "b", "c"), "CE", (1, 2))
        ),
        lambda: stats.equivalence(Y, Y, low=-1, high=1, names=("CE",)),
    ],
)
def test_other_arguments_that_are_none(call):
    with pytest.raises(InputRefused):
        call()


@pytest.mark.parametrize(
    "function",
    [
        stats.one_way_anova,
        stats.welch_anova,
        stats.bartlett,
        stats.levene,
        stats.brown_forsythe,
        stats.compare_all_pairs,
        stats.residuals_of_groups,
    ],
)
def test_groups_without_names_are_counted(function):
    groups = [Y, [1.0, 2.0, 3.5], [9.0, 8.0, 2.0]]
    by_name = function(dict(zip("123", groups, strict=True)))
    assert repr(function(groups)) == repr(by_name)
    even = np.array([[1.0, 2.0, 4.0], [3.0, 5.0, 9.0]])
    named = repr(function({"1": even[0], "2": even[1]}))
    assert repr(function(even)) == repr(function(pd.DataFrame({"1": even[0], "2": even[1]}))) == named


def test_treatments_without_names_are_counted():
    assert [pair.treatment for pair in stats.dunnett(Y, [[1.0, 2.0], [3.0, 5.0]]).comparisons] == ["1", "2"]


def test_treated_runs_that_are_all_0_have_a_reason_that_is_true():
    says(stats.percent_savings(Y, [0.0] * 5).percent_ci.reason, "all treated runs", "0")
    says(stats.equivalence([0.0] * 5, Y, low=-3, high=3, bounds="percent").estimate_ci.reason, "0 does")
    says(stats.percent_savings([2.0] * 3, [1.0] * 3).percent_ci.reason, "neither group has")


def test_one_day_is_no_days():
    days = ["mon"] * 4
    says(stats.permutation_test(Y, Y, days, days).sentence(), "within", "1 day")
    assert "within 1 day," in stats.bootstrap_difference(Y, Y, days, days, resamples=200).sentence()
