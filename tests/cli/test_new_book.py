"""A book that `labbook init` just made takes any lab's files: no robot or pack of another lab is declared in it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from labbook.demo.writers import PlateRecord, bertec_text
from tests.cli.shell import good, labbook, refused, rows, unchanged
from tests.helpers.wording import says

ROBOT = "#[robots.hopper]"


def person_hopping(seconds: float = 6.0, rate_hz: float = 1000.0) -> bytes:
    """A person of 80 kg who hops on a plate: half a sine on the ground, nothing in the air."""
    time_s = np.arange(0.0, seconds, 1.0 / rate_hz)
    force_n = np.zeros((time_s.size, 3))
    push = np.sin(np.pi * (time_s % 0.6) / 0.3)
    force_n[:, 2] = np.where(time_s > 1.2, np.pi * 80 * 9.80665 * np.maximum(push, 0.0), 0.0)
    force_n += np.random.default_rng(5).normal(0.0, 0.5, force_n.shape)
    return bertec_text(PlateRecord(1000 * time_s, force_n, np.zeros_like(force_n), np.zeros((time_s.size, 2))))


@pytest.fixture
def book(tmp_path: Path) -> Path:
    good(labbook("init", "book", "--as", "Ada Nwosu", at=tmp_path))
    return tmp_path / "book"


def test_a_person_on_a_plate_and_a_pack_of_17_ah_are_taken_in_until_a_robot_is_declared(book: Path) -> None:
    """It was refused as 785 N for a robot of 2 kg, and as more than a pack of 6600 mAh can take."""
    (book / "r001.txt").write_bytes(person_hopping())
    (book / "charges.csv").write_text("run,mAh,pack\nr001,17000,A\nr002,16800,A\n")
    good(labbook("ingest", "charges.csv", "r001.txt", "--dry-run", at=book))

    toml = (book / "labbook.toml").read_text()
    start, end = toml.index(ROBOT), toml.index("#[instruments")
    declared = toml[:start] + toml[start:end].replace("\n#", "\n").removeprefix("#") + toml[end:]
    (book / "labbook.toml").write_text(declared)
    said = labbook("ingest", "charges.csv", "r001.txt", "--dry-run", at=book)
    assert said.code == 2
    says(said.out, "force_weight_implausible")
    says(said.out, "charge_implausible", "8580 mAh")

    (book / "labbook.toml").write_text(toml)
    good(labbook("ingest", "charges.csv", "r001.txt", at=book))
    assert rows(book, "SELECT charge_mah FROM charge ORDER BY id") == [(17000.0,), (16800.0,)]


def test_a_run_needs_the_robot_and_pack_that_it_was_made_with(book: Path) -> None:
    (book / "runs.csv").write_text("run,date,position,kind,duration_s\nr001,2024-03-04,1,idle,1200\n")
    refused(labbook("runs", "import", "runs.csv", at=book), 2, "r001", "no robot", "declare one in labbook.toml")


def test_labbook_toml_is_checked_and_its_keys_exported(book: Path) -> None:
    good(labbook("config", at=book))
    (book / "labbook.toml").write_text((book / "labbook.toml").read_text().replace("jumps_nominal", "jumps_nominl"))
    refused(labbook("config", at=book), 2, "study.jumps_nominl", "'jumps_nominal'")
    assert "jumps_nominal" in good(labbook("config", "--schema", at=book)).out


def test_study_without_factors_cannot_be_planned(book: Path) -> None:
    with unchanged(book):
        refused(labbook("plan", "--seed", "1", at=book), 2, "no factors", "[factors]")
