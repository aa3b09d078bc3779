"""Which simulated design stands for how groups share their days: never one in which tests err less often."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from labbook.presenting.day_layout import with_days, without_days
from labbook.presenting.weak_points import Use, on_runs
from stats.recorded import recorded, weak_points
from stats.two_sample import compare_two

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
        ("a", "abcde", 10, ((20, 20), 2, "own")),  # more than any design takes from days that shares one
        ("aaaab", "abbbb", 2, ((10, 10), 2, "own")),  # days are shared, and each group has most runs on one
        ("abcdefghij", "abcdefghik", 10, ((25, 25), 5, "mostly")),  # more days than on record: fewer runs a day
    ],
)
def test_the_design_looked_up(a: str, b: str, runs: int, found: tuple[object, ...]) -> None:
    assert without_days("welch", [of(a, runs), of(b, runs)]) == found


def taken(a: Counter[str], b: Counter[str]) -> tuple[float, float]:
    """What the difference of means takes from days, and that against what it takes from runs, drawn out run by run."""
    weights = {day: a[day] / a.total() - b[day] / b.total() for day in {*a, *b}}
    apart = float(np.square(list(weights.values())).sum())
    return apart, apart / (1.0 / a.total() + 1.0 / b.total())


@settings(deadline=None)
@given(counts, counts)
def test_a_design_looked_up_takes_as_much_from_days_or_is_the_worst_on_record(a: list[int], b: list[int]) -> None:
    groups = [Counter({str(day): n for day, n in enumerate(side) if n}) for side in (a, b)]
    if not all(groups):
        return
    n, days, layout = without_days("welch", groups)
    apart, ratio = taken(*groups)
    if layout == "shared":
        assert apart == 0.0
        return
    common = {"own": 0, "partly": 1, "mostly": days - 1}[layout]
    simulated = [
        Counter({str(d) if d < common else f"{side}{d}": size // days for d in range(days)})
        for side, size in zip("ab", n, strict=True)
    ]
    theirs = taken(*simulated)
    assert theirs[0] >= apart * (1.0 - 1e-9)
    most = max(max(row.n) / (row.days or 1) for row in recorded() if (row.method, row.layout) == ("welch", layout))
    assert theirs[1] >= ratio * (1.0 - 1e-9) or n[0] / days == n[1] / days == most


def test_groups_of_unequal_size_are_looked_up_among_such() -> None:
    few, many = of("ab", 3), of("cd", 10)
    assert without_days("welch", [few, many]) == ((6, 20), 2, "own")
    assert without_days("welch", [of("ab", 9), many])[0] == (20, 20)
    cited = on_runs("f_then_t", [few, many]).weak_points()
    assert {(row.n, row.sd_ratio) for row in cited if row.days} == {((6, 20), 0.5), ((6, 20), 2.0)}


def rejected(groups: list[Counter[str]], studies: int) -> float:
    """The share of studies without an effect that Welch's test rejects, days differing as much as runs."""
    rng, wrong = np.random.default_rng(4), 0
    for _study in range(studies):
        level = {day: rng.standard_normal() for day in {*groups[0], *groups[1]}}
        a, b = ([level[day] + rng.standard_normal() for day in group.elements()] for group in groups)
        p = compare_two(a, b, "welch").p
        wrong += isinstance(p, float) and p <= 0.05
    return wrong / studies


@pytest.mark.parametrize(
    ("a", "b", "runs"), [("abcde", "abcdf", 10), ("a", "abcde", 10), ("aaaab", "abbbb", 2), ("abcdef", "abcdgh", 8)]
)
def test_what_is_cited_is_no_better_than_the_design_itself(a: str, b: str, runs: int) -> None:
    groups = [of(a, runs), of(b, runs)]
    cited = max(Use("welch", *without_days("welch", groups)).weak_points(), key=lambda row: row.value)
    share = rejected(groups, 400)
    assert 0.06 < share < cited.value + 3.0 * (cited.value * (1.0 - cited.value) / 400) ** 0.5


def test_few_runs_a_day_on_nearly_shared_days_need_no_sentence() -> None:
    groups = [of("abcde", 3), of("abcdf", 3)]
    assert Use("welch", *without_days("welch", groups)).weak_points() == ()


def test_groups_of_unequal_size_are_cited_as_such_on_days_nearly_shared() -> None:
    """A design on record that stands for the days has groups of one size, which hides what 5 against 20 runs do."""
    groups = [Counter(dict(zip("abcd", (2, 1, 1, 1), strict=True))), of("abcd", 5)]
    unequal = weak_points("f_then_t", (5, 20), layout="")
    assert unequal
    assert on_runs("f_then_t", groups).weak_points()[-len(unequal) :] == unequal
    assert unequal == on_runs("f_then_t", [of("abcde", 1), of("abcde", 4)]).weak_points()


def test_what_is_not_on_record_by_day_is_looked_up_by_its_sizes() -> None:
    assert without_days("brown_forsythe", [of("ab", 3), of("cd", 3)]) == ((6, 6), 2, "own")


def test_several_groups_are_looked_up_by_the_two_that_lie_farthest_apart() -> None:
    groups = [of("abc", 5), of("abc", 5), of("abd", 5)]
    assert without_days("one_way_anova", groups) == ((15, 15, 15), 3, "mostly")


def test_an_analysis_with_the_day_in_it_is_looked_up_by_how_days_are_shared() -> None:
    assert with_days([of("aaaab", 2), of("abbbb", 2)]) == ((10, 10), 2, "shared")
    assert with_days([of("abcdef", 3), of("abcdgh", 3)]) == ((18, 18), 3, "mostly")
    assert with_days([of("abc", 3), of("ade", 3)]) == ((9, 9), 3, "partly")
