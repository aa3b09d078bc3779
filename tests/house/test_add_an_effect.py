"""docs/add-an-effect.md works by itself: its file and its test are tried in a copy of the sources."""

from __future__ import annotations

import inspect
import re
import shutil
from pathlib import Path

import pytest

from simulator.effects.registry import EFFECTS
from simulator.kernel.composition import OF_FORCE
from tests.helpers.kernels import ROOT, python

DOCUMENT = (ROOT / "docs" / "add-an-effect.md").read_text(encoding="utf-8")
EFFECT, TEST = re.findall(r"```python\n(.*?)```", DOCUMENT, re.DOTALL)
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
    for name, source in ((NAME, EFFECT), ("gear_loss", GEAR_LOSS)):
        (effects / f"{name}.py").write_text(source, encoding="utf-8")
        text, count = re.subn(r"^( +)rail_friction,\n", rf"\g<0>\1{name},\n", registry.read_text("utf-8"), flags=re.M)
        assert count == 2  # the import and the list
        registry.write_text(text, encoding="utf-8")
    return folder


@pytest.mark.soak
def test_a_part_of_the_cost_is_one_file_too_and_a_column_is_in_sweeps(copy: Path) -> None:
    python(["-c", COSTS + COLUMN], folder=copy, NUMBA_DISABLE_JIT="1")


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
    }
    told: dict[str, int] = {}
    for names, arguments in re.findall(
        r"^\| (`.*?`) \| (.*?) ?\| .* \|$", DOCUMENT.split("## Other functions")[1], re.M
    ):
        told |= dict.fromkeys(re.findall(r"`(\w+)`", names), len(arguments.split(",")) if arguments else 0)
    beside = {"prepare", "body_force_n", "cap_bends"}
    assert told == {name: len(arguments) for name, arguments in filled.items() if name not in beside}
    assert OF_FORCE - {"body_force_n"} <= told.keys()
