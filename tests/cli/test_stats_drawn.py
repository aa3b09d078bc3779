"""The figures of `labbook stats`: names as in the report, values close together far from zero, large groups."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from decimal import Decimal

import pytest
from matplotlib.figure import Figure

from labbook.actions.stats.answering import Answer, Question, compare, equal
from labbook.actions.stats.figures import drawn_name, in_groups, quantiles_of, residual_plot_of
from labbook.analysis.observations import Observation, Observations
from reports.figures.estimation import Estimation, EstimationGroup, draw_estimation
from reports.figures.quantiles import draw_quantiles
from reports.figures.residuals import draw_residuals
from reports.figures.style import ONE_COLUMN_IN, TWO_COLUMNS_IN
from reports.numbers import Number
from stats.groups.residuals import residuals_of_groups


def table(groups: dict[str, list[Decimal | float]], unit: str = "J") -> Observations:
    rows = tuple(Observation(value, label) for label, values in groups.items() for value in values)
    return Observations("data.csv", "energy", unit, "g", next(iter(groups)), rows)


@pytest.mark.parametrize("n_groups", [11, 24])
def test_counts_of_many_groups_do_not_touch(n_groups: int) -> None:
    groups = tuple(EstimationGroup(str(level), (1.0, 2.0)) for level in range(n_groups))
    number = Number(0.5, "J", ci_low=0.0, ci_high=1.0)
    differences = (None, *(number,) * (n_groups - 1))
    figure = draw_estimation(Estimation("Energy", "J", groups, 0, differences), TWO_COLUMNS_IN)
    figure.draw_without_rendering()
    boxes = [label.get_window_extent() for label in figure.axes[1].get_xticklabels() if label.get_text()]
    assert all(left.x1 < right.x0 for left, right in itertools.pairwise(boxes))


def residual_figures(observed: Observations) -> list[Figure]:
    drawn = in_groups(observed)
    found = residuals_of_groups({label: drawn.values(label) for label in drawn.labels})
    return [draw_quantiles(quantiles_of(drawn, found, 0.95)), draw_residuals(residual_plot_of(drawn, found))]


def test_long_names_leave_room_for_the_values() -> None:
    figures = residual_figures(table({"a" * 70: [1.0, 2.0], "b": [2.0, 4.0]}))
    number = Number(0.5, "J", ci_low=0.0, ci_high=1.0)
    observed = table({"a" * 70: [1.0, 2.0], "b": [2.0, 4.0]})
    groups = tuple(EstimationGroup(drawn_name(observed, name), (1.0, 2.0)) for name in ("a" * 70, "b"))
    figures.append(draw_estimation(Estimation("Energy", "J", groups, 0, (None, number)), ONE_COLUMN_IN))
    for figure in figures:
        figure.draw_without_rendering()
        box = figure.axes[0].get_window_extent()
        assert box.height > 100.0
        labels = [label.get_window_extent() for label in figure.axes[0].get_xticklabels() if label.get_text()]
        assert all(label.y0 >= 0.0 for label in labels)


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
