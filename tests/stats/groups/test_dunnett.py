import math
import pickle

import numpy as np
import pytest
import scipy.stats

from data_schema.errors import InputRefused, UnknownName
from data_schema.vocabulary import Undefined
from stats.compare.two_sample import compare_two
from stats.exact.tails import t_two_sided
from stats.groups.dunnett import dunnett, largest_critical, largest_log_upper, log_largest_chance
from tests.helpers.wording import refuses, says

CONTROL = [42.1, 39.8, 44.0, 41.2]
TREATED = {"50": [36.9, 38.2, 35.1, 37.7], "100": [37.0, 39.5], "150": [41.0, 42.2, 40.1, 39.9, 42.8]}


def upper(c, n_control, n_treated, df, *, two_sided=True):
    return math.exp(largest_log_upper(c, n_control, n_treated, df, two_sided=two_sided))


@pytest.mark.parametrize(
    ("c", "n_control", "n", "df"), [(2.5, 5, 5, 8), (25.0, 5, 5, 8), (40.0, 3, 300, 60), (0.01, 3, 300, 1)]
)
def test_one_treatment_is_the_t_test(c, n_control, n, df):
    assert upper(c, n_control, (n,), df) == pytest.approx(t_two_sided(c, df).p, rel=1e-13)
    assert upper(c, n_control, (n,), df, two_sided=False) == pytest.approx(t_two_sided(c, df).p / 2.0, rel=1e-13)
    assert upper(-c, n_control, (n,), df, two_sided=False) == pytest.approx(1.0 - t_two_sided(c, df).p / 2.0)


def by_gauss(c, n_control, n_treated, df):
    """The definition by other nodes: Gauss and Legendre over s and the control's mean."""
    nodes, widths = np.polynomial.legendre.leggauss(160)
    s, s_weights = 2.5 * (nodes + 1.0), 2.5 * widths
    density = 2.0 * (df / 2.0) ** (df / 2.0) / math.gamma(df / 2.0) * s ** (df - 1.0) * np.exp(-df * s * s / 2.0)
    y, y_weights = 9.0 * nodes, 9.0 * widths
    inside = np.ones((s.size, y.size))
    for n in n_treated:
        slope, root = math.sqrt(n / (n + n_control)), math.sqrt(n_control / (n + n_control))
        low, high = ((side * c * s[:, None] + slope * y) / root for side in (-1.0, 1.0))
        inside *= scipy.special.ndtr(high) - scipy.special.ndtr(low)
    return float(s_weights @ (density * ((1.0 - inside) @ (y_weights * scipy.stats.norm.pdf(y)))))


@pytest.mark.parametrize(
    ("c", "n_control", "n_treated", "df"),
    [
        (2.5, 5, (5, 5, 5), 16),
        (2.5, 5, (3, 10, 25), 39),
        (2.2, 20, (3, 3), 23),
        (1.7, 3, (20, 30), 10),
        (2.0, 4, (4,) * 10, 5),
    ],
)
def test_the_largest_t_agrees_with_its_definition(c, n_control, n_treated, df):
    assert upper(c, n_control, n_treated, df) == pytest.approx(by_gauss(c, n_control, n_treated, df), rel=1e-12)


STEEP = (2, (2, 1_000_000), True)
"""A treatment of a million values against a control of 2: its chance is a step, 700 times narrower than a normal."""
TWO_STEPS = (25, (100, 10_000), True)
ONE_SIDED = (1, (1, 10, 1000), False)
THOUSAND = (4, (4,) * 1000, True)
MANY_LARGE = (1, (100,) * 300, False)


@pytest.mark.parametrize(
    ("family", "w", "log_g"),
    [
        (STEEP, 0.4, -0.13938552452491915),
        (STEEP, 2.5, -3.8264850781000437),
        (STEEP, 9.0, -42.241936544201942),
        (TWO_STEPS, 0.4, -0.19898949166861984),
        (TWO_STEPS, 2.5, -3.9856463047451869),
        (TWO_STEPS, 9.0, -42.257301027332317),
        (ONE_SIDED, -1.3, -0.038739458356687368),
        (ONE_SIDED, 2.5, -4.3604790139496194),
        (ONE_SIDED, 9.0, -42.583582076659775),
        (THOUSAND, 1.7, -7.6150000939097577e-9),
        (THOUSAND, 3.3, -1.717239604080615),
        (THOUSAND, 9.0, -36.027319016519265),
        (MANY_LARGE, -0.4, -0.28147721722782254),
        (MANY_LARGE, 2.5, -4.3345508479140185),
        (MANY_LARGE, 9.0, -41.381780802855216),
    ],
)
def test_tails_of_very_unequal_sizes_and_of_many_treatments(family, w, log_g):
    """The definition by mpmath to 22 digits, Gauss's rule over y on stretches of half a width of each step."""
    n_control, n_treated, two_sided = family
    (found,) = log_largest_chance(np.array([w]), n_control, n_treated, two_sided=two_sided)
    assert float(found) == pytest.approx(log_g, abs=2e-14)


