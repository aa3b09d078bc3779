import csv
import hashlib
import json
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.vocabulary import RunKind
from labbook.demo.campaign import make_campaign
from labbook.demo.files import recharge_course, write_campaign
from labbook.demo.records import Campaign


@pytest.fixture(scope="module")
def campaign() -> Campaign:
    return make_campaign(7, runs_per_condition=1, extra_controls=8, jumps_per_run=3)


@pytest.fixture(scope="module")
def folder(campaign: Campaign, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("campaign")
    write_campaign(campaign, folder)
    return folder


def digests(folder: Path) -> dict[str, str]:
    return {
        str(path.relative_to(folder)): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


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
    campaign = make_campaign(7, runs_per_condition=1, extra_controls=8, jumps_per_run=3)
    write_campaign(campaign, tmp_path)
    assert digests(tmp_path) == digests(folder)


def test_run_sheet_holds_the_mistake_and_the_truth_its_correction(campaign: Campaign, folder: Path) -> None:
    rows = {row["run"]: row for row in csv.DictReader((folder / "instruments" / "runs.csv").read_text().splitlines())}
    truth = json.loads((folder / "truth.json").read_text())
    (correction,) = truth["corrections"]
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


def test_configuration_is_toml_with_the_factors_of_the_study(folder: Path) -> None:
    book = tomllib.loads((folder / "labbook.toml").read_text())
    assert book["factors"]["foot"]["levels"] == {"large": {"radius_m": 0.051}, "small": {"radius_m": 0.038}}
    assert book["factors"]["k_gain"]["levels"] == [300, 400]
    assert book["factors"]["b_ad_gain"]["levels"] == [0, 50, 100, 150, 200, 250]
    assert set(book["batteries"]) == {"A", "B", "C"}
    assert book["files"]["run_pattern"] == r"^(?P<run>r\d+)"
    assert "synthetic" in book["study"]["name"]


def test_progress_counts_every_file(campaign: Campaign, folder: Path, tmp_path: Path) -> None:
    seen: list[tuple[int, int]] = []
    write_campaign(campaign, tmp_path, progress=lambda done, total: seen.append((done, total)))
    assert [done for done, _ in seen] == list(range(1, len(digests(folder)) + 1))
    assert {total for _, total in seen} == {len(seen)}


@given(st.integers(1, 500), st.integers(0, 100))
def test_counter_ends_at_the_charge_and_agrees_with_the_current(charge_mah: int, seed: int) -> None:
    course = recharge_course(seed, charge_mah, 15.4)
    assert course.charge_mah[-1] == charge_mah
    assert np.all(np.diff(course.charge_mah) >= 0)
    integral_mah = np.trapezoid(course.current_a, course.time_s) / 3.6
    # At most one second of the full current too much, by which the charger overshoots.
    assert charge_mah <= integral_mah + 1e-9 <= charge_mah + 1 / 3.6 + 1e-6


def test_four_cells_make_the_pack_and_end_at_the_storage_voltage() -> None:
    course = recharge_course(1, 150, 15.4)
    assert course.cell_v.shape == (course.time_s.size, 4)
    np.testing.assert_allclose(course.pack_v, course.cell_v.sum(axis=1), atol=0.006)
    assert course.pack_v[-1] == pytest.approx(15.4, abs=0.02)
    assert course.current_a.max() == 1.0
