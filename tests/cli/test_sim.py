"""`labbook sim`: accuracy, effects, figures, parts and what is published; what is refused by any of its commands."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from simulator.accuracy import study
from simulator.accuracy.methods import EULER, LABBOOK, NAMES
from simulator.declared import all_parameters
from simulator.effects.registry import EFFECTS
from simulator.scene_file import load_scene
from simulator.steady.published_results import contradictions
from simulator.steady.tables import SteadyTables
from tests.cli.shell import good, labbook, refused
from tests.helpers.accuracy_studies import quick_study
from tests.helpers.steady import results, steady_tables
from tests.helpers.thesis import thesis_figures
from tests.helpers.wording import says

FEW = [EULER, "solve_ivp RK45", LABBOOK]
PLATE = ("--scene", "force_plate", "--set", "jumps=1", "--effects", "-cost_of_whole_jump,-torque_cap")
OF_EFFECTS = "scene effects accuracy within jumps_measured full alone stay smallest_set effects_left_out change"
WANTED = ("3.2", "3.4")
DOCUMENT = Path(__file__).parents[2] / "docs" / "published.md"


def test_accuracy_of_a_scene_of_one_s_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study, "accuracy_study", lambda scene, *_: quick_study(scene, FEW)[0])  # the same, uncompiled
    words = ("--scene", "sim2", "--set", "foot_radius=0.0351", "--quick", "--plot", "costs.png", "--json")
    found = good(labbook("sim", "accuracy", *words, at=tmp_path)).json
    assert found["reference"]["stored"] is False
    assert (found["values"]["foot_radius"], found["plot"]) == (0.0351, "costs.png")
    assert (tmp_path / "costs.png").stat().st_size > 10_000
    assert [method["method"] for method in found["methods"]] == FEW
    for point in (point for method in found["methods"] for point in method["points"]):
        assert set(point["errors"]) == set(NAMES)
        assert point["seconds"] > 0.0
    assert {need["goal"] for need in found["needs"]} == {1e-2, 1e-6}


def test_effects_as_data_and_as_words_that_simulate_so(tmp_path: Path) -> None:
    words = ("sim", "effects", *PLATE, "--within", "2%")
    found = good(labbook(*words, "--json", at=tmp_path)).json
    assert set(found) >= set(OF_EFFECTS.split())
    assert found["within"] == 0.02
    alone = {item["without"][0]: item for item in found["alone"]}
    assert {*alone, *found["stay"]} == {*found["smallest_set"], *found["effects_left_out"]} == set(found["effects"])
    assert alone["leg_damping"]["cost"] is None
    assert "leg_straight" in alone["leg_damping"]["undefined"]
    shown = good(labbook(*words, at=tmp_path)).out
    assert f"--effects {','.join(f'-{name}' for name in found['effects_left_out'])}" in shown


def test_a_foot_in_grains_as_data_and_as_words(tmp_path: Path) -> None:
    few = ("--seeds", "2", "--diameter", "0.02", "--grain", "width=0.12", "--grain", "depth=0.14")
    words = ("sim", "grains", "--scene", "sim1", *few)
    found = good(labbook(*words, "--plot", "grains.png", "--json", at=tmp_path)).json
    assert [bed["seed"] for bed in found["beds"]] == [0, 1]
    for bed in found["beds"]:
        assert bed["peak_ratio"] == pytest.approx(bed["ce"]["peak_extension_J"] / bed["ad"]["peak_extension_J"])
        assert bed["ce"]["peak_extension_J"] > bed["ad"]["peak_extension_J"]
    assert found["bulk"]["ce"]["extension_work_J"] > found["bulk"]["ad"]["extension_work_J"]
    with Image.open(tmp_path / "grains.png") as image:
        assert image.width > 1000
    shown = good(labbook(*words, at=tmp_path)).out
    assert says(shown, "20 mm", "CE", "AD", "±", "2 beds", "one-way", "assumed", "closes")
    assert "--seeds 3" in good(labbook(*words, "--seeds", "1", at=tmp_path)).out
    refused(labbook("sim", "grains", "--scene", "bed", at=tmp_path), 2, "b_ad", "damping_gain")


def figures(at: Path, *words: str) -> Any:
    only = [word for number in WANTED for word in ("--only", number)]
    return good(labbook("sim", "figures", *only, *words, "--json", at=at)).json


def test_figures_that_are_asked_for_are_written(tmp_path: Path) -> None:
    found = figures(tmp_path, "--out", "paper")
    assert [item["number"] for item in found["figures"]] == list(WANTED)
    for item in found["figures"]:
        with Image.open(tmp_path / item["file"]) as picture:
            assert (picture.format, picture.width) == ("PNG", 2160)  # 7.2 inches
    written = {str(path.relative_to(tmp_path)) for path in (tmp_path / "paper").iterdir()}
    assert written == {*(item["file"] for item in found["figures"]), found["captions"], *found["tables"]}
    captions = (tmp_path / found["captions"]).read_text(encoding="utf-8")
    assert all(Path(item["file"]).name in captions for item in found["figures"])
    assert all(not set(WANTED).isdisjoint(claim["figures"]) for claim in found["claims"])
    assert found["agreeing"] == sum(claim["agrees"] for claim in found["claims"])
    table = (tmp_path / "paper" / "claims.csv").read_text(encoding="utf-8").splitlines()
    assert len(table) == 1 + len(found["claims"])


@pytest.mark.soak
def test_figures_for_a_paper_have_the_same_bytes_twice(tmp_path: Path) -> None:
    one, two = (figures(tmp_path, "--out", folder, "--format", "pdf")["figures"] for folder in ("one", "two"))
    for first, second in zip(one, two, strict=True):
        content = (tmp_path / first["file"]).read_bytes()
        assert content.startswith(b"%PDF")
        assert content == (tmp_path / second["file"]).read_bytes()


def test_parts_are_listed_and_one_of_them_is_told(tmp_path: Path) -> None:
    lines = good(labbook("sim", "parts", at=tmp_path)).out.splitlines()
    names = {line.split()[0] for line in lines if line}
    assert names >= {*EFFECTS, *all_parameters(), "flight", "gain", "damping_gain", "drop_height", "jumps"}
    says(good(labbook("sim", "parts", "--markdown", at=tmp_path)).out, "k_extension", "1e+06")
    assert set(good(labbook("sim", "parts", "--json", at=tmp_path)).json) == {"effects", "parameters", "words"}
    told = good(labbook("sim", "parts", "foot_radius", at=tmp_path)).out
    says(told, "0.001", "0.2 m", "[ground]")
    says(told, "hydrostatic_stiffness", "inertial_drag", "added_mass")
    says(told, "sim2", "0.03 m", "with the simulations", "2021")
    found = good(labbook("sim", "parts", "added_mass", "--json", at=tmp_path)).json
    assert (found["kind"], found["needs"]) == ("effect", [["hydrostatic_stiffness"]])


def test_the_document_of_what_is_published_is_what_the_command_writes(tmp_path: Path) -> None:
    shown = good(labbook("sim", "published", "-o", "new/published.md", at=tmp_path)).out
    assert shown.splitlines()[-1] == "new/published.md"
    assert (tmp_path / "new" / "published.md").read_bytes() == DOCUMENT.read_bytes()


def assert_as(rows: list[dict[str, Any]], wanted: Any, names: str) -> None:
    """Each row has the fields of what was simulated."""
    expected = [{name: getattr(one, name) for name in names.split()} for one in wanted]
    assert [{name: row[name] for name in names.split()} for row in rows] == expected


def test_what_is_published_as_data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its simulations are those of the tests: that the command simulates so is seen by the document."""

    def simulated(accuracy: float, _step: object) -> SteadyTables:
        return replace(steady_tables(), accuracy=accuracy)

    monkeypatch.setattr("simulator.steady.tables.steady_tables", simulated)
    monkeypatch.setattr("simulator.thesis.figures.ThesisFigures", lambda _accuracy: thesis_figures())
    found = good(labbook("sim", "published", "--json", at=tmp_path)).json
    assert found["accuracy"] == 1e-6
    for name, jumps in (("emulator", 100), ("force_plate", 80), ("bed", 1)):
        scene, shown = load_scene(name), found[name]
        assert (shown["scene"], shown["jumps"], list(shown["assumed"])) == (name, jumps, list(scene.assumed))
        assert all(item == {"value": scene[key], "why": item["why"]} for key, item in shown["assumed"].items())
    tables = steady_tables()
    assert_as(found["emulator"]["rows"], tables.emulator.rows, "gain scaled_saving constant_loss")
    apexes_m = [row.ce.apex_height_m for row in tables.emulator.rows]
    assert [row["ce"]["apex_height_m"] for row in found["emulator"]["rows"]] == apexes_m
    assert_as(found["force_plate"]["rows"], tables.force_plate.rows, "battery_j")
    assert_as(found["bed"]["rows"], tables.bed.rows, "foot damping_gain cost_j saving apex_height_m apex_gain_m")
    numbers = {item["id"]: item for item in found["published"]}
    assert found["agreeing"] == sum(item["agrees"] for item in numbers.values()) == 10
    assert numbers["emu.saving_scaled"]["n_within"] == 2
    assert numbers["emu.saving_scaled"]["gains"] == [100, 200, 300, 400]
    assert not numbers["plate.slope"]["compared"]
    assert all(item["agrees"] == (item["reason"] == "") for item in numbers.values())
    assert_as(found["results"], results(), "verdict saving")
    for item, judged in zip(found["results"], results(), strict=True):
        assert (item["result"], item["published"]) == (judged.result.id, judged.result.published)
        assert item["median"] == (None if judged.finding is None else judged.finding.median)
    assert len(found["contradictions"]) == len(contradictions())
    assert list(tmp_path.iterdir()) == []


