"""`labbook sim parts`: what scenes are made of, all of it or one of them."""

from __future__ import annotations

from pathlib import Path

from simulator.declared import all_parameters
from simulator.effects.registry import EFFECTS
from tests.cli.shell import good, labbook, refused


def test_everything_is_listed(tmp_path: Path) -> None:
    lines = good(labbook("sim", "parts", at=tmp_path)).out.splitlines()
    names = {line.split()[0] for line in lines if line}
    assert names >= {*EFFECTS, *all_parameters(), "flight", "gain", "damping_gain", "drop_height", "jumps"}
    markdown = good(labbook("sim", "parts", "--markdown", at=tmp_path)).out
    assert "| k_extension | leg | N/m | 1 | 1e+06 | stiffness of the leg in extension | every scene |" in markdown
    assert set(good(labbook("sim", "parts", "--json", at=tmp_path)).json) == {"effects", "parameters", "words"}


def test_one_of_them_is_told(tmp_path: Path) -> None:
    lines = good(labbook("sim", "parts", "foot_radius", at=tmp_path)).out.splitlines()
    assert lines[0] == "foot_radius (parameter): radius of the flat disk of the foot."
    assert lines[1] == "from 0.001 to 0.2 m, in the table [ground] of a scene's file."
    assert lines[2] == "read by hydrostatic_stiffness, inertial_drag, added_mass."
    assert "sim2: 0.03 m (published with the simulations (2021))" in lines
    found = good(labbook("sim", "parts", "added_mass", "--json", at=tmp_path)).json
    assert found["kind"] == "effect"
    assert found["needs"] == [["hydrostatic_stiffness"]]
    refused(labbook("sim", "parts", "gian", at=tmp_path), 2, "did you mean 'gain'?")
