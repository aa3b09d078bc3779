import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from reports.figures.kind import svg_bytes
from reports.figures.quantiles import Quantiles, draw_quantiles
from reports.figures.residuals import Against, ResidualPlot, draw_residuals
from reports.figures.style import ONE_COLUMN_IN, TWO_COLUMNS_IN
from stats.groups.residuals import normal_quantiles, residuals_of_groups

WIDTHS = [ONE_COLUMN_IN, TWO_COLUMNS_IN]
GROUPS = {"CE": [0.151, 0.148, 0.155], "active damping 100": [0.141, 0.149], "active damping 200": [0.139]}


@pytest.fixture
def plot():
    found = residuals_of_groups(GROUPS)
    names = tuple(name for name, values in GROUPS.items() for _ in values)
    days = tuple(f"2021-06-{day:02d}" for day in range(1, 7))
    against = (Against("Controller", names), Against("Day", days), Against("Fitted apex", found.fitted, "m"))
    return ResidualPlot("Apex height", "m", found.values, against)


@pytest.mark.parametrize("width_in", WIDTHS)
def test_a_panel_for_each_thing_and_all_residuals_in_each(plot, width_in):
    figure = draw_residuals(plot, width_in)
    for axes in figure.axes:
        drawn = [y for line in axes.lines if line.get_alpha() == 0.75 for y in line.get_ydata()]
        assert sorted(drawn) == pytest.approx(sorted(1000 * value for value in plot.residuals))
    ElementTree.fromstring(svg_bytes(figure))


@pytest.mark.parametrize("width_in", WIDTHS)
def test_quantiles_in_the_unit_that_is_shown_with_line_and_band(width_in):
    found = normal_quantiles(residuals_of_groups(GROUPS))
    figure = draw_quantiles(Quantiles("Apex height", "m", found), width_in)
    (axes,) = figure.axes
    points, line = axes.lines[1], axes.lines[0]
    assert points.get_ydata() == pytest.approx(1000 * np.array(found.observed))
    assert points.get_xdata() == pytest.approx(found.expected)
    assert line.get_ydata() == pytest.approx(1000 * np.array(found.middle))
    ElementTree.fromstring(svg_bytes(figure))


@pytest.mark.parametrize("width_in", WIDTHS)
def test_residuals_without_scatter_are_drawn_at_0(width_in):
    groups = {"a": [1.0, 1.0], "b": [2.0, 2.0]}
    residuals = residuals_of_groups(groups)
    against = (Against("Group", tuple(name for name, values in groups.items() for _value in values)),)
    for figure in (
        draw_quantiles(Quantiles("Energy", "J", normal_quantiles(residuals)), width_in),
        draw_residuals(ResidualPlot("Energy", "J", residuals.values, against), width_in),
    ):
        ElementTree.fromstring(svg_bytes(figure))
