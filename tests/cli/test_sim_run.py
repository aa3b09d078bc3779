"""`labbook sim run`: numbers that others computed, and what is shown."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from simulator.scene_file import load_scene, write_scene
from tests.cli.shell import good, labbook, process
from tests.helpers.wording import says

KEYS = {
    *("outcome", "liftoff_time_s", "max_depth_m", "liftoff_body_velocity_m_s", "stance_heat_J", "stance_mechanical_J"),
    *("apex_height_m", "cost_J", "energy_residual_J", "decision_margin", "steps", "rhs_evaluations"),
    *("compile_time_s", "wall_time_s", "jumps", "assumed", "effects", "scene", "accuracy", "mode_changes"),
    "interpreted",
}
STANCE = ("liftoff_time_s", "max_depth_m", "liftoff_body_velocity_m_s", "stance_heat_J", "stance_mechanical_J")
UNDER = ["foot_radius=0.0073", "kg_scale=1", "k_extension=5254"]


def options(sets: list[str]) -> list[str]:
    return [word for item in sets for word in ("--set", item)]


def simulated(at: Path, scene: str, sets: list[str], *words: str) -> Any:
    return good(labbook("sim", "run", "--scene", scene, *options(sets), *words, "--json", at=at)).json


def test_a_published_stance(tmp_path: Path) -> None:
    """Published parameters (set 2), as `tests/simulator/kernel/test_golden.py` has more of them."""
    found = simulated(tmp_path, "sim2", ["foot_radius=0.038", "gain=400"], "--accuracy", "1e-9")
    assert set(found) >= KEYS
    expected = (0.296083120, 0.0530234419, 2.25324765, 62.4098244, 9.80272336)
    assert [found[key] for key in STANCE] == pytest.approx(expected, rel=1e-7)
    assert found["cost_J"] == pytest.approx(found["stance_heat_J"] + found["stance_mechanical_J"], rel=1e-12)
    assert abs(found["energy_residual_J"]) < 1e-9 * found["cost_J"]


def test_a_scene_of_one_s_own(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(write_scene(load_scene("sim2").changed({"b_ad": 100.0})), encoding="utf-8")
    found = simulated(tmp_path, "mine.toml", [])
    assert found["scene"] == "mine"
    assert found["jumps"] == simulated(tmp_path, "sim2", ["b_ad=100"])["jumps"]


@pytest.mark.parametrize("kind", ["png", *(pytest.param(kind, marks=pytest.mark.soak) for kind in ("svg", "pdf"))])
def test_a_picture_of_the_motion(kind: str, tmp_path: Path) -> None:
    found = simulated(tmp_path, "sim2", [], "--plot", f"jump.{kind}")
    assert found["plot"] == f"jump.{kind}"
    assert (tmp_path / found["plot"]).stat().st_size > 5000


def test_in_a_process_of_its_own_without_a_book(tmp_path: Path) -> None:
    first = good(process("sim", "run", "--scene", "sim2", "--json", at=tmp_path)).json
    assert first["jumps"] == simulated(tmp_path, "sim2", [])["jumps"]


def test_a_jump_under_the_grains_is_warned_of(tmp_path: Path) -> None:
    assert simulated(tmp_path, "sim2", UNDER)["under_surface"]
    assert not simulated(tmp_path, "sim2", [])["under_surface"]
    shown = good(labbook("sim", "run", "--scene", "sim2", *options(UNDER), at=tmp_path)).out
    (warning,) = [line for line in shown.splitlines() if line.startswith("warning: ")]
    says(warning, "longest leg", "0.3 m", "0.33")


def test_where_nothing_is_lifted_it_is_said_what_to_change(tmp_path: Path) -> None:
    shown = good(
        labbook("sim", "run", "--scene", "sim2", *options(["kg_scale=0.1", "k_extension=400"]), at=tmp_path)
    ).out
    says(shown.splitlines()[1], "no_liftoff", "k_extension", "ground")
    assert simulated(tmp_path, "sim2", ["kg_scale=0.1", "k_extension=800"])["outcome"] == "touchdown"
    assert simulated(tmp_path, "sim2", ["kg_scale=0.3", "k_extension=400"])["outcome"] == "touchdown"


def test_kernels_are_compiled_beforehand(tmp_path: Path) -> None:
    assert good(labbook("sim", "warm", "sim2", "--json", at=tmp_path)).json["compile_time_s"]["sim2"] >= 0.0
    assert simulated(tmp_path, "sim2", [])["interpreted"] is False
