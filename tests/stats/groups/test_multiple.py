"""Holm's adjustment as the closed test, and families with tests that could not be made."""

from itertools import combinations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused
from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from stats.groups.multiple import holm
from tests.helpers.wording import refuses, says


@given(st.lists(st.floats(1e-300, 1.0), min_size=1, max_size=6))
def test_holm_is_bonferroni_over_all_subsets(ps):
    """The closed test: a hypothesis falls only if every subset of the family that it belongs to falls."""
    found = holm({str(k): p for k, p in enumerate(ps)}, "tests")
    places = range(len(ps))
    subsets = [set(some) for size in range(1, len(ps) + 1) for some in combinations(places, size)]
    closed = [max(min(1.0, len(s) * min(ps[k] for k in s)) for s in subsets if place in s) for place in places]
    assert found.adjusted_p == pytest.approx(closed, rel=1e-14)
    assert list(found.rejected) == [p <= 0.05 for p in found.adjusted_p]
    backwards = holm({str(k): p for k, p in reversed(list(enumerate(ps)))}, "tests")
    assert backwards.adjusted_p == found.adjusted_p[::-1]


def test_a_test_without_p_belongs_to_the_family_still():
    none = Undefined(Reason.NO_GROUP_SCATTERS)
    found = holm({"a": 0.02, "b": none}, "gains against control")
    assert found.adjusted_p == (0.04, none)
    assert found.rejected == (True, none)
    says(found.sentence(), "2 tests", "1", "p = .040")
    assert "none rejected" in holm({}, "no tests").sentence()


def test_a_family_says_how_many_were_tested_and_why_others_were_not():
    why, other = Undefined(Reason.GROUPS_WITHOUT_SCATTER), Undefined(Reason.AS_SAID, said="group 'd' is empty")
    some = holm({"a": 0.2, "b": why, "c": why, "d": other}, "gains at 0.05: all").sentence()
    says(some, "0.05", "4 tests", "3", "1 tested", "'d'")
    says(holm({"a": why, "b": why}, "gains").sentence(), "0.05", "because neither group")
    many = holm({"a": 0.01, **{f"b{place}": why for place in range(14)}}, "gains").sentence()
    says(many, "not tested", "b0", "b1", "b9", "4 more")


@pytest.mark.parametrize("bad", [-0.1, 1.5, float("nan")])
def test_what_is_no_probability_is_refused(bad):
    with refuses(InputRefused, "from", "0", "1"):
        holm({"a": bad}, "tests")
