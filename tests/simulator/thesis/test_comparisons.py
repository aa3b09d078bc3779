"""Figures 3.8, 3.9, 3.11, 3.12 and 3.13: the grids, and single jumps out of them."""

from __future__ import annotations

import numpy as np
import pytest

from data_schema.errors import UnknownName, UsageError
from simulator.jump import simulate
from simulator.scene import Scene
from simulator.scene_file import load_scene
from simulator.thesis.figures import Jumps, ThesisFigures, jumps_over
from tests.helpers.thesis import thesis_figures
from tests.helpers.wording import refuses


def assert_is_jump(jumps: Jumps, place: tuple[int, ...], scene: Scene) -> None:
    jump = simulate(scene).jump
    assert jumps.jumped[place]
    assert jumps.cost_j[place] == pytest.approx(jump.cost_J, rel=1e-12)
    assert jumps.heat_j[place] == jump.stance_heat_J
    assert jumps.mechanical_j[place] == jump.stance_mechanical_J
    assert jumps.drag_j[place] == jump.stance_drag_J
    assert jumps.apex_height_m[place] == jump.apex_height_m
    assert jumps.ill_conditioned[place] == jump.ill_conditioned
    assert jumps.efficiency[place] == pytest.approx(jump.stance_mechanical_J / jump.cost_J)


def test_every_jump_of_every_figure_reaches_an_apex() -> None:
    figures = thesis_figures()
    for pair in (figures.over_velocity.jumps, figures.over_ground.jumps):
        assert pair.ce.jumped.all()
        assert pair.ad.jumped.all()
    assert figures.over_damping.jumps.jumped.all()


def test_over_velocity_holds_single_jumps() -> None:
    figures = thesis_figures()
    data = figures.over_velocity
    assert data.jumps.ce.cost_j.shape == data.touchdown_speed_m_s.shape
    scene = figures.set_1.changed({"initial_velocity": -float(data.touchdown_speed_m_s[20])})
    assert_is_jump(data.jumps.ad, (20,), scene)
    assert_is_jump(data.jumps.ce, (20,), scene.changed({"b_ad": 0.0}))


def test_over_ground_has_the_stress_first_and_poppy_seeds_in_the_middle() -> None:
    figures = thesis_figures()
    data = figures.over_ground
    assert data.jumps.ce.cost_j.shape == (data.sigma_n_m3.size, data.drag_scale.size)
    assert (data.sigma_n_m3[8], data.drag_scale[8]) == pytest.approx((1.2e5, 17.2), rel=1e-12)
    place = (3, 15)
    scene = figures.set_1.changed({"sigma": float(data.sigma_n_m3[3]), "b_g": float(data.drag_scale[15])})
    assert_is_jump(data.jumps.ad, place, scene)
    assert_is_jump(data.jumps.ce, place, scene.changed({"b_ad": 0.0}))


def test_over_damping_has_its_axes_in_the_stated_order() -> None:
    figures = thesis_figures()
    data = figures.over_damping
    shape = (len(data.stiffness_factors), len(data.drag_factors), len(data.extension_gains), len(data.foot_radii_m))
    assert data.jumps.cost_j.shape == (*shape, data.active_damping_kg_m.size)
    assert data.extension_stiffnesses_n_m == pytest.approx((835.36, 1091.36))
    scene = figures.set_2.changed(
        {"kg_scale": 0.5, "bg_scale": 2.0, "k_extension": 1091.36, "foot_radius": 0.038, "b_ad": 100.0}
    )
    assert_is_jump(data.jumps, (0, 2, 1, 1, 5), scene)
    assert np.all(data.saving[..., 0] == 0.0)
    assert data.saving[0, 2, 1, 1, 5] == pytest.approx(
        1.0 - simulate(scene).jump.cost_J / simulate(scene.changed({"b_ad": 0.0})).jump.cost_J
    )


@pytest.mark.soak
def test_the_default_accuracy_keeps_its_goal_at_every_point_of_every_figure() -> None:
    """Beside 1e-9; none differs by more, ill-conditioned or not."""
    default, fine = thesis_figures(), ThesisFigures(1e-9)

    def grids(figures: ThesisFigures) -> list[Jumps]:
        pairs = figures.over_velocity.jumps, figures.over_ground.jumps
        return [*(jumps for pair in pairs for jumps in (pair.ce, pair.ad)), figures.over_damping.jumps]

    for found, wanted in zip(grids(default), grids(fine), strict=True):
        for one, other in ((found.cost_j, wanted.cost_j), (found.apex_height_m, wanted.apex_height_m)):
            assert np.max(np.abs(one / other - 1.0)) < default.accuracy


def test_a_jump_that_reaches_no_apex_is_a_gap() -> None:
    found = jumps_over(load_scene("sim1"), {"initial_velocity": [-1.0, -2.5], "b_ad": 0.0}, 1e-6)
    assert found.jumped.tolist() == [True, False]  # at 2.5 m/s the leg folds
    for values in (found.cost_j, found.apex_height_m, found.efficiency):
        assert np.isfinite(values).tolist() == [True, False]


def test_what_a_scene_cannot_have_is_refused() -> None:
    scene = load_scene("sim1")
    with refuses(UsageError, "force_cap"):
        jumps_over(scene, {"force_cap": [70.0]}, 1e-6)
    with refuses(UnknownName, "'foot_radius'"):
        jumps_over(scene, {"foot_radus": [0.03]}, 1e-6)
    with refuses(UsageError, "outside what can"):
        jumps_over(scene, {"foot_radius": [0.03, -1.0]}, 1e-6)
