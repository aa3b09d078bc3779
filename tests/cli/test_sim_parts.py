"""`labbook sim parts`: what scenes are made of, all of it or one of them."""

from __future__ import annotations

from pathlib import Path

from simulator.declared import all_parameters
from simulator.effects.registry import EFFECTS
from tests.cli.shell import good, labbook, refused
from tests.helpers.wording import says


def test_everything_is_listed(tmp_path: Path) -> None:
    lines = good(labbook("sim", "parts", at=tmp_path)).out.splitlines()
    names = {line.split()[0] for line in lines if line}
    assert names >= {*EFFECTS, *all_parameters(), "flight", "gain", "damping_gain", "drop_height", "jumps"}
    markdown = good(labbook("sim", "parts", "--markdown", at=tmp_path)).out
    says(markdown, "k_extension", "1e+06")
    assert set(good(labbook("sim", "parts", "--json", at=tmp_path)).json) == {"effects", "parameters", "words"}


def test_one_of_them_is_told(tmp_path: Path) -> None:
    lines = good(labbook("sim", "parts", "foot_radius", at=tmp_path)).out.splitlines()
    says(lines[0], "foot_radius")
    says(lines[1], "0.001", "0.2 m", "[ground]")
    says(lines[2], "hydrostatic_stiffness", "inertial_drag", "added_mass")
    says(lines, "sim2", "0.03 m", "with the simulations", "2021")
    found = good(labbook("sim", "parts", "added_mass", "--json", at=tmp_path)).json
    assert found["kind"] == "effect"
    assert found["needs"] == [["hydrostatic_stiffness"]]
    refused(labbook("sim", "parts", "gian", at=tmp_path), 2, "did you mean 'gain'?")
