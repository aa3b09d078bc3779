"""The drawings of ch. 3's figures, from made-up numbers: what they show, at both widths of a paper."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree
from collections.abc import Callable

import numpy as np
import pytest
from matplotlib.figure import Figure

from reports.figures.kind import svg_bytes
from reports.figures.style import TWO_COLUMNS_IN
from reports.figures.thesis_comparisons import (
    APEX,
    COST,
    Compared,
    draw_joules_by_damping,
    draw_over_grounds,
    draw_over_speed,
)
from reports.figures.thesis_jumps import draw_body_and_toe, draw_energies, draw_ground_functions, draw_power_surface
from simulator.thesis.figures import (
    GroundFunctions,
    JumpEnergies,
    Jumps,
    Motion,
    OverDamping,
    OverGround,
    OverVelocity,
    Pair,
    PowerSurface,
)

DEPTH = np.linspace(0.0, 0.08, 9)
TIME = np.linspace(0.0, 0.5, 51)
SPEED = np.linspace(0.2, 2.0, 7)
STRESS, DRAG = 1.2e5 * np.array([0.5, 1.0, 2.0]), 17.2 * np.array([0.5, 1.0, 2.0])


def path(deepest_m: float) -> Motion:
    toe, none = -deepest_m * np.sin(2.0 * np.pi * TIME), np.zeros_like(TIME)
    return Motion(
        time_s=TIME,
        body_height_m=0.2 + 0.1 * np.cos(9.0 * TIME),
        body_velocity_m_s=none,
        foot_height_m=toe,
        foot_velocity_m_s=np.gradient(toe, TIME),
        body_acceleration_m_s2=none,
        leg_work_j=none,
        ground_loss_j=none,
        grain_energy_j=none,
        extending=TIME > 0.2,
        flying=TIME > 0.3,
        switch_time_s=0.2,
        liftoff_time_s=0.3,
        jams=1,
    )


def energies(scale: float) -> JumpEnergies:
    return JumpEnergies(path(0.06), *(scale * np.cos(place + 5.0 * TIME) for place in range(7)))


def jumps(values: np.ndarray, scale: float) -> Jumps:
    jumped = np.isfinite(values)
    heat_j = np.where(jumped, 30.0 * scale, np.nan)
    return Jumps(jumped, ~jumped, heat_j, scale * values, np.zeros(values.shape), 0.3 + 0.001 * values / scale)


def over_ground(ce: Jumps, ad: Jumps) -> OverGround:
    return OverGround(STRESS, DRAG, 1.2e5, 17.2, Pair(ce, ad))


PATHS = Pair(path(0.06), path(0.04))
OVER_SPEED = OverVelocity(SPEED, Pair(jumps(SPEED, 1.0), jumps(SPEED, 0.8)))
GRID = STRESS[:, np.newaxis] / 1.2e5 + DRAG / 17.2
GROUNDS = over_ground(jumps(GRID, 1.0), jumps(GRID, 0.8))
COSTS = OverDamping(
    jumps(30.0 - np.arange(2 * 3 * 2 * 2 * 6).reshape(2, 3, 2, 2, 6) / 4.0, 1.0),
    (0.5, 1.0),
    (0.5, 1.0, 2.0),
    (300.0, 400.0),
    (0.03, 0.051),
    np.linspace(0.0, 500.0, 6),
)
GROUND = GroundFunctions(DEPTH, 800 * DEPTH, 50 + DEPTH, 2 * DEPTH, 0.026)
SURFACE_W = np.outer(np.linspace(-500.0, 0.0, 13), 0.1 + DEPTH)
POWER = PowerSurface(DEPTH, np.linspace(-1.2, 0.0, 13), SURFACE_W, (PATHS,))
DRAWN: dict[str, Callable[[], Figure]] = {
    "3.2": lambda: draw_ground_functions(GROUND),
    "3.4": lambda: draw_body_and_toe(PATHS),
    "3.5": lambda: draw_energies(Pair(energies(5.0), energies(4.0))),
    "3.6": lambda: draw_power_surface(POWER),
    "3.8": lambda: draw_over_speed(OVER_SPEED, COST),
    "3.9": lambda: draw_over_speed(OVER_SPEED, APEX),
    "3.11": lambda: draw_over_grounds(GROUNDS, COST),
    "3.12": lambda: draw_over_grounds(GROUNDS, APEX),
    "3.13": lambda: draw_joules_by_damping(COSTS),
}
OF_APEXES = ("3.9", "3.12")
"""Drawn as the cost is, in the figure before each."""


@pytest.mark.parametrize(
    "number", [pytest.param(number, marks=pytest.mark.soak if number in OF_APEXES else ()) for number in DRAWN]
)
def test_every_figure_has_its_width_and_labels_with_units(number: str) -> None:
    figure = DRAWN[number]()
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