SWEEP = "sweep --scene sim2 --out a.nc --over"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("run", "--scene"),
        ("run --scene sim3", "'sim3' is not a known scene: did you mean 'sim2'?"),
        ("run --scene none.toml", "there is no scene file none.toml"),
        ("run --scene sim2 --set foot_radus=0.03", "did you mean 'foot_radius'?"),
        ("run --scene sim2 --set foot_radius=0", "foot_radius = 0 m is outside what can be simulated"),
        ("run --scene sim2 --effects +torque_cap", "cannot be on together"),
        ("run --scene sim2 --plot jump.bmp", "--plot jump.bmp does not say which form: end it in .png, .svg"),
        ("run --scene sim2 --accuracy nan", "accuracy"),
        ("effects --scene sim2 --within much", "is no share above 0"),
        ("effects --scene sim2 --effects +dragg", "did you mean 'drag'?"),
        ("figures --only 3.7", "'3.7' is no figure of ch. 3 that a simulation makes: give one of 3.2, 3.4"),
        ("figures --format jpg", "'jpg' is not a known format"),
        ("parts gian", "did you mean 'gain'?"),
        ("published --out published.pdf", "--out published.pdf is no name for a document in Markdown: end it in .md."),
        ("published --accuracy 0", "an accuracy of 0 cannot be had"),
        ("sweep --scene sim2 --over b_ad=0:300:3", "--out"),
        ("sweep --scene sim2 --out a.nc", "--over"),
        ("sweep --scene sim2 --over b_ad=0:300:3 --out a.csv", "end it in .nc or .zarr"),
        ("sweep --scene sim2 --over b_ad=0,1 --out none/a.nc", "there is no folder none"),
        (f"{SWEEP} b_ad=-5:300:3", "b_ad = -5 kg/m is outside what can be simulated"),
        (f"{SWEEP} ad_share=0.1,0.2", "ad_share would change nothing"),
        (f"{SWEEP} drag_area=0:1:3", "drag_area would change nothing"),
        (f"{SWEEP} b_ad=0,1 --set b_ad=3", "b_ad is both set and swept"),
        (f"{SWEEP} b_ad=0,1 --seed 3", "add --sobol"),
        (f"{SWEEP} b_ad=0,1 --accuracy 0", "accuracy"),
        (f"{SWEEP} b_ad=0,1 --error-bars --accuracy 1e-13", "for no error bars"),
    ],
)
def test_refused_with_a_sentence_before_anything_is_written(words: str, said: str, tmp_path: Path) -> None:
    refused(labbook("sim", *words.split(), at=tmp_path), 2, said)
    assert list(tmp_path.iterdir()) == []
