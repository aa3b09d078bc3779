"""The figures of `labbook stats`: names as in the report, values close together far from zero, large groups."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from labbook.actions.stats.answering import Answer, Question, compare, equal
from labbook.actions.stats.figures import drawn_name, in_groups, quantiles_of, residual_plot_of
from labbook.analysis.observations import Observation, ObservationRequest, Observations, observations_of_book
from reports.figures.estimation import Estimation, EstimationGroup, draw_estimation
from reports.figures.estimation_parts import MOST_DRAWN
from reports.figures.quantiles import draw_quantiles
from reports.figures.residuals import draw_residuals
from reports.figures.style import ONE_COLUMN_IN, TWO_COLUMNS_IN
from reports.numbers import Number
from stats.groups.residuals import residuals_of_groups
from tests.helpers.books import small_book
from tests.helpers.wording import says


def table(groups: dict[str, list[Decimal | float]], unit: str = "J") -> Observations:
    rows = tuple(Observation(value, label) for label, values in groups.items() for value in values)
    return Observations("data.csv", "energy", unit, "g", next(iter(groups)), rows)


def test_groups_are_called_as_in_the_report(tmp_path: Path) -> None:
    with small_book(tmp_path).open() as book, book.reading() as connection:

        def observed(by: str | None) -> Observations:
            return observations_of_book(connection, book.store, book.configuration, ObservationRequest(by=by))

        swept, foot, day = observed(None), observed("foot"), observed("day")
    assert [drawn_name(swept, label).replace("\xa0", " ") for label in swept.labels] == ["CE", "d = 352 kg/s"]
    assert drawn_name(swept.pooled(), swept.rest) == "active damping"
    assert [drawn_name(foot, label) for label in foot.labels] == ["large foot", "small foot"]
    assert [drawn_name(day, label) for label in day.labels] == ["2021-06-14", "2021-06-16"]


def test_groups_stand_in_the_order_of_their_numbers() -> None:
    assert table({str(level): [1.0] for level in (0, 1, 10, 2)}).labels == ["0", "1", "2", "10"]
    assert table({f"foot {level}": [1.0] for level in (1, 10, 2)}).labels == ["foot 1", "foot 2", "foot 10"]


def test_of_a_large_group_a_part_of_the_same_shape_is_drawn_and_said() -> None:
    values = np.random.default_rng(1).normal(size=5 * MOST_DRAWN)
    groups = (EstimationGroup("A", tuple(values.tolist())), EstimationGroup("B", (0.0, 1.0)))
    figure = draw_estimation(Estimation("Energy", "J", groups, 0, (None, Number(0.5, "J", ci_low=0.0, ci_high=1.0))))
    drawn = [line.get_ydata() for line in figure.axes[0].lines if line.get_alpha() == 0.75]
    assert [len(part) for part in drawn] == [MOST_DRAWN, 2]
    assert (min(drawn[0]), max(drawn[0])) == (values.min(), values.max())
    shares = (0.05, 0.25, 0.5, 0.75, 0.95)
    assert np.quantile(drawn[0], shares) == pytest.approx(np.quantile(values, shares), abs=0.01)
    assert f"Of larger groups {MOST_DRAWN} values are drawn" in figure.get_suptitle()


def test_the_method_of_the_intervals_stands_above_and_names_stay_whole() -> None:
    groups = tuple(EstimationGroup(name, (1.0, 2.0, 4.0)) for name in ("b_ad_gain 0", "b_ad_gain 100", "b_ad_gain 200"))
    number = Number(0.5, "J", ci_low=0.0, ci_high=1.0)
    figure = draw_estimation(Estimation("Energy", "J", groups, 0, (None, number, number), interval="Welch's t"))
    says(figure.get_suptitle(), "mean and SD")
    says(figure.axes[1].get_ylabel().split("\n"), "b_ad_gain", "0")


@pytest.mark.parametrize("n_groups", [11, 24, pytest.param(90, marks=pytest.mark.soak)])
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


def ticks(figure: Figure) -> list[str]:
    figure.draw_without_rendering()
    return [label.get_text().replace("\xa0", " ") for label in figure.axes[0].get_xticklabels()]


def test_residuals_are_named_as_in_the_report(tmp_path: Path) -> None:
    with small_book(tmp_path).open() as book, book.reading() as connection:
        observed = observations_of_book(connection, book.store, book.configuration, ObservationRequest())
    quantiles, residuals = residual_figures(observed)
    (legend,) = quantiles.legends
    assert [text.get_text().replace("\xa0", " ") for text in legend.get_texts()] == ["CE", "d = 352 kg/s"]
    sizes = [len(line.get_xdata()) for line in quantiles.axes[0].lines if line.get_marker() in ("o", "s")]
    assert sizes == [len(observed.values(label)) for label in observed.labels]
    assert ticks(residuals)[:2] == ["CE", "d = 352 kg/s"]
    assert residuals.axes[0].get_xlabel() == "Active-damping coefficient"


def test_of_many_residuals_a_part_is_drawn_and_said() -> None:
    values = np.random.default_rng(1).normal(size=3 * MOST_DRAWN).tolist()
    for figure in residual_figures(table({"a": values, "b": values})):
        drawn = [line for line in figure.axes[0].lines if line.get_marker() in ("o", "s")]
        assert 2 * MOST_DRAWN >= sum(len(line.get_xdata()) for line in drawn) > MOST_DRAWN / 2
        assert re.search("(values|residuals) are drawn, evenly", figure.get_suptitle())
        ends = [line.get_ydata() for line in drawn]
        residuals = np.sort(np.asarray(values) - np.mean(values))
        assert np.max(np.concatenate(ends)) == pytest.approx(residuals[-1])
        assert np.min(np.concatenate(ends)) == pytest.approx(residuals[0])


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


def test_the_axis_of_differences_says_of_what_they_are() -> None:
    number = Number(0.004, "m", ci_low=0.001, ci_high=0.007)
    groups = tuple(EstimationGroup(name, (0.3, 0.31, 0.32)) for name in ("CE", "AD", "other"))
    figure = draw_estimation(Estimation("Apex height", "m", groups, 0, (None, number, number)))
    words = figure.axes[1].get_ylabel().replace("\xa0", " ").replace("\n", " ")
    says(words, "difference from CE", "95 %")


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
        key = "decisions" if by_days else "comparisons" if "comparisons" in found.data else "equivalence"
        for one, number in zip(found.data[key], drawn.differences[1:], strict=True):
            assert number is not None
            ends = next(one[name] for name in ("difference_ci", "estimate_ci") if name in one)
            assert [number.ci_low, number.ci_high] == [*ends]
