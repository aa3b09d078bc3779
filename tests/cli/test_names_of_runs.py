"""A run has one name, however the letters of a file's name are composed."""

from __future__ import annotations

import shutil
import unicodedata
from pathlib import Path

from tests.cli.shell import good, labbook, rows
from tests.helpers.books import SmallBook
from tests.helpers.wording import says

LINKS = "SELECT run.name FROM run_file JOIN run ON run_file.run = run.id"
CHARGES = "SELECT run.name, charge_mah FROM charge JOIN run ON charge.run = run.id"


def parted(name: str) -> str:
    """A name as macOS writes it: u and a dieresis for ü."""
    return unicodedata.normalize("NFD", name)


def test_a_name_with_parted_letters_is_that_of_the_run(fresh: SmallBook, tmp_path: Path) -> None:
    """`Prüfung1.csv` from a Mac belonged to no run."""
    sheet = tmp_path / "runs.csv"
    factors = (fresh.instruments / "runs.csv").read_text().splitlines()
    sheet.write_text("\n".join([factors[0], factors[1].replace("r001", "Prüfung1")]) + "\n")
    said = good(labbook("runs", "import", sheet, at=fresh.folder)).out
    says(said, "Prüfung1", "run_names", "a file whose name begins so")
    log = tmp_path / parted("Prüfung1.csv")
    shutil.copy(fresh.log("r001"), log)
    good(labbook("ingest", log, at=fresh.folder))
    charges = tmp_path / "charges.csv"
    charges.write_text(f"run,mAh\n{parted('Prüfung1')},150\n")
    good(labbook("ingest", charges, at=fresh.folder))
    assert rows(fresh.folder, LINKS) == [("Prüfung1",)]
    assert rows(fresh.folder, CHARGES) == [("Prüfung1", 150.0)]
    good(labbook("show", parted("Prüfung1"), at=fresh.folder))
