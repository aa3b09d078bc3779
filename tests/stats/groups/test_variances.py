import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
import scipy.stats

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.groups.variances import bartlett, brown_forsythe, f_test, levene
from tests.helpers.wording import says

rng = np.random.default_rng(4)
GROUPS = {"p": rng.normal(0, 1, 7), "q": rng.normal(3, 2, 9), "r": rng.normal(1, 1.5, 4), "s": rng.normal(0, 1, 12)}
TESTS = {"Bartlett": bartlett, "Levene": levene, "Brown-Forsythe": brown_forsythe}


def test_four_groups_as_scipy_has_them():
    samples = list(GROUPS.values())
    for found, right in (
        (bartlett(GROUPS), scipy.stats.bartlett(*samples)),
        (levene(GROUPS), scipy.stats.levene(*samples, center="mean")),
        (brown_forsythe(GROUPS), scipy.stats.levene(*samples, center="median")),
    ):
        assert found.statistic == pytest.approx(right.statistic, rel=1e-12)
        assert found.p == pytest.approx(right.pvalue, rel=1e-12)
        assert found.log10_p == pytest.approx(math.log10(right.pvalue), rel=1e-12)
        assert found.group_ns == (7, 9, 4, 12)
    assert (levene(GROUPS).df, bartlett(GROUPS).df) == ((3, 28), (3,))


def exact_spread_test(groups, middle):
    spreads = [[abs(Fraction(x) - middle([Fraction(y) for y in group])) for x in group] for group in groups]
    n = sum(map(len, spreads))
    means = [sum(group) / len(group) for group in spreads]
    grand = sum(map(sum, spreads)) / n
    between = sum(len(group) * (mean - grand) ** 2 for group, mean in zip(spreads, means, strict=True))
    within = sum((x - mean) ** 2 for group, mean in zip(spreads, means, strict=True) for x in group)
    return (between / (len(groups) - 1)) / (within / (n - len(groups)))


def mean(values):
    return sum(values) / len(values)


def median(values):
    values, n = sorted(values), len(values)
    return (values[(n - 1) // 2] + values[n // 2]) / 2


@pytest.mark.parametrize("offset", [0.0, 1e15])
def test_offsets_cost_no_digit(offset):
    """scipy's levene has 10.7 digits at 1e6, 4.7 at 1e12 and 2 at 1e15."""
    groups = {name: values + offset for name, values in GROUPS.items()}
    lists = [values.tolist() for values in groups.values()]
    assert brown_forsythe(groups).statistic == pytest.approx(float(exact_spread_test(lists, median)), rel=1e-15)
    assert levene(groups).statistic == pytest.approx(float(exact_spread_test(lists, mean)), rel=1e-15)


def test_many_values_at_an_offset():
    values = np.random.default_rng(9).normal(0.0, 1.0, (2, 60)) + 1e12
    groups, lists = {"a": values[0], "b": 2.0 * values[1]}, [values[0].tolist(), (2.0 * values[1]).tolist()]
    assert brown_forsythe(groups).statistic == pytest.approx(float(exact_spread_test(lists, median)), rel=1e-14)
    assert levene(groups).statistic == pytest.approx(float(exact_spread_test(lists, mean)), rel=1e-14)


def test_bartlett_between_nearly_equal_variances():
    """The textbook's difference of logarithms has lost all digits here; scipy's is 0 or negative."""
    a = np.arange(20.0)
    b = a.copy()
    b[-1] += 1e-7
    with mpmath.workdps(60):
        variances = []
        for values in (a, b):
            exact = [mpmath.mpf(float(x)) for x in values]
            middle = sum(exact) / 20
            variances.append(sum((x - middle) ** 2 for x in exact) / 19)
        pooled = sum(variances) / 2
        right = sum(19 * mpmath.log(pooled / one) for one in variances) / (
            1 + (mpmath.mpf(2) / 19 - mpmath.mpf(1) / 38) / 3
        )
    assert bartlett({"a": a, "b": b}).statistic == pytest.approx(float(right), rel=1e-14)


@pytest.mark.parametrize("name", TESTS)
def test_too_little_to_test(name):
    for groups in ({"a": [1.0, 2.0, 4.0]}, {"a": [1.0, 2.0, 4.0], "b": [1.0]}, {"a": [1.0, 2.0, 3.0], "b": []}):
        assert isinstance(TESTS[name](groups).p, Undefined)
    if name != "Bartlett":
        assert isinstance(TESTS[name]({"a": [1.0, 2.0], "b": [4.0, 9.0]}).p, Undefined)
    with pytest.raises(InputRefused, match="group 'b'"):
        TESTS[name]({"a": [1.0, 2.0, 4.0], "b": [1.0, math.nan]})


def test_the_f_test_and_its_interval():
    a, b = GROUPS["p"], GROUPS["q"]
    found = f_test(a, b, level=0.9)
    f = np.var(a, ddof=1) / np.var(b, ddof=1)
    assert found.ratio_ci == pytest.approx((f / scipy.stats.f.ppf(0.95, 6, 8), f / scipy.stats.f.ppf(0.05, 6, 8)))
    says(found.sentence(), "ratio of variances", "90 %")
    assert f_test([1.0, 1.0], [1.0, 2.0]).statistic == 0.0
    assert isinstance(f_test([1.0, 1.0], [1.0, 2.0]).p, Undefined)
    assert isinstance(f_test([1.0], [1.0, 2.0]).statistic, Undefined)
    assert f_test([1.0, 2.0, 4.0, math.nan], [3.0, 5.0, 9.0], missing="drop").group_ns == (3, 3)


@pytest.mark.parametrize("n", [26, 52, 400, 3000])
@pytest.mark.parametrize(("low", "high"), [(0.1, 0.3), (0.7, 1e9 + 0.1), (-1e-9, 0.3)])
def test_equal_distances_are_equal_in_groups_of_any_size(n, low, high):
    for test in (levene, brown_forsythe):
        none = test([[low, high] * (n // 2), [1.0, 2.0, 1.0, 2.0]]).p
        assert isinstance(none, Undefined)
        assert none.code is Reason.SPREADS_EQUAL