@pytest.mark.parametrize(("n_control", "n_treated"), [(2, (1_000_000, 2)), (25, (10_000, 100)), (5, (500, 5))])
@pytest.mark.parametrize(("c", "df"), [(0.7, 3), (2.5, 10), (6.0, 40)])
def test_p_of_very_unequal_sizes(n_control, n_treated, c, df):
    """Gauss's rule over the scale itself, not its logarithm."""
    nodes, widths = np.polynomial.legendre.leggauss(160)
    s = 2.5 * (nodes + 1.0)
    density = 2.0 * (df / 2.0) ** (df / 2.0) / math.gamma(df / 2.0) * s ** (df - 1.0) * np.exp(-df * s * s / 2.0)
    chance = np.exp(log_largest_chance(c * s, n_control, n_treated, two_sided=True))
    p = float(2.5 * widths @ (density * chance))
    assert upper(c, n_control, n_treated, df) == pytest.approx(p, rel=1e-12)


@pytest.mark.parametrize("df", [1.0, 3.7, 31.9, 32.1, 1e4, 1e9, math.inf])
def test_one_treatment_is_t_at_any_number_of_degrees_of_freedom(df):
    exact = scipy.special.stdtr(df, -2.0) if math.isfinite(df) else scipy.special.ndtr(-2.0)
    found = upper(2.0, 3, (5,), df, two_sided=False)
    assert found == pytest.approx(exact, rel=1e-13 if df < 1e6 else 1e-12)


def test_far_tails_keep_their_digits():
    """The sum of single tails is an upper bound, the largest a lower one; quasi-random integration is off by 77 %."""
    single = t_two_sided(10.0, 39).p
    assert single < upper(10.0, 5, (3, 10, 25), 39) < 3.0 * single
    log_p = largest_log_upper(1e6, 5, (3, 10, 25), 100, two_sided=True)
    assert -2400.0 < log_p < -700.0


def test_critical_values_are_those_of_dunnetts_tables():
    """Three treatments, 16 degrees of freedom, equal n: 2.59 two-sided, 2.23 one-sided."""
    assert largest_critical(0.05, 5, (5, 5, 5), 16, two_sided=True) == pytest.approx(2.59, abs=0.005)
    assert largest_critical(0.05, 5, (5, 5, 5), 16, two_sided=False) == pytest.approx(2.23, abs=0.005)


def test_the_same_digits_at_every_call():
    """W26: scipy's p changes in the fourth digit between calls (0.25607 to 0.25613)."""
    first, second = dunnett(CONTROL, TREATED), dunnett(CONTROL, TREATED)
    assert first == second


def test_one_treatment_and_its_interval_are_students():
    found = dunnett(CONTROL, {"50": TREATED["50"]})
    (item,), student = found.comparisons, compare_two(TREATED["50"], CONTROL, route="student")
    assert (item.t, item.p, item.difference) == pytest.approx((student.t, student.p, student.difference), rel=1e-12)
    assert (item.ci_low, item.ci_high) == pytest.approx(student.difference_ci, rel=1e-11)
    assert found.df == student.df


@pytest.mark.parametrize("alternative", ["greater", "less"])
def test_one_sided_comparisons(alternative):
    found = dunnett(CONTROL, TREATED, alternative=alternative)
    assert pickle.loads(pickle.dumps(found)).sentence() == found.sentence()
    mirrored = dunnett(
        [-x for x in CONTROL],
        {name: [-x for x in values] for name, values in TREATED.items()},
        alternative="less" if alternative == "greater" else "greater",
    )
    for item, mirror in zip(found.comparisons, mirrored.comparisons, strict=True):
        assert item.p == pytest.approx(mirror.p, rel=1e-13)
        bound, other = (item.ci_low, item.ci_high) if alternative == "greater" else (item.ci_high, item.ci_low)
        assert (bound > 0.0 if alternative == "greater" else bound < 0.0) == (item.p < 0.05)
        assert isinstance(other, Undefined)
    assert "undefined" not in found.sentence("J")


def test_sentence():
    text = dunnett(CONTROL, TREATED, control_name="CE").sentence("J")
    says(text, "Dunnett against CE", "n = 4", "95 %", "50", "-4.8 J")
    assert text.count("p ") == 3


def test_constants_have_no_test():
    """W3: scipy's dunnett gives p = 0.014 for groups of 0.1 alone."""
    found = dunnett([0.1] * 3, {"a": [0.1] * 7, "b": [0.2] * 5})
    assert all("any scatter" in item.p.reason for item in found.comparisons)
    assert [item.difference for item in found.comparisons] == [0.0, 0.1]


def test_wrong_input():
    with refuses(InputRefused, "as the control"):
        dunnett(CONTROL, {"the control": [1.0, 2.0]})
    with pytest.raises(UnknownName):
        dunnett(CONTROL, TREATED, alternative="grater")
    empty = dunnett(CONTROL, {**TREATED, "200": []})
    assert "'200' is empty" in empty.comparisons[0].p.reason
    assert "'200' is empty" in empty.comparisons[3].difference.reason
    assert "control is empty" in dunnett([], TREATED).comparisons[0].difference.reason
    assert "no treatment" in dunnett(CONTROL, {}).critical.reason
    says(dunnett([1.0], {"a": [2.0]}).comparisons[0].p.reason, "than one value")


@pytest.mark.parametrize("level", [2.9802322387695312e-08, 1e-9, 0.95, 1.0 - 1e-12])
def test_of_one_comparison_the_critical_value_is_that_of_t(level):
    found = largest_critical(1.0 - level, 52, (2,), 20.0, two_sided=False)
    assert found == pytest.approx(scipy.stats.t.isf(1.0 - level, 20.0), rel=1e-6, abs=1e-9)
