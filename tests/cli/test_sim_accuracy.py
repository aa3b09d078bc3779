"""`labbook sim accuracy`: table, sentences, JSON, figure, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from simulator.accuracy import study
from simulator.accuracy.methods import EULER, LABBOOK, NAMES
from tests.cli.shell import good, labbook, refused
from tests.helpers.accuracy_studies import quick_study

FEW = [EULER, "solve_ivp RK45", LABBOOK]


def test_json_and_figure_of_a_scene_of_one_s_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study, "accuracy_study", lambda scene, *_: quick_study(scene, FEW)[0])  # the same, uncompiled
    words = ("--scene", "sim2", "--set", "foot_radius=0.0351", "--quick", "--plot", "costs.png", "--json")
    found = good(labbook("sim", "accuracy", *words, at=tmp_path)).json
    assert found["reference"]["stored"] is False
    assert found["values"]["foot_radius"] == 0.0351
    assert found["plot"] == "costs.png"
    assert (tmp_path / "costs.png").stat().st_size > 10_000
    assert [method["method"] for method in found["methods"]] == FEW
    for method in found["methods"]:
        for point in method["points"]:
            assert set(point["errors"]) == set(NAMES)
            assert point["seconds"] > 0.0
    assert {need["goal"] for need in found["needs"]} == {1e-2, 1e-6}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--scene", "sim3"], "did you mean 'sim2'?"),
        (["--scene", "sim2", "--set", "foot_radus=0.03"], "did you mean 'foot_radius'?"),
        (["--scene", "sim2", "--plot", "costs.bmp"], "--plot costs.bmp does not say which form: end it in .png, .svg"),
        ([], "--scene"),
    ],
)
def test_refused_with_a_sentence(words: list[str], said: str, tmp_path: Path) -> None:
    refused(labbook("sim", "accuracy", *words, at=tmp_path), 2, said)
    assert list(tmp_path.iterdir()) == []
