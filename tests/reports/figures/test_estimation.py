import dataclasses
import math
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from data_schema.reasons import Reason
from data_schema.vocabulary import Undefined
from reports.figures.estimation import Estimation, EstimationGroup, draw_estimation
from reports.figures.kind import svg_bytes
from reports.figures.style import ONE_COLUMN_IN
from reports.numbers import Number

NONE = Undefined(Reason.AS_SAID, said="one value")


@pytest.fixture
def five():
    rng = np.random.default_rng(3)
    groups = tuple(
        EstimationGroup(name, tuple(rng.normal(0.15, 0.002, n).tolist()))
        for name, n in zip(("0", "100", "200", "300", "400"), (10, 10, 40, 2, 1), strict=True)
    )
    number = Number(-0.001, "m", ci_low=-0.003, ci_high=0.001)
    alone = Number(-0.001, "m", ci_low=NONE, ci_high=NONE)
    differences = (None, number, number, Number(NONE, "m"), alone)
    return Estimation("Apex height", "m", groups, 0, differences, bounds=(-0.005, 0.005))


def points(axes):
    """Every value that is drawn: they are the half transparent marks."""
    return sorted(y for line in axes.lines if line.get_alpha() == 0.75 for y in line.get_ydata())


def test_every_value_and_the_differences_are_drawn_in_the_unit_that_is_shown(five):
    figure = draw_estimation(five, ONE_COLUMN_IN)
    upper, lower = figure.axes
    assert points(upper) == pytest.approx(sorted(1000 * value for group in five.groups for value in group.values))
    levels = {round(float(line.get_ydata()[0]), 9) for line in lower.lines}
    assert {-5.0, 5.0, -1.0, -3.0} <= levels
    assert len(lower.texts) == 2, "a difference that is undefined, and one without an interval, are named"
    ElementTree.fromstring(svg_bytes(figure))


def test_axes_hold_their_intervals_and_bounds(five):
    wide = Number(-0.001, "m", ci_low=-0.04, ci_high=0.035)
    lower = draw_estimation(dataclasses.replace(five, differences=(None, *[wide] * 4)), ONE_COLUMN_IN).axes[1]
    low, high = lower.get_ylim()
    assert low < -40.0
    assert high > 35.0


@pytest.mark.parametrize("values", [(), (0.1,), (0.1,) * 5])
def test_constant_empty_and_single_groups_are_drawn(values):
    groups = (EstimationGroup("CE", values), EstimationGroup("AD", (0.1, 0.1)))
    endless = Number(0.0, "J", ci_low=-math.inf, ci_high=math.inf)
    for number in (Number(NONE, "J"), endless):
        figure = draw_estimation(Estimation("Energy", "J", groups, 0, (None, number)))
        assert len(points(figure.axes[0])) == len(values) + 2
        ElementTree.fromstring(svg_bytes(figure))
