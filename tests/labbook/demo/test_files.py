import csv
import json
from pathlib import Path

import pytest

from data_schema.vocabulary import RunKind
from labbook.demo.campaign import Campaign, make_campaign
from labbook.demo.files import campaign_files
from labbook.demo.running import write_files
from tests.helpers.folders import contents


def made() -> Campaign:
    return make_campaign(7, runs_per_condition=1, extra_controls=8, jumps_per_run=3)


@pytest.fixture(scope="module")
def campaign() -> Campaign:
    return made()


@pytest.fixture(scope="module")
def folder(campaign: Campaign, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("campaign")
    write_files(folder, campaign_files(campaign), lambda _step: None)
    return folder


def test_every_run_has_its_files_and_their_names_say_synthetic(campaign: Campaign, folder: Path) -> None:
    instruments = folder / "instruments"
    logged = {path.name for path in (instruments / "logs").iterdir()}
    assert logged == {f"{run.name}_synthetic.csv" for run in campaign.of_kind(RunKind.JUMPS)}
    charged = set()
    for sheet in (instruments / "charger").glob("*.csv"):
        charged |= {row["run"] for row in csv.DictReader(sheet.read_text().splitlines())}
    plated = {run.name for run in campaign.of_kind(RunKind.CHARACTERISATION)}
    assert charged == {run.name for run in campaign.runs} - plated
    assert len(list((instruments / "force").iterdir())) == len(plated) == 1
    assert len(list((instruments / "charger").glob("*icharger*.txt"))) == 1
    assert all("synthetic" in path.name for path in instruments.glob("*/*"))


def test_same_seed_same_bytes(folder: Path, tmp_path: Path) -> None:
    write_files(tmp_path, campaign_files(made()), lambda _step: None)
    assert contents(tmp_path) == contents(folder)


def test_run_sheet_holds_the_mistake_and_the_truth_its_correction(campaign: Campaign, folder: Path) -> None:
    rows = {row["run"]: row for row in csv.DictReader((folder / "instruments" / "runs.csv").read_text().splitlines())}
    truth = json.loads((folder / "truth.json").read_text())
    (correction,) = truth["corrections"]
    mistaken = next(run for run in campaign.runs if run.name == correction["run"])
    assert mistaken.condition is not None
    assert correction["right"] == mistaken.condition.foot
    assert rows[correction["run"]]["foot"] == correction["written"] != correction["right"]
    for run in campaign.runs:
        if run.name != correction["run"] and run.condition is not None:
            assert rows[run.name]["foot"] == run.condition.foot
    assert len(rows) == len(campaign.runs)


def test_truth_knows_every_apex(campaign: Campaign, folder: Path) -> None:
    truth = json.loads((folder / "truth.json").read_text())
    by_run = {entry["run"]: entry for entry in truth["runs"]}
    for run in campaign.of_kind(RunKind.JUMPS):
        entry = by_run[run.name]
        assert len(entry["apex_ms"]) == len(entry["apex_height_m"]) == run.reached_apexes_m.size
        assert len(entry["misfired_jumps"]) == run.misfired.sum()
    assert truth["passive"]["charge_at_run_duration_mah"] == pytest.approx(86.183)
