"""Simultaneous intervals and adjusted p-values are one test: 0 is left out exactly where p is at most alpha."""

from __future__ import annotations

from hypothesis import assume, given
from hypothesis import strategies as st

from data_schema.vocabulary import Undefined
from stats.groups.dunnett import ALTERNATIVES, AgainstControl, Alternative, dunnett
from stats.groups.tukey import VARIANCES, Variances, compare_all_pairs

GROUPS = st.lists(st.lists(st.integers(0, 12), min_size=2, max_size=5), min_size=3, max_size=5)
"""A control and 2 to 4 others, of unequal numbers of values, some of them constant."""
ALPHAS = st.floats(0.001, 0.6)
NEAREST = 1e-9
"""Where p is alpha to so many digits, rounding may put it on either side."""


def leaves_out_0(one: AgainstControl) -> bool:
    above = not isinstance(one.ci_low, Undefined) and one.ci_low > 0.0
    below = not isinstance(one.ci_high, Undefined) and one.ci_high < 0.0
    return above or below


@given(GROUPS, ALPHAS, st.sampled_from(ALTERNATIVES))
def test_dunnetts(groups: list[list[int]], alpha: float, alternative: Alternative) -> None:
    assume(any(len(set(group)) > 1 for group in groups))
    treatments = {f"t{place}": group for place, group in enumerate(groups[1:])}
    found = dunnett(groups[0], treatments, alternative=alternative, level=1.0 - alpha)
    for one in found.comparisons:
        assert isinstance(one.p, float)
        if abs(one.p / alpha - 1.0) > NEAREST:
            assert leaves_out_0(one) == (one.p <= alpha)
        bounded = [not isinstance(end, Undefined) for end in (one.ci_low, one.ci_high)]
        assert bounded == [alternative != "less", alternative != "greater"]


@given(GROUPS, ALPHAS, st.sampled_from(VARIANCES))
def test_all_pairs(groups: list[list[int]], alpha: float, variances: Variances) -> None:
    """Tukey and Kramer's, and Games and Howell's; two constant groups have no test of their own among the latter."""
    named = {f"g{place}": group for place, group in enumerate(groups)}
    found = compare_all_pairs(named, variances=variances, level=1.0 - alpha)
    for pair in found.pairs:
        scatter = groups if variances == "equal" else [named[pair.a], named[pair.b]]
        assert isinstance(pair.p, Undefined) == all(len(set(group)) == 1 for group in scatter)
        assert isinstance(pair.difference_ci, Undefined) == isinstance(pair.p, Undefined)
        if isinstance(pair.p, Undefined) or isinstance(pair.difference_ci, Undefined):
            continue
        if abs(pair.p / alpha - 1.0) > NEAREST:
            low, high = pair.difference_ci
            assert (low > 0.0 or high < 0.0) == (pair.p <= alpha)
