"""`labbook sim run`: numbers that others computed, what is shown, and what is refused."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from simulator.kernel.build import kernel_for
from simulator.scene_file import load_scene
from tests.cli.shell import good, labbook, process, refused
from tests.helpers.wording import says

KEYS = {
    *("outcome", "liftoff_time_s", "max_depth_m", "liftoff_body_velocity_m_s", "stance_heat_J", "stance_mechanical_J"),
    *("apex_height_m", "cost_J", "energy_residual_J", "decision_margin", "steps", "rhs_evaluations"),
    *("compile_time_s", "wall_time_s", "jumps", "assumed", "effects", "scene", "accuracy", "mode_changes"),
    "interpreted",
}
STANCE = ("liftoff_time_s", "max_depth_m", "liftoff_body_velocity_m_s", "stance_heat_J", "stance_mechanical_J")
STANCES = [
    ([], (0.313741307, 0.0707555506, 1.63822700, 26.8783689, 3.65279414)),
    (["foot_radius=0.038", "gain=400"], (0.296083120, 0.0530234419, 2.25324765, 62.4098244, 9.80272336)),
]
"""Published parameters (set 2), one stance each, as `tests/simulator/kernel/test_golden.py` has more of them."""


def simulated(at: Path, scene: str, sets: list[str], *words: str) -> Any:
    options = [word for item in sets for word in ("--set", item)]
    return good(labbook("sim", "run", "--scene", scene, *options, *words, "--json", at=at)).json


@pytest.mark.parametrize(("sets", "expected"), STANCES)
def test_published_stances(sets: list[str], expected: tuple[float, ...], tmp_path: Path) -> None:
    found = simulated(tmp_path, "sim2", sets, "--accuracy", "1e-9")
    assert set(found) >= KEYS
    assert [found[key] for key in STANCE] == pytest.approx(expected, rel=1e-7)
    assert found["cost_J"] == pytest.approx(found["stance_heat_J"] + found["stance_mechanical_J"], rel=1e-12)
    assert abs(found["energy_residual_J"]) < 1e-9 * found["cost_J"]


def test_what_a_person_sees(tmp_path: Path) -> None:
    kernel_for(load_scene("bed").effects)
    shown = good(labbook("sim", "run", "--scene", "bed", at=tmp_path)).out
    says(shown, "down again (touchdown")
    says(shown, "cost of the")
    says(shown, "kg_scale = 1.4", "0.02 m")
    assert "of compiling." in shown


def test_a_scene_of_one_s_own(tmp_path: Path) -> None:
    from simulator.scene_file import load_scene, write_scene

    (tmp_path / "mine.toml").write_text(write_scene(load_scene("sim2").changed({"b_ad": 100.0})), encoding="utf-8")
    found = simulated(tmp_path, "mine.toml", [])
    same = simulated(tmp_path, "sim2", ["b_ad=100"])
    assert found["scene"] == "mine"
    assert found["jumps"] == same["jumps"]


@pytest.mark.parametrize("kind", ["png", *(pytest.param(kind, marks=pytest.mark.soak) for kind in ("svg", "pdf"))])
def test_a_picture_of_the_motion(kind: str, tmp_path: Path) -> None:
    found = simulated(tmp_path, "sim2", [], "--plot", f"jump.{kind}")
    assert found["plot"] == f"jump.{kind}"
    assert (tmp_path / found["plot"]).stat().st_size > 5000


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--scene", "sim3"], "'sim3' is not a known scene: did you mean 'sim2'?"),
        (["--scene", "none.toml"], "there is no scene file none.toml"),
        (["--scene", "sim2", "--set", "foot_radus=0.03"], "did you mean 'foot_radius'?"),
        (["--scene", "sim2", "--set", "foot_radius=0"], "foot_radius = 0 m is outside what can be simulated"),
        (["--scene", "sim2", "--set", "kg_scale=0.01"], "K < m_a g"),
        (["--scene", "sim2", "--effects", "+torque_cap"], "cannot be on together"),
        (["--scene", "sim2", "--plot", "jump.bmp"], "--plot jump.bmp does not say which form: end it in .png, .svg"),
        (["--scene", "sim2", "--accuracy", "0"], "accuracy"),
        (["--scene", "sim2", "--accuracy", "nan"], "accuracy"),
        ([], "--scene"),
    ],
)
def test_refused_with_a_sentence(words: list[str], said: str, tmp_path: Path) -> None:
    refused(labbook("sim", "run", *words, at=tmp_path), 2, said)
    assert list(tmp_path.iterdir()) == []


def test_in_a_process_of_its_own_without_a_book(tmp_path: Path) -> None:
    first = good(process("sim", "run", "--scene", "sim2", "--json", at=tmp_path)).json
    assert first["jumps"] == simulated(tmp_path, "sim2", [])["jumps"]


def test_a_jump_under_the_grains_is_warned_of(tmp_path: Path) -> None:
    sets = ["foot_radius=0.0073", "kg_scale=1", "k_extension=5254"]
    assert simulated(tmp_path, "sim2", sets)["under_surface"]
    assert not simulated(tmp_path, "sim2", [])["under_surface"]
    words = [word for item in sets for word in ("--set", item)]
    shown = good(labbook("sim", "run", "--scene", "sim2", *words, at=tmp_path)).out
    (warning,) = [line for line in shown.splitlines() if line.startswith("warning: ")]
    says(warning, "longest leg", "0.3 m", "0.33")


def test_kernels_are_compiled_beforehand(tmp_path: Path) -> None:
    warmed = good(labbook("sim", "warm", "sim2", "--json", at=tmp_path)).json
    assert warmed["compile_time_s"]["sim2"] >= 0.0
    assert simulated(tmp_path, "sim2", [])["interpreted"] is False
    refused(labbook("sim", "warm", "sim3", at=tmp_path), 2, "sim3")
