"""A platform with mass: its impacts, its limit without mass, and jumps in which the foot leaves it while it moves."""

from __future__ import annotations

import itertools
import math

import pytest

from simulator.gains import stiffness_n_m
from simulator.jump import simulate
from simulator.result import JumpResult
from simulator.scene import Scene
from simulator.scene_file import load_scene
from tests.helpers.kernels import interpreted
from tests.helpers.moving_platform import X_B, Stance
from tests.helpers.scenes import with_set

EMULATOR = load_scene("emulator")
HEAVY = EMULATOR.changed(effects_on=("platform_mass",), jumps=1)
MASSES_KG = (0.1, 0.5, 0.8)
GAINS = (100, 200, 300, 400, 500)


def jumps_of(scene: Scene, accuracy: float = 1e-9) -> tuple[JumpResult, ...]:
    """A set of effects that no shipped scene has is not worth a kernel."""
    compiled = scene.effects == EMULATOR.effects
    jumps = (simulate(scene, accuracy) if compiled else interpreted(simulate, scene, accuracy)).jumps
    assert len(jumps) == scene.jumps
    return jumps


def last(scene: Scene, accuracy: float = 1e-9) -> JumpResult:
    return jumps_of(scene, accuracy)[-1]


ALL = itertools.product(GAINS, MASSES_KG)


@pytest.mark.parametrize(
    ("gain", "mass_kg"), [one if one == (500, 0.8) else pytest.param(*one, marks=pytest.mark.soak) for one in ALL]
)
def test_mass_changes_little_and_the_book_closes(gain: float, mass_kg: float) -> None:
    """Up to 0.8 kg the apex changes by less than 1 cm, the cost by at most -8 % (scenes.md section 2)."""
    k = {"k_extension": stiffness_n_m(gain)}
    jumps = jumps_of(HEAVY.changed({**k, "platform_mass": mass_kg}, jumps=6))
    without = last(EMULATOR.changed(k, jumps=6))
    assert [jump.outcome for jump in jumps] == ["touchdown"] * 6
    assert max(abs(jump.energy_residual_J) for jump in jumps) < 5e-10
    assert jumps[-1].apex_height_m == pytest.approx(without.apex_height_m, abs=0.01)
    assert -0.085 < jumps[-1].cost_J / without.cost_J - 1.0 < 0.0


@pytest.mark.parametrize(("height_m", "mass_kg"), [(0.05, 0.1), (0.15, 0.5), (0.15, 1.0)])
def test_foot_and_platform_go_on_together(height_m: float, mass_kg: float) -> None:
    """What the impact costs, 0.5 m_f m_p / (m_f + m_p) v^2; the platform's later stops are after the apex."""
    jump = last(HEAVY.changed({"initial_height": height_m, "platform_mass": mass_kg}), 1e-10)
    foot_kg = EMULATOR["foot_mass"]
    reduced_kg, fallen = foot_kg * mass_kg / (foot_kg + mass_kg), 2.0 * 9.81 * height_m
    assert jump.mode_changes[0].after == "intruding"
    assert jump.impact_loss_J == pytest.approx(0.5 * reduced_kg * fallen, rel=1e-10)


STANDING = {
    "0.1 kg": "platform_mass=0.1",
    "0.5 kg": "platform_mass=0.5 initial_height=0.15",
    "0.8 kg": "platform_mass=0.8",
    "damped": "platform_mass=0.5 initial_height=0.15 b_ad=60",
}
_MISSED = "shortest_hold=2 "
"""A release that never comes, so that the leg's strut meets a platform that yields."""
LEAVING = {
    "at the stop, then held": (
        "platform_mass=5 platform_stiffness=150 platform_damping=15 platform_drag=0 platform_travel=0.2 "
        "k_extension=1400 b_extension=20 initial_height=0.05 b_ad=60",
        ["intruding", "flight", "jammed", "flight"],
    ),
    "met again, held, left again": (
        "platform_mass=2 platform_stiffness=60 platform_damping=1 platform_drag=46.4 platform_travel=0.4 "
        "k_extension=1091.36 initial_height=0.1 foot_mass=0.4 b_ad=60",
        ["intruding", "flight", "intruding", "jammed", "intruding", "flight"],
    ),
    "slides into its stop": (
        "platform_mass=0.5 platform_stiffness=300 platform_damping=5 platform_drag=0 platform_travel=0.2 "
        "k_extension=1091.36 initial_height=0.05 foot_mass=0.05",
        ["intruding", "jammed", "intruding", "flight"],
    ),
}


def lasting(entered: list[tuple[float, str]]) -> list[str]:
    """The modes that follow each other, without those that are left at once."""
    ends_s = [*(time_s for time_s, _ in entered[1:]), math.inf]
    modes = [mode for (time_s, mode), end_s in zip(entered, ends_s, strict=True) if end_s - time_s > 1e-9]
    return [mode for mode, _ in itertools.groupby(modes)]


def modes_of(jump: JumpResult) -> list[str]:
    return lasting([(change.time_s, change.after) for change in jump.mode_changes])


def assert_agrees(scene: Scene, tolerance: float) -> JumpResult:
    """The kernel's first jump against `solve_ivp` with equations written out anew."""
    found, other = last(scene, 1e-10), Stance(scene).run()
    assert modes_of(found) == lasting(other.modes)
    heat_j, work_j = other.spent_j
    for value, wanted in (
        (found.apex_height_m, other.y[X_B]),
        (found.liftoff_time_s, other.liftoff_s),
        (found.max_depth_m, other.deepest_m),
        (found.stance_heat_J, heat_j),
        (found.stance_mechanical_J, work_j),
        (found.impact_loss_J, other.impact_j),
    ):
        assert value == pytest.approx(float(wanted), rel=tolerance, abs=1e-12)
    assert abs(found.energy_residual_J) < 2e-10
    return found


@pytest.mark.parametrize(
    "name", [name if name in ("0.1 kg", "damped") else pytest.param(name, marks=pytest.mark.soak) for name in STANDING]
)
def test_a_second_method_gives_the_same_jump(name: str) -> None:
    assert_agrees(with_set(HEAVY, STANDING[name]), 2e-11)


@pytest.mark.parametrize("name", LEAVING)
def test_a_foot_leaves_the_moving_platform_as_by_a_second_method(name: str) -> None:
    words, modes = LEAVING[name]
    found = assert_agrees(with_set(HEAVY, _MISSED + words), 2e-9)
    assert modes_of(found) == modes
    assert ("intruding", "flight") in {(change.before, change.after) for change in found.mode_changes}
