import mpmath
import numpy as np
import pytest
from scipy import special

from data_schema.errors import InputRefused
from stats.compare.two_sample import compare_two
from stats.groups.anova import welch_anova
from tests.helpers.wording import says

GROUPS = {"0": [42.1, 39.8, 44.0], "50": [36.9, 38.2, 35.1, 37.7], "100": [37.0, 39.5]}
APART = {"0": [1.0, 2.0, 4.0, 3.5], "50": [2.0, 2.5, 3.0], "100": [5.0, 9.0, 5.5, 6.0, 5.1]}


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
    says(found.sentence("gain"), "ANOVA over gain", "2")
    above_chance, values = 2 * (f - 1), sum(n)
    assert found.eta_squared == pytest.approx(float(2 * f / (2 * f + values - k)), rel=1e-14)
    assert found.omega_squared == pytest.approx(float(above_chance / (above_chance + values)), rel=1e-14)


def test_the_share_of_variance_stands_in_the_sentence_and_at_the_level_asked_for():
    found = welch_anova(APART, level=0.9)
    low, high = found.eta_squared_ci
    shares = f"eta squared {found.eta_squared:.3g}, omega squared {found.omega_squared:.3g}"
    assert f"{shares} (90 % CI {low:.2f} to {high:.2f})" in found.sentence()
    wide_low, wide_high = welch_anova(APART).eta_squared_ci
    assert 0.0 < wide_low < low < found.omega_squared < high < wide_high < 1.0
    with pytest.raises(InputRefused, match="level"):
        welch_anova(GROUPS, level=95.0)


def test_the_ends_of_the_interval_leave_f_in_a_tail_of_2_5_percent():
    found = welch_anova(APART)
    low, high = (share / (1.0 - share) * sum(found.group_ns) for share in found.omega_squared_ci)
    df = found.df_between, found.df_within
    assert special.ncfdtr(*df, low, found.f) == pytest.approx(0.975, rel=1e-9)
    assert special.ncfdtr(*df, high, found.f) == pytest.approx(0.025, rel=1e-9)


DRAWS = 200


@pytest.mark.parametrize(
    ("sizes", "sds", "omega_squared", "coverage"),
    [
        # What 20 000 draws found; the interval's nominal coverage is 0.95.
        ((3, 3, 3), (1, 1, 1), 0.155, 0.960),
        pytest.param((5, 5, 5), (1, 1, 1), 0.142, 0.955, marks=pytest.mark.soak),
        pytest.param((10, 10, 10), (1, 1, 1), 0.142, 0.951, marks=pytest.mark.soak),
        pytest.param((25, 25, 25), (1, 1, 1), 0.142, 0.952, marks=pytest.mark.soak),
        pytest.param((3, 3, 3), (1, 2, 4), 0.214, 0.943, marks=pytest.mark.soak),
        pytest.param((25, 25, 25), (1, 2, 4), 0.187, 0.954, marks=pytest.mark.soak),
        pytest.param((5, 10, 20), (1, 1, 1), 0.128, 0.941, marks=pytest.mark.soak),
        pytest.param((5, 10, 20), (1, 2, 3), 0.229, 0.948, marks=pytest.mark.soak),
        pytest.param((3, 5, 12), (3, 2, 1), 0.119, 0.931, marks=pytest.mark.soak),
    ],
)
def test_the_share_of_variance_is_found_and_covered(sizes, sds, omega_squared, coverage):
    """effectsize's way, with Welch's df_within for n - k, finds 0.194 where the share is 0.143 (n = 25, equal SDs) and
    covers it in 0.917; 0.282 where it is 0.186 (SDs 1, 2, 4), in 0.865."""
    n, sd = np.array(sizes), np.array(sds, dtype=float)
    means = 0.5 * np.sqrt((n - 1) @ sd**2 / (n.sum() - 3)) * np.arange(3)
    weights = n / sd**2
    noncentrality = weights @ (means - weights @ means / weights.sum()) ** 2
    share = noncentrality / (noncentrality + n.sum())
    rng = np.random.default_rng(20261122)
    found = [
        welch_anova([rng.normal(*each) for each in zip(means, sd, n, strict=True)], level=0.95) for _ in range(DRAWS)
    ]
    above_chance = np.array([one.df_between * (one.f - 1.0) for one in found])
    omegas = above_chance / (above_chance + n.sum())  # below 0 too: without bias, before F < 1 is shown as 0
    assert abs(omegas.mean() - omega_squared) < 4.0 * omegas.std() / np.sqrt(DRAWS)
    held = np.mean([one.omega_squared_ci[0] <= share <= one.omega_squared_ci[1] for one in found])
    assert abs(held - coverage) < 4.0 * np.sqrt(0.05 * 0.95 / DRAWS)


@pytest.mark.parametrize("exponent", [-400, 400])
def test_shares_of_variance_have_limits(exponent):
    """All of the variance lies between groups that are far apart for their scatter, none where all means agree."""
    apart = welch_anova({name: np.ldexp([0.0, 1.0, 3.0], -40) + k for k, name in enumerate("abc")})
    assert (apart.omega_squared, apart.eta_squared, apart.eta_squared_ci) == (1.0, 1.0, (1.0, 1.0))
    alike = welch_anova({name: np.ldexp([0.0, 1.0, 3.0], exponent) for name in "abc"})
    assert (alike.f, alike.eta_squared, alike.eta_squared_ci[0]) == (0.0, 0.0, 0.0)
    assert alike.omega_squared == 0.0


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
    assert found.f == found.df_within == found.p == found.log10_p == found.eta_squared == found.omega_squared
    assert found.f == found.eta_squared_ci == found.omega_squared_ci
    assert reason in found.sentence()


def test_very_many_groups_are_not_taken_pair_by_pair():
    """2000 groups: exact arithmetic over their 1 999 000 pairs would take minutes."""
    values = np.random.default_rng(5).normal(size=(2000, 3)).round(3)
    weights, means = 3.0 / values.var(axis=1, ddof=1), values.mean(axis=1)
    shares = weights / weights.sum()
    doubt = float(np.sum((1.0 - shares) ** 2 / 2.0))
    centre = float(shares @ means)
    f = float(weights @ (means - centre) ** 2) / 1999 / (1.0 + 2.0 * 1998 * doubt / (2000**2 - 1))
    found = welch_anova(values)
    assert (found.f, found.df_within) == pytest.approx((f, (2000**2 - 1) / (3.0 * doubt)), rel=1e-9)
