"""The figures of `labbook stats` draw the intervals that decide."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from labbook.actions.stats.answering import Answer, Question, compare, equal
from labbook.analysis.observations import Observation, Observations


@pytest.mark.parametrize("asked", [lambda it: compare(it, None), lambda it: equal(it, (-9, 9, False))])
def test_where_days_decide_their_intervals_are_drawn(asked: Callable[[Question], Answer]) -> None:
    values = {"a": (1.0, 2.0, 4.0, 3.0), "b": (2.0, 4.0, 5.0, 6.0), "c": (3.0, 5.0, 9.0, 7.0)}
    rows = [(label, place, value) for label, column in values.items() for place, value in enumerate(column)]
    days = tuple(Observation(value, label, f"2021-06-1{place}") for label, place, value in rows)
    none = tuple(Observation(value, label) for label, _place, value in rows)
    for cells, by_days in ((days, True), (none, False)):
        observed = Observations("data.csv", "energy", "J", "g", "a", cells)
        found = asked(Question(observed, "refuse", 0.05))
        drawn = found.drawn()
        assert ("by shared days" in drawn.interval) is by_days
        key = "decisions" if "decisions" in found.data else "comparisons"
        for one, number in zip(found.data[key], drawn.differences[1:], strict=True):
            assert number is not None
            ends = next(one[name] for name in ("difference_ci", "estimate_ci") if name in one)
            assert [number.ci_low, number.ci_high] == [*ends]
