"""Which simulated design stands for how groups share their days: never one in which tests err less often."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats as reference

from benchmarks.stats_evidence.sizes.record import every_rate
from labbook.presenting.report.day_layout import with_days, without_days
from labbook.presenting.report.error_rates import Use, on_runs
from stats.compare.two_sample import compare_two
from stats.planning.recorded import weak_point

EVERY = every_rate()
counts = st.lists(st.integers(0, 12), min_size=1, max_size=8)


def of(text: str, runs: int = 1) -> Counter[str]:
    """So many runs a letter: "aab" is two times as many on day a as on day b."""
    return Counter({day: runs * times for day, times in Counter(text).items()})


@pytest.mark.parametrize(
    ("a", "b", "runs", "found"),
    [
        ("abc", "abc", 5, ((15, 15), 3, "shared")),
        ("aab", "aaaabb", 5, ((15, 30), 2, "shared")),  # twice as many runs, alike over the days
        ("abcde", "abcdf", 10, ((50, 50), 5, "mostly")),
        ("abcde", "abcdf", 4, ((25, 25), 5, "mostly")),  # 4 a day are not on record, 5 are
        ("abcdef", "abcdgh", 3, ((9, 9), 3, "mostly")),  # every third day has one group only
        ("abc", "ade", 5, ((15, 15), 3, "partly")),
        ("ab", "cd", 5, ((10, 10), 2, "own")),
        ("a", "b", 10, ((10, 10), 1, "own")),
        ("a", "abcde", 10, ((50, 165), 5, "partly")),  # 10 against 50 are unequal, those of 10 and 33 a day nearest
        ("abcdef", "ghijkl", 1, ((6, 6), 6, "own")),
        ("aaaab", "abbbb", 2, ((10, 10), 2, "own")),  # days are shared, and each group has most runs on one
        ("abcdefghij", "abcdefghik", 10, ((60, 60), 6, "mostly")),  # more days than on record
    ],
)
def test_the_design_looked_up(a: str, b: str, runs: int, found: tuple[object, ...]) -> None:
    assert without_days("welch", [of(a, runs), of(b, runs)]) == found


def excess(a: Counter[str], b: Counter[str]) -> float:
    """The variance of the difference over what is expected of it, from the covariance of all runs, days as runs."""
    days = sorted({*a, *b})
    runs = [days.index(day) for group in (a, b) for day in group.elements()]
    of_days = np.equal.outer(runs, runs).astype(float)
    covariance = np.eye(len(runs)) + of_days
    weights = np.concatenate([np.full(a.total(), 1.0 / a.total()), np.full(b.total(), -1.0 / b.total())])
    expected = 0.0
    for start, n in ((0, a.total()), (a.total(), b.total())):
        centring = np.eye(n) - 1.0 / n
        own = covariance[start : start + n, start : start + n]
        expected += float(np.trace(centring @ own)) / (n - 1) / n if n > 1 else 1.0
    return float(weights @ covariance @ weights) / expected


@given(counts, counts)
def test_a_design_looked_up_exceeds_as_much_what_is_expected_or_is_the_worst_on_record(
    a: list[int], b: list[int]
) -> None:
    groups = [Counter({str(day): n for day, n in enumerate(side) if n}) for side in (a, b)]
    if not all(groups):
        return
    n, days, layout = without_days("welch", groups)
    if layout == "shared":
        shares = [{day: runs / group.total() for day, runs in group.items()} for group in groups]
        assert shares[0] == pytest.approx(shares[1])
        return
    common = {"own": 0, "partly": 1, "mostly": days - 1}[layout]
    simulated = [
        Counter({str(d) if d < common else f"{side}{d}": size // days for d in range(days)})
        for side, size in zip("ab", n, strict=True)
    ]
    assert excess(*simulated) >= excess(*groups) * (1.0 - 1e-9) or (n, days, layout) == ((25, 25), 1, "own")


def test_groups_of_unequal_size_are_looked_up_among_such() -> None:
    few, many = of("ab", 3), of("cd", 10)
    assert without_days("welch", [few, many]) == ((6, 20), 2, "own")
    assert without_days("welch", [of("ab", 9), many])[0] == (20, 20)
    cited = on_runs("f_then_t", [few, many]).weak_points()
    assert {row.n for row in cited if row.days} == {(6, 20)}
    beyond = without_days("welch", [of("a", 10), of("b", 33)])
    assert beyond == without_days("welch", [of("a", 25), of("b", 99)]) == ((10, 33), 1, "own")
    assert without_days("one_way_anova", [of("a", 5), of("b", 10), of("c", 20)]) == ((10, 20, 40), 1, "own")


def rejected(groups: list[Counter[str]], studies: int) -> float:
    """The share of studies without an effect that Welch's test rejects, days differing as much as runs."""
    rng = np.random.default_rng(4)
    days = sorted({*groups[0], *groups[1]})
    levels = rng.standard_normal((studies, len(days)))
    places = [[days.index(day) for day in group.elements()] for group in groups]
    a, b = (levels[:, of_group] + rng.standard_normal((studies, len(of_group))) for of_group in places)
    p = reference.ttest_ind(a, b, axis=1, equal_var=False).pvalue
    assert compare_two(a[0], b[0], "welch").p == pytest.approx(p[0], rel=1e-9)
    return float(np.mean(p <= 0.05))


