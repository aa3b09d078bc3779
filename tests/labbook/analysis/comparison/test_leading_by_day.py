"""Which comparison by day is stated: the exact test where the design is balanced, and nowhere else."""

from __future__ import annotations

from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st

from data_schema.vocabulary import Undefined
from labbook.analysis.comparison.leading_by_day import MIXED_MODEL, leading
from stats.days.blocked import blocked_by_day
from stats.days.blocked_result import ExactTest

UNBALANCED = [("A", "w", 1.0), ("A", "w", 1.2), ("B", "w", 2.1), ("A", "x", 0.4), ("B", "x", 1.1), ("B", "x", 1.4)]

designs = st.lists(
    st.tuples(st.sampled_from("AB"), st.sampled_from("wxy"), st.floats(-3.0, 3.0).map(lambda x: round(x, 2))),
    min_size=4, max_size=12,
).filter(lambda rows: len({name for name, _day, _value in rows}) > 1)  # fmt: skip


@settings(deadline=None, max_examples=60)
@given(designs)
def test_the_exact_test_leads_just_where_it_is_balanced(rows: list[tuple[str, str, float]]) -> None:
    names, days, values = zip(*rows, strict=True)
    found = blocked_by_day(values, names, days)
    balanced = isinstance(found.exact, ExactTest) and found.exact.balanced
    assert (leading(found).exact is not None) == balanced
    # an unbalanced exact test stands beside a model that has a test of its own: nothing is lost by not stating it
    assert balanced or isinstance(found.exact, Undefined) or not isinstance(found.f, Undefined)


def test_an_exact_test_that_is_not_balanced_does_not_lead_for_want_of_another() -> None:
    names, days, values = zip(*UNBALANCED, strict=True)
    found = replace(blocked_by_day(values, names, days), f=Undefined("it is not known"))
    assert isinstance(found.exact, ExactTest)
    assert leading(found).method == MIXED_MODEL
    assert leading(found).contrasts == found.contrasts
    assert found.sentence().startswith("No test of the conditions with day as a random effect")
    assert found.contrasts[0].sentence(found.level) in found.sentence()
