"""Figures 3.8, 3.9, 3.11, 3.12 and 3.13: the grids, and single jumps out of them."""

from __future__ import annotations

import numpy as np
import pytest

from simulator.jump import simulate
from simulator.scene import Scene
from simulator.scene_file import load_scene
from simulator.thesis.figures import Jumps, ThesisFigures, jumps_over
from tests.helpers.thesis import thesis_figures


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


def test_over_velocity_and_ground_hold_single_jumps_of_either_controller() -> None:
    figures = thesis_figures()
    speeds, ground = figures.over_velocity, figures.over_ground
    assert (ground.sigma_n_m3[8], ground.drag_scale[8]) == pytest.approx((1.2e5, 17.2), rel=1e-12)  # poppy seeds
    of_ground = {"sigma": float(ground.sigma_n_m3[3]), "b_g": float(ground.drag_scale[15])}
    for pair, place, values in (
        (speeds.jumps, (20,), {"initial_velocity": -float(speeds.touchdown_speed_m_s[20])}),
        (ground.jumps, (3, 15), of_ground),
    ):
        scene = figures.set_1.changed(values)
        assert_is_jump(pair.ad, place, scene)
        assert_is_jump(pair.ce, place, scene.changed({"b_ad": 0.0}))
        assert pair.ce.jumped.all()
        assert pair.ad.jumped.all()
    assert figures.over_damping.jumps.jumped.all()


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
