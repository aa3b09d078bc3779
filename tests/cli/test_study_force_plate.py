"""`labbook study force-plate`: a simulated campaign through files and ingest, its truth found again, and refusals."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks.validation_document import STUDIES, covered, in_memory, outside
from data_schema.errors import InputRefused
from labbook.demo.running import make_campaign_book
from labbook.demo.studies import force_plate
from labbook.demo.studies.force_plate import plate_campaign, plate_files
from labbook.demo.studies.runs import StudyScatter
from labbook.studies.force_plate import compare_joules
from simulator.steady.published_results import published_numbers
from tests.cli.shell import good, labbook, refused
from tests.helpers.once import made_once
from tests.helpers.study_pages import DOCS, prints_page_one_on_a_sheet
from tests.helpers.tomls import without

DAYS, HOPS = 2, 24


def _make(folder: Path) -> Path:
    campaign = plate_campaign(1, days=DAYS, hops=HOPS)
    return make_campaign_book(folder / "demo", plate_files(campaign), lambda _what: None, lambda _line: None)


@pytest.fixture(scope="module")
def book() -> Path:
    """A book of two days with 24 hops a run; it is only read."""
    return made_once("plate", _make)


def study(book: Path, *words: str) -> Any:
    return good(labbook("study", "force-plate", "--json", *words, at=book)).json


def test_clocks_and_joules_of_the_campaign_are_found(book: Path) -> None:
    truth = json.loads((book.parent / "truth.json").read_text(encoding="utf-8"))["runs"]
    found = study(book)["runs"]
    assert [one["run"] for one in found] == [one["run"] for one in truth]
    for one, true in zip(found, truth, strict=True):
        assert one["clocks"]["at_zero_s"] == pytest.approx(true["clock_offset_s"], abs=1e-3)
        low_s, high_s = one["offset_ci"]
        assert low_s < true["clock_offset_s"] < high_s
        assert one["clocks"]["drift"] == pytest.approx(true["clock_drift"], abs=3e-5)
        assert one["measured_j"] == pytest.approx(true["joules_per_jump"], rel=0.08)
        assert len(one["hops_j"]) <= one["stances"] == one["hops_made"] == HOPS
        # The foot's weight and the impact are in the plate's force, and not in what its motors take.
        assert 1.0 < one["estimated_j"] / true["joules_in_stance"] < 1.12


def test_contact_and_jumps_of_the_plate_are_compared_with_what_the_simulator_predicts(book: Path) -> None:
    told = good(labbook("compare", "--json", at=book)).json
    predictions = told["predictions"]
    assert max(one["most_contact_time_s"] for one in told["assumed"]) > 0.0
    plate = {"contact time", "jump height from impulse"}
    assert {one["quantity"] for one in predictions} == {"joules a jump", "apex height", *plate}
    of_plate = [one for one in predictions if one["quantity"] in plate]
    assert len(of_plate) == 2 * len(force_plate.GAINS)
    for one in of_plate:
        # An assumed damping changes which hop the stiffest leg makes.
        unsure = 2.0 * one["predicted"]["se"] >= one["predicted"]["value"]
        assert one["agrees"] is (None if unsure else True)
        assert not unsure or one["level"] == "600" or one["group"]["k_gain"] == "600"
        # Its first jumps, in which the robot settles, are a third of so short a run.
        assert one["measured"]["value"] == pytest.approx(one["predicted"]["value"], rel=0.1)


@pytest.mark.soak
def test_intervals_of_slopes_cover_where_recharges_scatter() -> None:
    """The count lies in the 99.9 % binomial band."""
    assert not outside(covered(STUDIES["force-plate, charges"], 200))


@pytest.mark.soak
def test_intervals_cover_slope_and_drift() -> None:
    """Each count lies in the 99.9 % binomial band."""
    assert not outside(covered(STUDIES["force-plate"], 5))


def test_without_the_foot_s_weight_joules_are_those_of_the_motors_in_stance() -> None:
    """The impact of the foot, smoothed over 13 ms, is all that is left."""
    campaign = plate_campaign(2, days=1, hops=16, scatter=StudyScatter(0.0, 0.0, 0.0), noise=0.0)
    study = compare_joules([in_memory(run, run.stance_j) for run in campaign if run.gain], 13)
    assert study.slope_without_foot == pytest.approx(1.0, abs=0.01)
    assert study.slope.slope == pytest.approx(1.07, abs=0.02)
    assert not study.left_out


def test_joules_stand_beside_the_simulator_and_the_slope_beside_the_thesis(book: Path) -> None:
    beside = {one["quantity"]: one for one in study(book)["beside"]}
    assert beside["slope, estimated over measured joules"]["published"] == f"{published_numbers()['plate.slope']:g}"
    for gain in force_plate.GAINS:
        one = beside[f"joules a hop at extension stiffness {gain}"]
        assert float(one["simulated"]) == pytest.approx(float(one["measured"]), rel=0.1)


@pytest.mark.soak
def test_page_one_of_its_page_is_a_sheet(book: Path, tmp_path: Path) -> None:
    page = tmp_path / "plate.html"
    good(labbook("study", "force-plate", "--page", str(page), at=book))
    text = page.read_text(encoding="utf-8")
    assert not re.findall(r">\s*-\d", text)
    assert "all runs; page of 20" in text
    prints_page_one_on_a_sheet(page)


def test_a_log_of_another_run_and_runs_of_two_rates_are_refused() -> None:
    one, other = [in_memory(run, 40.0) for run in plate_campaign(3, days=1, hops=24) if run.gain][:2]
    wrong = replace(one, leg_time_s=other.leg_time_s, length_m=other.length_m)
    with pytest.raises(InputRefused, match="run r002: plate and leg cannot be aligned"):
        compare_joules([wrong, other])
    slow = replace(other, plate_time_s=other.plate_time_s[::2], force_n=other.force_n[::2])
    with pytest.raises(InputRefused, match="500 Hz in r003"):
        compare_joules([one, slow])


def test_the_page_s_command_says_slope_clocks_and_window(book: Path, tmp_path: Path) -> None:
    page = (DOCS / "force-plate.md").read_text(encoding="utf-8")
    (words,) = re.findall(r"^ {4}labbook (study .*)$", page, re.MULTILINE)
    plot = tmp_path / "plate.pdf"
    shown = good(labbook(*words.replace("plate.pdf", str(plot)).split(), at=book)).out
    assert plot.read_bytes().startswith(b"%PDF")
    for said in ("Estimated joules are 1.", "95 % CI", "over 2 days, 8 runs of 4 conditions", "1.35", "ppm", "samples"):
        assert said in " ".join(shown.split())


def test_one_day_has_its_interval_over_runs(book: Path) -> None:
    found = study(book, "--where", "day=2021-03-01")
    assert (found["slope"]["groups"], found["slope"]["n"]) == (4, 4)
    shown = good(labbook("study", "force-plate", "--where", "day=2021-03-01", at=book)).out
    assert "one day" in shown


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--window", "14"), ("14", "odd")),
        (("--where", "k_gain=300"), ("k_gain 300", "one condition")),
        (("--where", "k_gain=300 and k_gain=400"), ("no run fulfils", "none all")),
        (("--plot", "plate.doc"), ("plate.doc",)),
    ],
)
def test_questions_without_an_answer_are_refused(words: tuple[str, ...], said: tuple[str, ...], book: Path) -> None:
    refused(labbook("study", "force-plate", *words, at=book), 2, *said)


def test_a_book_without_motors_or_a_factor_is_told_what_to_write(changed: Path) -> None:
    without(changed, r"\[simulation\].*")
    refused(labbook("study", "force-plate", at=changed), 2, "[simulation]", 'scene = "force_plate"')
    for table in ("factors", "gains"):
        without(changed, rf"\[{table}.k_gain\].*?\n\n")
    refused(labbook("study", "force-plate", at=changed), 2, "[factors.k_gain]", "levels = [300, 400, 500, 600]")


def test_a_leg_out_of_reach_is_refused_with_what_to_measure(changed: Path) -> None:
    without(changed, "link_2_m = 0.2", "link_2_m = 0.15")
    refused(labbook("study", "force-plate", at=changed), 2, "r002", "0.05 to 0.25 m", "measure the links")


def test_a_book_without_plate_is_told_what_to_ingest(tmp_path: Path, book: Path) -> None:
    instruments = book.parent / "instruments"
    shutil.copy(book / "labbook.toml", tmp_path)
    good(labbook("init", tmp_path, "--as", "Ada Nwosu", at=tmp_path))
    good(labbook("runs", "import", instruments / "runs.csv", at=tmp_path))
    refused(labbook("study", "force-plate", at=tmp_path), 2, "none of 8 runs", "force-plate record")
    good(labbook("ingest", instruments / "force", at=tmp_path))
    refused(labbook("study", "force-plate", at=tmp_path), 2, "leg_length", "[profiles.NAME.columns]")
    good(labbook("ingest", instruments / "logs", at=tmp_path))
    refused(labbook("study", "force-plate", at=tmp_path), 2, "r002", "no charge recorded", "idle runs")


def test_runs_that_lack_something_are_left_out_and_named(changed: Path) -> None:
    good(labbook("files", "withdraw", "r002_synthetic.csv", "--why", "another robot", at=changed))
    found = study(changed)
    assert set(found["left_out"]) == {"r002"}
    assert found["slope"]["n"] == 7


def test_a_charge_that_is_ten_times_off_is_named(changed: Path) -> None:
    good(labbook("correct", "r002", "mah=9000", "--why", "a slip of the pen", "--as", "Ada Nwosu", at=changed))
    said = " ".join(good(labbook("study", "force-plate", at=changed)).out.split())
    assert "far from that of the other runs in r002 (0." in said
