"""What is on record against a method at the designs that it was used on, in words."""

from __future__ import annotations

from dataclasses import replace

from labbook.presenting.report.error_rates import Use, known_error_rates
from stats.planning.recorded import weak_point
from tests.helpers.wording import says

HEAD = (
    "Simulated at the sizes and days on record nearest to these (docs/statistics.md), not every method keeps what it "
    "states whatever the standard deviations of runs and days, which so few runs do not tell. "
)


def test_what_carries_the_drain_lines_error_is_looked_up_with_and_without_it() -> None:
    """How large the error is is not known: 12 idle runs may leave all of what unequal groups do."""
    with_line = Use("difference_ci_f_then_t", (3, 10), tested=(3, 10), idle_runs=12)
    without = weak_point("difference_ci_f_then_t", (3, 10))
    assert with_line.weak_points() == (without, weak_point("difference_ci_f_then_t_shared", (3, 10), idle_runs=12))
    assert [row.method for row in with_line.weak_points()] == [with_line.method, f"{with_line.method}_shared"]
    assert replace(with_line, idle_runs=0).weak_points() == (without,)


def test_uses_are_counted_where_their_own_design_is_the_one_told() -> None:
    """Two at 3 and 10 runs, five at 10 and 40, where the F-test's choice errs less: the worst is told, for two."""
    found = {Use("f_then_t", (3, 10)): 2, Use("f_then_t", (10, 40)): 5, Use("one_way_anova", (10, 10, 10)): 1}
    says(" ".join(known_error_rates(found)).replace("\u00a0", " "), HEAD, "10", "15.6 %", "5 %", "2 uses", "5 uses")


def test_equivalence_errs_where_the_truth_lies_on_a_bound() -> None:
    """Without an effect to claim equivalence is right."""
    told = " ".join(known_error_rates({Use("equivalence", (2, 25)): 1})).replace("\u00a0", " ")
    says(told, HEAD, "25", "TOST claims equivalence", "8.2 %", "5 %", "1 use")


def test_designs_with_days_and_without_are_told_apart() -> None:
    apart = "Designs without days show what unequal standard deviations do, those with days what days do beside."
    assert known_error_rates({Use("f_then_t", (10, 33), 1, "own", tested=(10, 33)): 1})[0] == f"{HEAD}{apart}"
    assert known_error_rates({Use("f_then_t", (10, 33), tested=(10, 33)): 1})[0] == HEAD.rstrip()
