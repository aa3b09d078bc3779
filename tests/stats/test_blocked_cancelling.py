"""Conditions over days whose values cancel: balanced contrasts keep their digits, whatever the values' size."""

from __future__ import annotations

from decimal import Decimal
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from stats.checks import as_sample
from stats.days.blocked import blocked_by_day
from stats.days.blocked_result import ExactTest
from stats.days.cells import cells_of
from tests.helpers.wording import says

CONDITION, DAY = list("aaaabbbb"), list("12341234")
NUMBERS = st.builds(
    lambda whole, size: float(whole) * 10.0**size, st.integers(-9, 9), st.sampled_from([-3, 0, 0, 0, 8, 17])
)


def designs(conditions: int, days: int, runs: int, times: int) -> dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Designs in which least squares takes the plain means of the conditions: condition, day, run of each value."""
    day, run, condition, _time = (each.ravel() for each in np.indices((days, runs, conditions, times)))
    return {
        "crossed": (condition, day, run),
        "a run a condition": (condition, day, run * conditions + condition),
        "a day a condition": (condition, day * conditions + condition, run),
    }


def test_what_cancels_leaves_its_digits():
    found = blocked_by_day([1e17, -1e17, 3.0, 4.0, 1.0, 2.0, 3.0, 5.0], CONDITION, DAY)
    for contrast in (found.mixed.contrasts[0], found.exact.contrasts[0]):
        assert contrast.difference == 1.0
    says(found.sentence(), "minus a is", "1", "95 %")
    assert [each.estimate for each in found.conditions] == [1.75, 2.75]
    within = [1.0 - 1e17, 2.0 + 1e17, 0.0, 1.0]
    right = 4.0 / (sum((Fraction(x) - 1) ** 2 for x in within) / 3)
    assert (found.exact.f, found.mixed.f) == pytest.approx((float(right), float(right)), rel=1e-12)


@pytest.mark.parametrize("kind", [int, Decimal, Fraction])
@pytest.mark.parametrize("offset", [0, 10**20, 10**25, -(10**28)])
def test_whole_numbers_keep_their_digits_at_an_offset(kind, offset):
    numbers = [kind(offset + each) for each in (1, 2, 5, 9, 4, 8, 7, 12)]
    found = blocked_by_day(numbers, CONDITION, DAY)
    assert (found.mixed.contrasts[0].difference, found.exact.contrasts[0].difference) == (3.5, 3.5)
    assert (found.mixed.f, found.exact.f) == pytest.approx((49 / 3, 49 / 3), rel=1e-13)
    some = blocked_by_day(numbers[1:], CONDITION[1:], DAY[1:])
    near = blocked_by_day([2, 5, 9, 4, 8, 7, 12], CONDITION[1:], DAY[1:])
    assert (some.f, some.p, some.contrasts[0].difference) == pytest.approx(
        (near.f, near.p, near.contrasts[0].difference), rel=1e-12
    )


@given(st.lists(NUMBERS, min_size=36, max_size=36), st.sampled_from(sorted(designs(3, 3, 2, 2))), st.booleans())
def test_balanced_contrasts_are_differences_of_means(numbers, design, with_runs):
    condition, day, run = designs(3, 3, 2, 2)[design]
    found = blocked_by_day(numbers, condition, day, run if with_runs else None)
    means = [sum(Fraction(x) for x, of in zip(numbers, condition, strict=True) if of == k) / 12 for k in range(3)]
    tests = [found, found.exact] if isinstance(found.exact, ExactTest) else [found]
    assert [each.estimate for each in found.conditions] == [float(mean) for mean in means]
    for told in tests:
        assert [each.difference for each in told.contrasts] == [float(mean - means[0]) for mean in means[1:]]


def test_only_balanced_designs_take_plain_means():
    for condition, day, run in designs(3, 3, 2, 2).values():
        group = np.unique(day * 100 + run, return_inverse=True)[1]
        sample = as_sample("values", np.arange(36.0))
        cells = cells_of(sample, condition, day, group)
        assert cells.plain(cells.day, cells.run)
        holed = cells_of(as_sample("values", np.arange(35.0)), condition[1:], day[1:], group[1:])
        assert not holed.plain(holed.day)
