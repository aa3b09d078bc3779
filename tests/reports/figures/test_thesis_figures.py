"""The drawings of ch. 3's figures: what is simulated, labelled; and what they show of made-up numbers."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from labbook.actions.simulate.thesis_figures import THESIS_FIGURES
from reports.figures.kind import svg_bytes
from reports.figures.style import TWO_COLUMNS_IN
from reports.figures.thesis_comparisons import APEX, COST, Compared, draw_over_grounds, draw_over_speed
from simulator.thesis.figures import Jumps, OverGround, OverVelocity, Pair
from tests.helpers.thesis import thesis_figures

SPEED = np.linspace(0.2, 2.0, 7)
STRESS, DRAG = 1.2e5 * np.array([0.5, 1.0, 2.0]), 17.2 * np.array([0.5, 1.0, 2.0])


def jumps(values: np.ndarray, scale: float) -> Jumps:
    jumped = np.isfinite(values)
    heat_j = np.where(jumped, 30.0 * scale, np.nan)
    return Jumps(jumped, ~jumped, heat_j, scale * values, np.zeros(values.shape), 0.3 + 0.001 * values / scale)


def over_ground(ce: Jumps, ad: Jumps) -> OverGround:
    return OverGround(STRESS, DRAG, 1.2e5, 17.2, Pair(ce, ad))


OVER_SPEED = OverVelocity(SPEED, Pair(jumps(SPEED, 1.0), jumps(SPEED, 0.8)))
GRID = STRESS[:, np.newaxis] / 1.2e5 + DRAG / 17.2
GROUNDS = over_ground(jumps(GRID, 1.0), jumps(GRID, 0.8))
OF_APEXES = ("3.9", "3.12")
"""Drawn as the cost is, in the figure before each."""


@pytest.mark.parametrize(
    "number", [pytest.param(number, marks=pytest.mark.soak if number in OF_APEXES else ()) for number in THESIS_FIGURES]
)
def test_every_figure_has_its_width_and_labels_with_units(number: str) -> None:
    figure = THESIS_FIGURES[number].draw(thesis_figures())
    figure.draw_without_rendering()  # a layout that finds no room warns, and a warning fails
    assert figure.get_size_inches()[0] == TWO_COLUMNS_IN
    labels = [axes.get_xlabel() for axes in figure.axes] + [axes.get_ylabel() for axes in figure.axes]
    assert all("(" in label for label in labels if label and label != "Drag scale b_g")
    assert len([label for label in labels if label]) >= 2


def test_the_difference_is_a_share_of_what_compression_extension_needs() -> None:
    none = np.zeros(2, np.bool_)
    compared = Compared("Cost", "Cost (J)", np.array([30.0, 20.0]), np.array([24.0, 25.0]), none, none)
    assert compared.share_percent == pytest.approx([20.0, -25.0])
    figure = draw_over_speed(OVER_SPEED, COST)
    share = figure.axes[2].get_lines()[0]
    assert share.get_ydata() == pytest.approx(np.full(SPEED.size, 20.0))


def test_maps_of_both_controllers_have_one_scale_and_a_difference_of_both_signs_has_white_at_0() -> None:
    figure = draw_over_grounds(GROUNDS, APEX)
    ce, ad, difference = (axes.collections[0] for axes in figure.axes[:3])
    assert ce.get_clim() == ad.get_clim()
    assert difference.get_cmap().name == "viridis"  # all of one sign
    mixed = over_ground(jumps(GRID, 1.0), jumps(4.0 - GRID, 1.0))
    difference = draw_over_grounds(mixed, APEX).axes[2].collections[0]
    assert difference.get_cmap().name == "PuOr"
    assert difference.norm(np.zeros(1)) == 0.5


def test_a_jump_that_is_missing_leaves_a_gap() -> None:
    broken = jumps(np.where(SPEED > 1.5, np.nan, SPEED), 1.0)
    figure = draw_over_speed(OverVelocity(SPEED, Pair(broken, jumps(SPEED, 0.8))), COST)
    assert np.isnan(figure.axes[0].get_lines()[0].get_ydata()).sum() == (SPEED > 1.5).sum()
    ElementTree.fromstring(svg_bytes(figure))
