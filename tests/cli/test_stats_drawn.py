"""The figures of `labbook stats`: names as in the report, values close together far from zero, large groups."""

from __future__ import annotations

import itertools
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest

from labbook.analysis.observations import Asked, Observation, Observations, observations_of_book
from labbook.presenting.stats_figures import estimation_of, number_of
from labbook.presenting.stats_names import drawn_name
from reports.figures.estimation import Estimation, EstimationGroup, draw_estimation
from reports.figures.estimation_parts import MOST_DRAWN
from reports.figures.style import TWO_COLUMNS_IN
from reports.numbers import Number
from tests.helpers.books import small_book


def table(groups: dict[str, list[Decimal | float]], unit: str = "J") -> Observations:
    rows = tuple(Observation(value, label) for label, values in groups.items() for value in values)
    return Observations("data.csv", "energy", unit, "g", next(iter(groups)), rows)


def test_groups_are_called_as_in_the_report(tmp_path: Path) -> None:
    with small_book(tmp_path).open() as book, book.reading() as connection:

        def observed(by: str | None) -> Observations:
            return observations_of_book(connection, book.store, book.configuration, Asked(by=by))

        swept, foot, day = observed(None), observed("foot"), observed("day")
    assert [drawn_name(swept, label).replace("\xa0", " ") for label in swept.labels] == ["CE", "d = 351.7 kg/s"]
    assert drawn_name(swept.pooled(), swept.rest) == "active damping"
    assert [drawn_name(foot, label) for label in foot.labels] == ["large foot", "small foot"]
    assert [drawn_name(day, label) for label in day.labels] == ["2021-06-14", "2021-06-16"]


def test_groups_stand_in_the_order_of_their_numbers() -> None:
    assert table({str(level): [1.0] for level in (0, 1, 10, 2)}).labels == ["0", "1", "2", "10"]
    assert table({f"foot {level}": [1.0] for level in (1, 10, 2)}).labels == ["foot 1", "foot 2", "foot 10"]


@pytest.mark.parametrize(
    ("low", "step", "said", "unit"),
    [
        (Decimal(2**60), Decimal("0.001"), "Energy less 1.152921504606847e+18 J", "J"),
        (Decimal(0), Decimal("1e-320"), "Energy", "10^-319 J"),
        (Decimal(2), Decimal("0.001"), "Energy", "J"),
    ],
)
def test_an_axis_shows_the_spread_of_values(low: Decimal, step: Decimal, said: str, unit: str) -> None:
    groups = {name: [low + step * place for place in places] for name, places in (("A", (0, 3)), ("B", (5, 10)))}
    observed = table(groups)  # type: ignore[arg-type]
    found = estimation_of(observed, {"B": number_of(float(6 * step), (float(step), float(11 * step)), 0.95, "J")})
    assert (found.quantity, found.unit) == (said, unit)
    drawn = [value for group in found.groups for value in group.values]
    assert (np.diff(drawn) / (drawn[-1] - drawn[0])).tolist() == pytest.approx([0.3, 0.2, 0.5])
    number = found.differences[1]
    assert number is not None
    assert number.unit == unit
    assert number.value == pytest.approx(0.6 * (drawn[-1] - drawn[0]), rel=1e-4)  # 6e-320 itself is that coarse
    low_end, high_end = draw_estimation(found).axes[0].get_ylim()
    assert drawn[-1] - drawn[0] > 0.3 * (high_end - low_end)


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
    assert figure.get_suptitle() == "Gapped line: mean and SD. Interval: Welch's t."
    assert "b_ad_gain\xa00" in figure.axes[1].get_ylabel()


@pytest.mark.parametrize("n_groups", [11, 16, 24])
def test_counts_of_many_groups_do_not_touch(n_groups: int) -> None:
    groups = tuple(EstimationGroup(str(level), (1.0, 2.0)) for level in range(n_groups))
    number = Number(0.5, "J", ci_low=0.0, ci_high=1.0)
    differences = (None, *(number,) * (n_groups - 1))
    figure = draw_estimation(Estimation("Energy", "J", groups, 0, differences), TWO_COLUMNS_IN)
    figure.draw_without_rendering()
    boxes = [label.get_window_extent() for label in figure.axes[1].get_xticklabels()]
    assert all(left.x1 < right.x0 for left, right in itertools.pairwise(boxes))
