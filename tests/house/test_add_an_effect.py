"""docs/add-an-effect.md works by itself: its file and its test are tried in a copy of the sources."""

from __future__ import annotations

import inspect
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from simulator.effects.effect import Effect, Energy, State
from simulator.effects.registry import EFFECTS
from simulator.kernel.effect_functions import SLOTS, given_by
from tests.helpers.kernels import ROOT, python

DOCUMENT = (ROOT / "docs" / "add-an-effect.md").read_text(encoding="utf-8")
EFFECT, ROPE, TEST = re.findall(r"```python\n(.*?)```", DOCUMENT, re.DOTALL)
NAME = "viscous_rail"


GEAR_LOSS = """
from simulator.compiled import inner
from simulator.effects.effect import Effect, Energy

EFFECT = Effect(
    name="gear_loss",
    meaning="friction of the gears",
    source="none",
    energies=(Energy("gear", "friction of the gears", 0, "gears"),),
    functions=lambda at: {"gear_w": inner(lambda p, lever_m, speed_m_s, force_n: 0.1 * abs(force_n * speed_m_s))},
)
"""
COSTS = """
from simulator.jump import simulate
from simulator.scene_file import load_scene

jump = simulate(load_scene("sim2").changed(effects_on=["gear_loss"])).jump
without = simulate(load_scene("sim2")).jump
assert 0.0 < jump.stance_gear_J < jump.jump_gear_J
assert abs(jump.cost_J - without.cost_J - jump.stance_gear_J) < 1e-6 * jump.cost_J
"""
FALL = """
import numpy as np
from scipy.integrate import solve_ivp

from simulator.jump import simulate
from simulator.kernel.automaton import EVENTS
from simulator.scene_file import load_scene

VALUES = {"initial_height": 0.2, "rope_length": 0.33, "rope_stiffness": 60.0, "rope_damping": 20.0}
scene = load_scene("force_plate").changed(VALUES, ("rope",), jumps=1)
result = simulate(scene, 1e-11, trajectory=True)
rest_m, body_kg, foot_kg = scene["rest_length"], scene["body_mass"], scene["foot_mass"]


def rates(taut):
    def of(t, y):
        x_b, v_b, x_f, v_f, creep_m = y
        leg_n = scene["k_compression"] * (x_b - x_f - rest_m) + scene["b_compression"] * (v_b - v_f)
        rope_n = VALUES["rope_stiffness"] * (x_b - VALUES["rope_length"] - creep_m) if taut else 0.0
        return [v_b, (-leg_n - rope_n) / body_kg - 9.81, v_f, leg_n / foot_kg - 9.81, rope_n / VALUES["rope_damping"]]

    return of


def until(start_s, y, taut, event):
    event.terminal = True
    found = solve_ivp(rates(taut), (start_s, 5.0), y, "DOP853", events=event, rtol=1e-13, atol=1e-15)
    assert found.status == 1
    return found.t[-1], found.y[:, -1]


assert rest_m + 0.2 > VALUES["rope_length"]
slack = until(0.0, [rest_m + 0.2, 0.0, 0.2, 0.0, 0.0], True, lambda t, y: y[0] - VALUES["rope_length"] - y[4])
landed_s, landed = until(*slack, False, lambda t, y: y[2])
assert 0.01 < landed[4] < 0.2 and slack[0] < landed_s - 0.01
jump, motion = result.jump, result.trajectory
assert abs(jump.touchdown_time_s / landed_s - 1.0) < 1e-10
at_landing = motion.isel(time=int(np.argmax(motion["time"].values >= jump.touchdown_time_s)))
for name, value in zip(("body_height", "body_velocity", "foot_height", "foot_velocity", "rope_creep"), landed):
    assert abs(float(at_landing[name]) - value) < 1e-9, name
assert jump.outcome == "touchdown" and jump.rope_loss_J > 0.0
assert abs(jump.energy_residual_J) < 1e-9 * jump.energy_at_play_J
assert motion["rope_creep"].values[-1] > landed[4] and motion["rope_creep"].attrs["units"] == "m"
assert [event.name for event in EVENTS[-2:]] == ["rope_taut", "rope_slack"]
"""
COLUMN = """
from simulator.sweep.outputs import PLACE

assert "viscous_loss_J" in PLACE
scene = load_scene("sim2").changed(effects_on=["viscous_rail"])
assert scene["rail_viscosity"] == 0.5
assert "rail_viscosity" in scene.assumed
"""


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The sources with the document's file and another, and their lines of the registry."""
    folder = tmp_path_factory.mktemp("effect")
    for package in ("simulator", "data_schema"):
        shutil.copytree(ROOT / package, folder / package, ignore=shutil.ignore_patterns("__pycache__"))
    effects = folder / "simulator" / "effects"
    registry = effects / "registry.py"
    for name, source in ((NAME, EFFECT), ("rope", ROPE), ("gear_loss", GEAR_LOSS)):
        (effects / f"{name}.py").write_text(source, encoding="utf-8")
        text, count = re.subn(r"^( +)rail_friction,\n", rf"\g<0>\1{name},\n", registry.read_text("utf-8"), flags=re.M)
        assert count == 2  # the import and the list
        registry.write_text(text, encoding="utf-8")
    return folder


