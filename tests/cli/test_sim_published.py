"""`labbook sim published`: the document in docs, what programs read, what people see."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from simulator.scene_file import load_scene
from simulator.steady.published_results import contradictions
from simulator.steady.tables import SteadyTables
from tests.cli.shell import good, labbook, refused
from tests.helpers.steady import results, steady_tables
from tests.helpers.thesis import thesis_figures

DOCUMENT = Path(__file__).parents[2] / "docs" / "published.md"


def test_the_document_is_what_the_command_writes(tmp_path: Path) -> None:
    shown = good(labbook("sim", "published", "-o", "new/published.md", at=tmp_path)).out
    assert shown.splitlines()[-1] == "new/published.md"
    assert (tmp_path / "new" / "published.md").read_bytes() == DOCUMENT.read_bytes()


@pytest.fixture
def simulated_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """What the command simulates is what its rows are compared with: that it does so is seen by the document."""

    def tables(accuracy: float, _step: object) -> SteadyTables:
        return replace(steady_tables(), accuracy=accuracy)

    monkeypatch.setattr("simulator.steady.tables.steady_tables", tables)
    monkeypatch.setattr("simulator.thesis.figures.ThesisFigures", lambda _accuracy: thesis_figures())


def test_what_programs_read(tmp_path: Path, simulated_once: None) -> None:
    found = good(labbook("sim", "published", "--json", at=tmp_path)).json
    assert found["accuracy"] == 1e-6
    for name, jumps in (("emulator", 100), ("force_plate", 80), ("bed", 1)):
        scene = load_scene(name)
        assert found[name]["scene"] == name
        assert found[name]["jumps"] == jumps
        assert list(found[name]["assumed"]) == list(scene.assumed)
        assert all(item == {"value": scene[key], "why": item["why"]} for key, item in found[name]["assumed"].items())
    tables = steady_tables()
    for row, wanted in zip(found["emulator"]["rows"], tables.emulator.rows, strict=True):
        assert (row["gain"], row["ce"]["apex_height_m"]) == (wanted.gain, wanted.ce.apex_height_m)
        assert (row["scaled_saving"], row["constant_loss"]) == (wanted.scaled_saving, wanted.constant_loss)
        assert row["yielding"]["switch_depth_m"] == wanted.yielding.switch_depth_m
    assert [row["battery_j"] for row in found["force_plate"]["rows"]] == [
        row.battery_j for row in tables.force_plate.rows
    ]
    numbers = {item["id"]: item for item in found["published"]}
    assert found["agreeing"] == sum(item["agrees"] for item in numbers.values()) == 10
    assert numbers["emu.saving_scaled"]["n_within"] == 2
    assert numbers["emu.saving_scaled"]["gains"] == [100, 200, 300, 400]
    assert not numbers["plate.slope"]["compared"]
    assert all(item["agrees"] == (item["reason"] == "") for item in numbers.values())
    for row, condition in zip(found["bed"]["rows"], tables.bed.rows, strict=True):
        assert (row["foot"], row["damping_gain"]) == (condition.foot, condition.damping_gain)
        assert (row["cost_j"], row["saving"]) == (condition.cost_j, condition.saving)
        assert (row["apex_height_m"], row["apex_gain_m"]) == (condition.apex_height_m, condition.apex_gain_m)
    for item, judged in zip(found["results"], results(), strict=True):
        assert (item["result"], item["verdict"], item["saving"]) == (judged.result.id, judged.verdict, judged.saving)
        simulated = None if judged.finding is None else judged.finding.median
        assert (item["published"], item["median"]) == (judged.result.published, simulated)
    assert len(found["contradictions"]) == len(contradictions())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--out", "published.pdf"], "--out published.pdf is no name for a document in Markdown: end it in .md."),
        (["--accuracy", "0"], "an accuracy of 0 cannot be had"),
    ],
)
def test_what_cannot_be_had_is_refused(words: list[str], said: str, tmp_path: Path) -> None:
    refused(labbook("sim", "published", *words, at=tmp_path), 2, said)
    assert list(tmp_path.iterdir()) == []
