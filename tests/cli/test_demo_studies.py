"""`labbook demo --study`: books of studies that are kept as sheets, whose truth the study finds again."""

from __future__ import annotations

import hashlib
import html
import json
import re
import shlex
from pathlib import Path
from typing import Any

import pytest

from labbook.config.studies import STUDIES
from tests.cli.shell import good, labbook, refused
from tests.helpers.folders import contents
from tests.helpers.study_pages import prints_page_one_on_a_sheet


def made(tmp_path: Path, study: str) -> tuple[dict[str, float], Any]:
    """The truth of a demonstration, and what the command that it names says as JSON."""
    tmp_path.mkdir(exist_ok=True)
    done = good(labbook("demo", "--study", study, "--seed", "3", "--json", str(tmp_path / "a demo"), at=tmp_path)).json
    truth = json.loads(Path(done["truth"]).read_text(encoding="utf-8"))
    return truth, good(labbook(*shlex.split(done["next"])[1:], "--json", at=tmp_path)).json


def test_flasks_and_walks_lead_to_the_numbers_that_they_were_drawn_with(tmp_path: Path) -> None:
    truth, found = made(tmp_path / "flasks", "compaction")
    for state in found["states"]:
        assert state["fraction"] == pytest.approx(truth[state["state"]], abs=0.01)
    truth, found = made(tmp_path / "walks", "field")
    assert found["ratio"]["geometric_mean"] == pytest.approx(truth["wide / thin"], abs=0.09)


@pytest.mark.parametrize(
    "study", ["compaction", *(pytest.param(name, marks=pytest.mark.soak) for name in ("field", "characterisation"))]
)
def test_a_study_s_page_has_its_answer_figure_and_the_hash_of_its_sheet(tmp_path: Path, study: str) -> None:
    folder, page = tmp_path / "demo", tmp_path / "page.html"
    command = good(labbook("demo", "--study", study, "--json", str(folder), at=tmp_path)).json["next"]
    told = good(labbook(*shlex.split(command)[1:], "--page", str(page), at=tmp_path)).out
    text = html.unescape(page.read_text(encoding="utf-8"))
    assert " ".join(told.split("\n\n")[0].split())[:60] in " ".join(text.split())
    assert text.count("<svg") == 1
    sheets = ("flasks.csv", "walks.csv", "trials.csv")
    (sheet,) = (path for path in (folder / "instruments").iterdir() if path.name in sheets)
    assert hashlib.sha256(sheet.read_bytes()).hexdigest() in text
    assert "http" not in re.sub(r'xmlns(:\w+)?="[^"]*"|http-equiv', "", text)
    refused(labbook(*shlex.split(command)[1:], "--page", "page.pdf", at=tmp_path), 2, "--page", ".html")
    prints_page_one_on_a_sheet(page)


@pytest.mark.parametrize("study", ["compaction", "field", pytest.param("characterisation", marks=pytest.mark.soak)])
def test_the_same_seed_makes_the_same_files(tmp_path: Path, study: str) -> None:
    for name in ("one", "other"):
        good(labbook("demo", "--study", study, str(tmp_path / name), at=tmp_path))
    assert contents(tmp_path / "one" / "instruments") == contents(tmp_path / "other" / "instruments")


def test_another_study_and_a_folder_that_is_not_empty_are_refused(tmp_path: Path) -> None:
    refused(labbook("demo", "--study", "compacton", str(tmp_path / "new"), at=tmp_path), 2, "compaction")
    (tmp_path / "there").mkdir()
    (tmp_path / "there" / "note.txt").write_text("mine")
    for study in STUDIES:
        refused(labbook("demo", "--study", study, str(tmp_path / "there"), at=tmp_path), 2, "not empty")


@pytest.mark.soak
def test_oscillations_lead_to_stiffness_and_damping(tmp_path: Path) -> None:
    truth, found = made(tmp_path, "characterisation")
    assert {one["neutral_m"] for one in found["lines"]} == {0.15, 0.2, 0.29}
    for one in found["conditions"]:
        length = f"{100.0 * one['neutral_m']:g} cm"
        for of_all in (one, *one["masses"]):
            stiffness, damping = of_all["stiffness_n_m"]["value"], of_all["damping_kg_s"]["value"]
            assert stiffness == pytest.approx(truth[f"stiffness at gain {one['gain']:g}, {length} (N/m)"], rel=0.02)
            assert damping == pytest.approx(truth[f"damping at gain {one['damping_gain']:g}, {length} (kg/s)"], rel=0.1)