@pytest.mark.soak
def test_a_part_of_the_cost_is_one_file_too_and_a_column_is_in_sweeps(copy: Path) -> None:
    python(["-c", COSTS + COLUMN], folder=copy, NUMBA_DISABLE_JIT="1")


def test_its_guards_and_states_give_a_fall_under_a_rope(copy: Path) -> None:
    python(["-c", FALL], folder=copy, NUMBA_DISABLE_JIT="1")


@pytest.mark.soak
def test_so_they_do_compiled(copy: Path) -> None:
    python(["-c", FALL], folder=copy)


def test_its_effect_passes_its_test(copy: Path) -> None:
    function = re.findall(r"def (test_\w+)", TEST)[0]
    python(["-c", f"{TEST}\n\n{function}()"], folder=copy, NUMBA_DISABLE_JIT="1")


def test_an_effect_without_its_modes_is_refused(copy: Path, tmp_path: Path) -> None:
    shutil.copytree(copy, tmp_path, dirs_exist_ok=True)
    file = tmp_path / "simulator" / "effects" / f"{NAME}.py"
    file.write_text(re.sub(r"    body_force=.*?\n    \),\n", "", EFFECT, flags=re.S), encoding="utf-8")
    python(
        [
            "-c",
            "from simulator.kernel.composition import compose\n"
            "try:\n"
            "    compose(['rigid_ground', 'viscous_rail'])\n"
            "except ValueError as refused:\n"
            "    assert 'modes' in str(refused)\n"
            "else:\n"
            "    raise AssertionError\n",
        ],
        folder=tmp_path,
        NUMBA_DISABLE_JIT="1",
    )


def test_its_table_has_every_slot_with_its_arguments() -> None:
    filled = {
        name: tuple(inspect.signature(getattr(function, "py_func", function)).parameters)[1:]
        for effect in EFFECTS.values()
        for name, function in effect.functions(lambda name: 0).items()
        if name.removesuffix("_guard") not in {guard.name for guard in effect.guards}
    }
    told: dict[str, int] = {}
    for names, arguments in re.findall(
        r"^\| (`.*?`) \| (.*?) ?\| .* \|$", DOCUMENT.split("## Other functions")[1], re.M
    ):
        told |= dict.fromkeys(re.findall(r"`(\w+)`", names), len(arguments.split(",")) if arguments else 0)
    beside = {"prepare", "body_force_n", "cap_bends"}
    assert told == {name: len(arguments) for name, arguments in filled.items() if name not in beside}
    assert told.keys() - {"heat_w", "drag_w"} == SLOTS - {"cap_bends"}


GROUND = EFFECTS["hydrostatic_stiffness"]


@pytest.mark.parametrize(
    ("effect", "names"),
    [
        (replace(GROUND, guards=()), "cone_kink_guard"),
        (replace(GROUND, guards=(replace(GROUND.guards[0], name="cone"),)), "cone_guard.*cone_kink_guard"),
        (replace(GROUND, guards=(replace(GROUND.guards[0], modes=("sinking",)),)), "cone_kink.*sinking.*intruding"),
        (replace(GROUND, states=(State("heat", "J", "heat", 1.0),)), "heat_rate"),
        (replace(GROUND, functions=lambda at: GROUND.functions(at) | {"linear_drag_kgs": len}), "linear_drag_kg_s"),
        (replace(GROUND, energies=(*GROUND.energies, Energy("heat", "heat", 0, "heat"))), "heat_w"),
    ],
)
def test_what_it_declares_and_what_it_gives_must_agree(effect: Effect, names: str) -> None:
    with pytest.raises(ValueError, match=f"hydrostatic_stiffness .*{names}"):
        given_by(effect, lambda name: 0, 6)
