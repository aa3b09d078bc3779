"""Why a jump is ill-conditioned: each cause is told, and without one the jump is not."""

from __future__ import annotations

from dataclasses import replace

import pytest

from simulator.jump import close_decision, grown_rounding, simulate
from simulator.scene_file import load_scene


@pytest.mark.parametrize(("name", "b_ad"), [("sim1", 0.0), ("sim1", 300.0), ("sim1", 650.0), ("sim2", 0.0)])
@pytest.mark.parametrize("accuracy", [1e-2, 1e-4, 1e-6, 1e-9])
def test_a_jump_is_ill_conditioned_where_there_is_a_cause(name: str, b_ad: float, accuracy: float) -> None:
    jump = simulate(load_scene(name).changed({"b_ad": b_ad}), accuracy).jump
    assert jump.ill_conditioned == (close_decision(jump) or grown_rounding(jump, accuracy) > 0.0)


def test_strong_sampled_damping_lets_errors_grow_and_hangs_on_no_decision() -> None:
    jump = simulate(load_scene("sim1"), 1e-6).jump
    assert not close_decision(jump)
    assert 1e-5 < grown_rounding(jump, 1e-6) < 1e-3
    assert grown_rounding(jump, 1e-2) == 0.0  # there is room for it
    assert grown_rounding(replace(jump, error_growth=1e300), 1e-6) == 1.0