@pytest.mark.parametrize(
    ("a", "b", "runs"),
    [
        ("abcde", "abcdf", 10),
        ("a", "abcde", 10),
        ("aaaab", "abbbb", 2),
        ("abcdef", "abcdgh", 8),
        ("abcdef", "ghijkl", 2),
        ("abc", "def", 2),
        ("ab", "cd", 5),
    ],
)
def test_what_is_cited_is_about_what_the_design_itself_does(a: str, b: str, runs: int) -> None:
    groups = [of(a, runs), of(b, runs)]
    found = ("welch", *without_days("welch", groups), 1.0)
    (cited,) = [row.value for row in EVERY if (row.method, row.n, row.days, row.layout, row.sd_ratio) == found]
    share = rejected(groups, 400)
    error = (cited * (1.0 - cited) / 400) ** 0.5
    assert 0.06 < share < cited + 3.0 * error
    assert cited < 1.5 * share + 3.0 * error


@pytest.mark.parametrize(
    ("a", "b", "runs"), [("abcde", "abcdf", 3), ("abcdef", "ghijkl", 1), ("abcdefgh", "ijklmnop", 1), ("abc", "ade", 1)]
)
def test_days_that_runs_of_a_group_show_themselves_need_no_sentence(a: str, b: str, runs: int) -> None:
    """On days of one run each their scatter is in that of the runs; nearly shared ones take little."""
    groups = [of(a, runs), of(b, runs)]
    assert Use("welch", *without_days("welch", groups)).weak_points() == ()
    assert rejected(groups, 400) < 0.06 + 3.0 * (0.06 * 0.94 / 400) ** 0.5


def test_groups_of_unequal_size_are_cited_as_such_on_days_nearly_shared() -> None:
    """A design on record that stands for the days has groups of one size, which hides what 5 against 20 runs do."""
    groups = [Counter(dict(zip("abcd", (2, 1, 1, 1), strict=True))), of("abcd", 5)]
    unequal = weak_point("f_then_t", (5, 20))
    assert unequal is not None
    assert on_runs("f_then_t", groups).weak_points()[-1] == unequal
    assert on_runs("f_then_t", [of("abcde", 1), of("abcde", 4)]).weak_points() == (unequal,)


def test_what_is_not_on_record_by_day_is_looked_up_by_its_sizes() -> None:
    assert without_days("brown_forsythe", [of("ab", 3), of("cd", 3)]) == ((6, 6), 2, "own")


def test_several_groups_are_looked_up_by_the_two_that_lie_farthest_apart() -> None:
    groups = [of("abc", 5), of("abc", 5), of("abd", 5)]
    assert without_days("one_way_anova", groups) == ((15, 15, 15), 3, "mostly")


def test_an_analysis_with_the_day_in_it_is_looked_up_by_how_days_are_shared() -> None:
    assert with_days([of("aaaab", 2), of("abbbb", 2)]) == ((10, 10), 2, "shared")
    assert with_days([of("abcdef", 3), of("abcdgh", 3)]) == ((18, 18), 3, "mostly")
    assert with_days([of("abc", 3), of("ade", 3)]) == ((9, 9), 3, "partly")
