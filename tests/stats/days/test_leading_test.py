"""Which comparison by day is stated, the exact test where the design is balanced; and what needs no equal scatter."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
import scipy.stats
from hypothesis import given
from hypothesis import strategies as st

from data_schema.reasons import Reason
from data_schema.rounding import p_text
from data_schema.vocabulary import Undefined
from stats.days.blocked import blocked_by_day
from stats.days.blocked_result import MIXED_MODEL, BlockedByDay, ExactTest
from tests.helpers.wording import says

UNBALANCED = [("A", "w", 1.0), ("A", "w", 1.2), ("B", "w", 2.1), ("A", "x", 0.4), ("B", "x", 1.1), ("B", "x", 1.4)]
BALANCED = [("A", "w", 1.0), ("A", "w", 1.2), ("B", "w", 2.1), ("B", "w", 1.4), ("A", "x", 0.4), ("A", "x", 1.1)]
BALANCED += [("B", "x", 1.7), ("B", "x", 1.9), ("A", "y", 0.9), ("A", "y", 1.4), ("B", "y", 2.0), ("B", "y", 1.3)]

Rows = list[tuple[str, str, float]]
designs = st.lists(
    st.tuples(st.sampled_from("AB"), st.sampled_from("wxy"), st.floats(-3.0, 3.0).map(lambda x: round(x, 2))),
    min_size=4, max_size=12,
).filter(lambda rows: len({name for name, _day, _value in rows}) > 1)  # fmt: skip


def compared(rows: Rows) -> BlockedByDay:
    names, days, values = zip(*rows, strict=True)
    return blocked_by_day(values, names, days)


@given(designs)
def test_the_exact_test_leads_just_where_it_is_balanced(rows: Rows) -> None:
    found = compared(rows)
    balanced = isinstance(found.exact, ExactTest) and found.exact.balanced
    assert (found.leading() is found.exact) == balanced
    # an unbalanced exact test stands beside a model that has a test of its own: nothing is lost by not stating it
    assert balanced or isinstance(found.exact, Undefined) or not isinstance(found.mixed.f, Undefined)


@given(designs)
def test_f_and_p_are_those_of_the_sentence(rows: Rows) -> None:
    """The fields were the mixed model's where the sentence began with the exact test."""
    found = compared(rows)
    if isinstance(found.f, Undefined):
        assert found.sentence().startswith("No test of the conditions")
        return
    first = found.sentence().split("; ")[0].split("(REML")[0].split("(exact")[0]
    assert first.rstrip().endswith(p_text(found.p, 0.05))
    assert f"F({found.df_between}, " in first
    (contrast,) = found.contrasts
    assert contrast.sentence(found.level) in found.sentence()


def test_an_exact_test_that_is_not_balanced_does_not_lead_for_want_of_another() -> None:
    found = compared(UNBALANCED)
    found = replace(found, mixed=replace(found.mixed, f=Undefined(Reason.AS_SAID, said="it is not known")))
    assert isinstance(found.exact, ExactTest)
    assert found.method == MIXED_MODEL
    assert found.contrasts == found.mixed.contrasts
    says(found.sentence(), "conditions with day")
    assert found.contrasts[0].sentence(found.level) in found.sentence()


def test_the_exact_test_says_what_it_assumes_and_has_the_paired_one_beside_it() -> None:
    text = compared(BALANCED).sentence()
    says(text, "conditions scatter alike")
    says(text, "Paired", "3 days")


def test_where_the_exact_test_is_the_paired_one_it_assumes_nothing_of_scatter() -> None:
    rows = [("A", "w", 1.0), ("B", "w", 2.0), ("A", "x", 0.4), ("B", "x", 1.1), ("A", "y", 0.8), ("B", "y", 2.4)]
    found = compared(rows)
    assert isinstance(found.exact, ExactTest)
    (exact,), (paired,) = found.exact.contrasts, found.paired
    assert (exact.t, exact.df, exact.p) == pytest.approx((paired.t, paired.df, paired.p), rel=1e-12)
    assert "alike" not in found.sentence()
    assert "Paired" not in found.sentence()


def test_paired_is_students_test_of_the_differences_of_day_means() -> None:
    rng = np.random.default_rng(4)
    rows = [
        (name, f"day {day}", float(np.round(rng.normal(3.0, 1.0), 3)))
        for day, counts in enumerate([(3, 10), (1, 4), (2, 2), (4, 0), (0, 3)])
        for name, count in zip("AB", counts, strict=True)
        for _ in range(count)
    ]
    (paired,) = compared(rows).paired
    means = {
        name: np.array([np.mean([v for n, d, v in rows if (n, d) == (name, f"day {day}")]) for day in range(3)])
        for name in "AB"
    }
    other = scipy.stats.ttest_rel(means["B"], means["A"])
    interval = other.confidence_interval(0.95)
    assert (paired.t, paired.df, paired.p) == pytest.approx((other.statistic, 2.0, other.pvalue), rel=1e-11)
    assert paired.interval == pytest.approx((interval.low, interval.high), rel=1e-11)
    assert paired.difference == pytest.approx(float(np.mean(means["B"] - means["A"])), rel=1e-12)


@pytest.mark.parametrize(
    ("rows", "reason"),
    [
        ([("A", "w", 1.0), ("A", "w", 1.2), ("B", "x", 2.1), ("B", "x", 2.0)], "no day holds both B and A"),
        ([("A", "w", 1.0), ("A", "w", 1.2), ("B", "w", 2.1), ("B", "x", 2.0)], "one day only holds both B and A"),
        ([("A", "w", 1.0), ("B", "w", 1.5), ("A", "x", 2.0), ("B", "x", 2.5)], "differ by as much on every day"),
    ],
)
def test_without_days_that_differ_there_is_no_paired_test(rows: Rows, reason: str) -> None:
    (paired,) = compared(rows).paired
    assert isinstance(paired.t, Undefined)
    assert reason in paired.t.reason


def test_paired_keeps_the_digits_of_decimals_at_an_offset() -> None:
    rows = [(name, day, Fraction(str(value))) for name, day, value in BALANCED]
    far = compared([(name, day, value + 10**15) for name, day, value in rows])  # type: ignore[misc]
    near = compared(rows)  # type: ignore[arg-type]
    assert (far.paired[0].t, far.paired[0].p) == (near.paired[0].t, near.paired[0].p)


@pytest.mark.soak
def test_paired_covers_where_the_few_scatter_twice_as_much_and_the_exact_test_does_not() -> None:
    """Three runs of a control of twice the scatter and ten of the treatment on each of five days."""
    rng = np.random.default_rng(20261124)
    names, days = np.tile(np.repeat(["A", "B"], [3, 10]), 5), np.repeat(np.arange(5), 13)
    draws, covered = 1500, np.zeros(2)
    for _ in range(draws):
        values = rng.normal(0.0, np.where(names == "A", 2.0, 1.0)) + rng.normal(0.0, 1.0, 5)[days]
        found = blocked_by_day(values, names, days)
        assert isinstance(found.exact, ExactTest)
        for place, contrast in enumerate((found.exact.contrasts[0], found.paired[0])):
            assert not isinstance(contrast.interval, Undefined)
            covered[place] += contrast.interval[0] <= 0.0 <= contrast.interval[1]
    exact, paired = covered / draws
    assert exact < 0.88
    assert 0.935 < paired < 0.965
