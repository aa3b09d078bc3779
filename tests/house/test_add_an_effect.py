"""docs/add-an-effect.md works by itself: its file and its test are tried in a copy of the sources."""

from __future__ import annotations

import inspect
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from simulator.effects.effect import Effect, State, no_functions
from simulator.effects.registry import EFFECTS
from simulator.kernel.composition import compose
from simulator.kernel.effect_functions import SLOTS, sorted_functions
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
"""
PULL = """
from simulator.compiled import inner
from simulator.effects.effect import MODES, BodyForce, Effect, Energy, Guard, State
from simulator.parameter import Parameter


def _functions(at):
    force, on = at("pull_force"), at("pulls")

    @inner
    def begin(p, x_b, v_b, x_f, v_f, states):
        p[on] = 1.0

    @inner
    def end(p, x_b, v_b, x_f, v_f, states):
        p[on] = 0.0

    return {
        "body_force_n": inner(lambda p, height_m, velocity_m_s, states: -p[on] * p[force]),
        "turns_guard": inner(lambda p, x_b, v_b, x_f, v_f, states: -v_b),
        "turns_happens": begin,
        "lands_guard": inner(lambda p, x_b, v_b, x_f, v_f, states: -x_f),
        "lands_happens": end,
        "clock_rate": inner(lambda p, height_m, velocity_m_s, states: 1.0),
        "clock_start": inner(lambda p, height_m, velocity_m_s: height_m),
    }


EFFECT = Effect(
    name="pull",
    meaning="a pull downward from the top of a flight to its end",
    source="none",
    parameters=(Parameter("pull_force", "robot", "N", "the pull", 0.0, 100.0, 2.0, "none"),),
    derived=("pulls",),
    body_force=BodyForce(
        loss=Energy("pull_loss", "energy that the pull takes", -1, "pull"), modes=MODES, breaks_closed_form=()
    ),
    guards=(
        Guard("turns", "-v_b", "it pulls", ("flight",)),
        Guard("lands", "-x_f", "it pulls no longer", ("flight",)),
    ),
    states=(State("clock", "s", "time since the start, and the height there", 1.0),),
    functions=_functions,
)
"""
PULLED = """
import numpy as np

from simulator.jump import JUMPS_WANTED, limits_for, parameter_row, simulate
from simulator.kernel.build import kernel_for
from simulator.kernel.rows import COLUMN, COLUMNS
from simulator.scene_file import load_scene

scene = load_scene("force_plate").changed({"initial_height": 0.1, "pull_force": 3.0}, ("pull",), jumps=2)
result = simulate(scene, 1e-9, trajectory=True)
motion = result.trajectory
for number, jump in enumerate(result.jumps):
    of_jump = motion.isel(time=motion["jump"].values == number)
    landed_m = float(of_jump["body_height"][-1])
    assert jump.outcome == "touchdown"
    assert abs(jump.pull_loss_J / (-3.0 * (jump.apex_height_m - landed_m)) - 1.0) < 1e-7
    assert abs(jump.energy_residual_J) < 1e-8 * jump.energy_at_play_J
start_m = scene["rest_length"] + scene["initial_height"]
assert abs(float(motion["clock"][0]) - start_m) < 1e-15
assert abs(float(motion["clock"][-1] - motion["time"][-1]) - start_m) < 1e-12

kernel = kernel_for(scene.effects)
limits, rows, counts = limits_for(1e-6), np.zeros((3, 1, len(COLUMNS))), np.zeros(3, np.int64)
limits[JUMPS_WANTED] = 1
nothing = np.zeros((0, 4)), np.zeros((0, 4 + 4 * kernel.composition.state_size))
kernel.batch(np.repeat(parameter_row(kernel, scene)[np.newaxis, :], 3, axis=0), limits, rows, counts, *nothing)
assert not np.isnan(rows[0, 0, COLUMN["apex_height_m"]])
assert np.array_equal(rows[0], rows[1], equal_nan=True) and np.array_equal(rows[0], rows[2], equal_nan=True)
"""
COLUMN = """
from simulator.sweep.chunks import PLACE

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
    for name, source in ((NAME, EFFECT), ("rope", ROPE), ("pull", PULL), ("gear_loss", GEAR_LOSS)):
        (effects / f"{name}.py").write_text(source, encoding="utf-8")
        text, count = re.subn(r"^( +)rail_friction,\n", rf"\g<0>\1{name},\n", registry.read_text("utf-8"), flags=re.M)
        assert count == 2  # the import and the list
        registry.write_text(text, encoding="utf-8")
    return folder


@pytest.mark.soak
def test_a_part_of_the_cost_is_one_file_too_and_a_column_is_in_sweeps(copy: Path) -> None:
    python(["-c", COSTS + COLUMN], folder=copy, NUMBA_DISABLE_JIT="1")


def test_it_passes_its_test_and_guards_and_states_give_a_fall_and_what_happens_beside(copy: Path) -> None:
    """A fall under a rope; at an apex and a landing two guards rise at one instant, and what an effect keeps is not
    that of the scene before.
    """
    function = re.findall(r"def (test_\w+)", TEST)[0]
    python(["-c", f"{TEST}\n\n{function}()\n{FALL}\n{PULLED}"], folder=copy, NUMBA_DISABLE_JIT="1")


@pytest.mark.soak
@pytest.mark.parametrize("script", [FALL, PULLED])
def test_so_they_do_compiled(script: str, copy: Path) -> None:
    python(["-c", script], folder=copy)


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
    beside = {"prepare", "body_force_n", "cap_bends", "cap_slows"}
    assert told == {name: len(arguments) for name, arguments in filled.items() if name not in beside}
    assert told.keys() - {"heat_w", "drag_w"} == SLOTS - {"cap_bends", "cap_slows"}


GROUND = EFFECTS["hydrostatic_stiffness"]
PLACES = compose(["hydrostatic_stiffness"]).position


@pytest.mark.parametrize(
    ("effect", "names"),
    [
        (replace(GROUND, guards=()), "cone_kink_guard"),
        (replace(GROUND, guards=(replace(GROUND.guards[0], name="cone"),)), "cone_guard.*cone_kink_guard"),
        (replace(GROUND, states=(State("heat", "J", "heat", 1.0),)), "cone_kink_guard of 5 .* 6 with its states"),
        (replace(GROUND, guards=(), functions=no_functions, states=(State("heat", "J", "heat", 1.0),)), "heat_rate"),
        (replace(GROUND, functions=lambda at: {"prepare": at("foot_radus")}), "foot_radius"),
        (replace(GROUND, functions=lambda at: GROUND.functions(at) | {"linear_drag_kgs": len}), "linear_drag_kg_s"),
    ],
)
def test_what_it_declares_and_what_it_gives_must_agree(effect: Effect, names: str) -> None:
    with pytest.raises(ValueError, match=f"hydrostatic_stiffness .*{names}"):
        sorted_functions(effect, PLACES.__getitem__, 6)


def test_what_it_declares_must_make_sense() -> None:
    with pytest.raises(ValueError, match=r"cone_kink.*sinking.*intruding"):
        replace(GROUND.guards[0], modes=("sinking",))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="body_height"):
        State("body_height", "m", "height", 1.0)
    with pytest.raises(ValueError, match="heat is 0"):
        State("heat", "J", "heat", 0.0)
