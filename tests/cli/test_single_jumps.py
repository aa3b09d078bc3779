"""Single jumps on a force plate, from files of one value a line to `show`, `stats compare` and the report."""

from __future__ import annotations

import csv
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from data_schema.outcomes import Outcome
from labbook.analysis.outcomes.run_force import ALL_RULES
from labbook.book.opening import opened
from tests.cli.shell import good, labbook
from tests.helpers.books import ADA, small_book, small_runs
from tests.helpers.once import made_once
from tests.helpers.scripts import differs, numbers_of_last_report, run_all, write_all
from tests.helpers.single_jumps import SimulatedJump
from tests.helpers.tomls import without
from tests.helpers.wording import says
from tests.stats.test_single_jump import SAMPLES, needs_samples

RUNS = {run.name: run.condition for run in small_runs() if run.condition is not None}
DECLARED = ("--column", "1=force_z:N", "--rate", "1200", "--no-robot-check", "--as", ADA)
HEIGHTS = (Outcome.IMPULSE_HEIGHT, Outcome.FLIGHT_HEIGHT)


def jump_of(name: str) -> SimulatedJump:
    """The jump of a run, by a person; that of the treatment takes longer and so goes higher."""
    return SimulatedJump(int(name[1:]), slower=1.12 if RUNS[name].b_ad_gain else 1.0, offset_n=3.0)


def _make(folder: Path) -> Path:
    made = small_book(folder, ingested=True)
    for name in RUNS:
        np.savetxt(made.instruments / f"{name}_plate.txt", jump_of(name).force_n, "%.4f")
    good(labbook("ingest", *sorted(made.instruments.glob("*_plate.txt")), *DECLARED, at=made.folder))
    return made.folder


@pytest.fixture(scope="module")
def book() -> Path:
    """A book whose runs were one jump on a plate each; it is only read."""
    return made_once("single-jumps", _make)


@pytest.fixture(scope="module")
def report(book: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of its report."""
    folder = tmp_path_factory.mktemp("jumps") / "book"
    shutil.copytree(book, folder)
    good(labbook("report", "--out", "page", "--as", ADA, at=folder))
    return folder / "page"


def test_show_has_heights_peak_and_contact_with_their_errors(book: Path) -> None:
    for name in ("r001", "r002"):
        true, found = jump_of(name), good(labbook("show", name, "--json", at=book)).json["from_plate"]
        truth = {"impulse_height": true.height_m, "flight_height": true.height_m, "peak_force": true.peak_n}
        for key, value in {**truth, "contact_time": true.push_off_s}.items():
            assert abs(found[key]["value"] - value) <= 2.0 * found[key]["se"]
            assert found[key]["n"] == 1
    said = good(labbook("show", "r001", at=book)).out
    assert re.search(r"jump height from impulse 3\d\d\.?\d? ± \d+(\.\d)? mm", said), said


def test_heights_are_compared(book: Path) -> None:
    for outcome in HEIGHTS:
        said = good(labbook("stats", "compare", "--quantity", outcome.key, "--where", "foot=small", at=book)).out
        assert re.search(r"[\d.]+ mm .*n = \d", said), said


def test_the_report_compares_by_every_rule_and_says_whether_the_verdict_holds(report: Path) -> None:
    rows = list(csv.DictReader((report / "tables" / "sensitivity.csv").read_text().splitlines()))
    headline = "difference of jump height from impulse, small foot"
    of_one = {row["variant"]: row for row in rows if row["block"].startswith(headline)}
    assert {str(rules) for rules in ALL_RULES} == {name for name in of_one if name.startswith("onset ")}
    reported = float(of_one["as reported"]["value"])
    assert float(of_one["onset 5sd_back_30ms, take-off flight_5sd"]["value"]) == reported
    assert float(of_one["onset 10_percent, take-off 10n"]["value"]) > reported
    page = re.sub(r"<[^>]+>", "", (report / "report.html").read_text())
    says(page, "verdict holds under all 12 rules of onset and take-off", "onset 5sd_back_30ms, take-off flight_5sd")
    for outcome in HEIGHTS:
        assert outcome.heading in page


def test_numbers_by_other_rules_have_scripts(report: Path, tmp_path: Path) -> None:
    with opened(report.parent) as book:
        some = {
            uid: one
            for uid, one in numbers_of_last_report(book).items()
            if one.numbers.result_of(one.number).scope.get("variant") == str(ALL_RULES[-1])
        }
        written = list(write_all(book, some, tmp_path))
    assert len(written) > 3
    assert [each for number, printed in run_all(written) for each in differs(number, printed)] == []


def test_the_protocol_s_rules_are_used(book: Path, tmp_path: Path) -> None:
    folder = tmp_path / "book"
    shutil.copytree(book, folder)
    own = good(labbook("show", "r002", "--json", at=folder)).json["from_plate"]["impulse_height"]
    without(folder, r"\n\[protocol\]\n", '\n[protocol]\nonset = "10_percent"\ntake_off = "20_percent"\n')
    other = good(labbook("show", "r002", "--json", at=folder)).json["from_plate"]["impulse_height"]
    assert other["value"] > own["value"] + 0.002
    assert other["se"] > own["se"]


@needs_samples
def test_a_real_jump_has_a_height(tmp_path: Path) -> None:
    """Two records, written z down, the second of which ends in the flight."""
    folder = small_book(tmp_path, ingested=False).folder
    for run, trial in (("r001", 1), ("r002", 3)):
        np.savetxt(tmp_path / f"{run}.txt", -np.loadtxt(SAMPLES / f"subject01_trial{trial}.force.txt"), "%.4f")
        good(labbook("ingest", tmp_path / f"{run}.txt", "--run", run, *DECLARED, at=folder))
    first, second = (good(labbook("show", run, "--json", at=folder)).json["from_plate"] for run in ("r001", "r002"))
    assert first["impulse_height"]["value"] == pytest.approx(0.409, abs=0.001)
    assert first["peak_force"]["value"] == pytest.approx(1594.0, abs=3.0)
    assert first["flight_height"]["value"] == pytest.approx(0.436, abs=0.001)
    assert second["impulse_height"]["value"] == pytest.approx(0.426, abs=0.001)
    assert "record" in second["flight_height"]["value"]["reason"]
