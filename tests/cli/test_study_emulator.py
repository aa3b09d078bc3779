"""`labbook study emulator`: a simulated campaign through files and ingest, its truth found again, and refusals."""

from __future__ import annotations

import json
import re
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.validation_document import STUDIES, covered, outside
from benchmarks.validation_emulator import from_charges
from labbook.demo.running import make_campaign_book
from labbook.demo.studies.emulator import emulator_campaign, emulator_files
from labbook.studies.emulator import Controller, Trend, ask
from labbook.studies.study import Asked
from simulator.steady.published_results import published_numbers
from tests.cli.shell import good, labbook, refused
from tests.helpers.once import made_once
from tests.helpers.study_pages import DOCS, prints_page_one_on_a_sheet
from tests.helpers.tomls import without
from tests.helpers.wording import says

DAYS, JUMPS = 4, 14


def _make(folder: Path) -> Path:
    campaign = emulator_campaign(1, days=DAYS, jumps=JUMPS)
    return make_campaign_book(folder / "demo", emulator_files(campaign), lambda _what: None, lambda _line: None)


@pytest.fixture(scope="module")
def book() -> Path:
    """A book of four days with 14 jumps a run; it is only read."""
    return made_once("emulator", _make)


def study(book: Path, *words: str) -> Any:
    return good(labbook("study", "emulator", "--json", *words, at=book)).json


@pytest.fixture(scope="module")
def found(book: Path) -> Any:
    """What the study says of the book that is only read."""
    return study(book)


def test_joules_and_apexes_of_the_campaign_are_found(book: Path, found: Any) -> None:
    truth = json.loads((book.parent / "truth.json").read_text(encoding="utf-8"))["conditions"]
    gains = found["gains"]
    assert len(truth) == 14
    assert len(gains) == 15  # at gain 300 constant and scaled are the same
    for true in truth:
        of_it = [one for one in gains if (one["gain"], one["damping_gain"]) == (true["gain"], true["damping_gain"])]
        assert of_it
        for one in of_it:
            assert one["apex_m"]["value"] == pytest.approx(true["apex_m"], abs=0.006)
            assert one["simulated_apex_m"] == pytest.approx(true["apex_m"], abs=0.005)  # other first jumps
            assert 0.0 < one["apex_sd_m"] < 0.0075
            assert one["joules"]["value"] == pytest.approx(true["joules"], abs=3.0)  # 1 mAh of 14 jumps is 4.3 J
            assert one["joules"]["n"] == DAYS


def test_savings_and_lost_heights_are_those_of_means_on_shared_days(found: Any) -> None:
    gains = found["gains"]
    control = {one["gain"]: one for one in gains if one["controller"] == "compression-extension"}
    for one in gains:
        if one["controller"] == "compression-extension":
            assert one["saving_percent"] is None
            continue
        for key, of in (("saving_percent", "joules"), ("apex_loss_percent", "apex_m")):
            expected = 100.0 * (1.0 - one[of]["value"] / control[one["gain"]][of]["value"])
            assert one[key]["value"] == pytest.approx(expected, rel=1e-9, abs=1e-9)
            assert one[key]["ci"][0] < one[key]["value"] < one[key]["ci"][1]


@pytest.mark.soak
def test_intervals_cover_what_is_true() -> None:
    """The count lies in the 99.9 % binomial band."""
    assert not outside(covered(STUDIES["emulator, charges"], 100))


@pytest.mark.soak
def test_a_gain_without_a_rise_is_left_out_with_all_above_it(book: Path, found: Any) -> None:
    assert found["left_out"] == []
    rises = {(one["gain"], one["controller"]): one["change_percent"] for one in found["rises"]}
    assert rises[500, "compression-extension"]["value"] == pytest.approx(4.2, abs=2.0)  # the simulator's own
    generous = study(book, "--same", "9")
    assert generous["left_out"] == [500]
    told = good(labbook("study", "emulator", "--same", "9", at=book)).out
    says(told, "Left out", "500", "torque limit")
    assert generous["coarse"] == [100, 200, 300, 400, 500]  # of 14 jumps, which make no line
    assert [trend["line"] for trend in generous["trends"]] == [None, None]


def test_no_trend_is_said_only_where_one_is_excluded() -> None:
    """The slope's interval holds 0 in both: that alone shows nothing."""
    study = from_charges(np.random.default_rng(4))
    (scaled,) = (one.line for one in study.trends if one.controller is Controller.SCALED)
    assert scaled is not None
    for bound, said in ((0.01, "neither shown nor excluded"), (300.0, "less than 300 points")):
        change = replace(scaled.change, low=-bound, high=bound, equivalent=bound > 100.0)
        line = replace(scaled, slope=replace(scaled.slope, ci=(-1.0, 2.0)), change=change)
        text = replace(study, trends=(Trend(Controller.SCALED, line),)).sentences()[0]
        says(text, said)
        assert ("no trend" in text) is (bound > 100.0)


def test_what_cannot_be_told_is_said_without_numbers_that_are_none(book: Path) -> None:
    one_day = good(labbook("study", "emulator", "--where", "day=2019-07-08", at=book)).out
    says(one_day, "Constant active damping saves", "no interval")
    assert "nan" not in one_day
    found = study(book, "--where", "day=2019-07-08")
    savings = [row["saving_percent"] for row in found["gains"] if row["saving_percent"] is not None]
    assert savings
    assert all("reason" in saving["ci"] for saving in savings)
    assert [trend["line"] for trend in found["trends"]] == [None, None]
    says(good(labbook("study", "emulator", "--ratio", "9", at=book)).out, "Scaled active damping was not run")


@pytest.mark.soak
def test_its_page_is_one_sheet(book: Path, tmp_path: Path) -> None:
    page = tmp_path / "emulator.html"
    good(labbook("study", "emulator", "--page", page, at=book))
    assert "ground emulator (synthetic)" in page.read_text(encoding="utf-8")
    prints_page_one_on_a_sheet(page)


def test_its_figure_names_axes_units_and_what_bars_are(book: Path) -> None:
    found = replace(ask(Asked(book)).study, left_out=(500.0,))
    figure = found.draw()
    labels = " ".join(axes.get_xlabel() + axes.get_ylabel() for axes in figure.axes)
    for said in ("Energy of a jump (J)", "Apex height (cm)", "Saving (%)", "Apex lost (%)", "95 % CI"):
        assert said in labels.replace("\u00a0", " ")
    assert [text.get_text() for text in figure.legends[0].get_texts()].count("left out") == 1
    assert 500.0 not in [row.gain for row in found.analysed(Controller.SCALED)]


@pytest.mark.soak
def test_a_gain_that_the_charger_reads_too_coarsely_is_named() -> None:
    study = from_charges(np.random.default_rng(4))
    assert study.coarse == (100.0,)
    for trend in study.trends:
        assert trend.line is not None
        assert [*trend.line.groups] == ["200", "300", "400", "500"]
    says(replace(study, left_out=(500.0,)).sentences()[0], "not 100", "charger")


def test_books_without_what_it_takes_are_refused_with_the_line_to_write(changed: Path) -> None:
    refused(labbook("study", "emulator", "--constant", "70", "--ratio", "3", at=changed), 2, "--constant", "--ratio")
    refused(labbook("study", "emulator", "--where", "k_gain=300", at=changed), 2, "two")
    refused(labbook("study", "emulator", "--ratio", "0", at=changed), 2, "--ratio")
    without(changed, r"\n\[hypotheses\.saves\].*", "\n")
    without(changed, r"\ncontrol = 0\n", "\n")
    refused(labbook("study", "emulator", at=changed), 2, "[factors.b_ad_gain]", "control = 0")
    without(changed, r"\[factors.k_gain\].*?\n\n")
    refused(labbook("study", "emulator", at=changed), 2, "Or write [factors.k_gain] with kind and levels")


def test_what_was_measured_stands_beside_the_simulator_and_the_thesis(found: Any, changed: Path) -> None:
    beside = {one["quantity"]: one for one in found["beside"]}
    largest_mm = 1e3 * published_numbers()["emu.apex_sd"]
    assert beside["apex under CE at gain 400 (cm)"]["published"] == f"{100.0 * published_numbers()['emu.apex_high']:g}"
    assert beside["largest SD of the apexes of a condition (mm)"]["published"] == f"< {largest_mm:g}"
    without(changed, r"\n\[simulation\].*?\n\n", "\n")
    says(good(labbook("study", "emulator", at=changed)).out, "Not simulated", "[simulation]")
    assert {one["simulated"] for one in study(changed)["beside"]} == {"–"}


def test_which_jumps_are_left_out_has_to_be_stated(changed: Path, found: Any) -> None:
    jumps = found["jumps"]
    assert jumps["made"] == DAYS * 14 * JUMPS
    assert jumps["excluded"]["among the first 2"] == DAYS * 14 * 2
    assert jumps["counted"] == jumps["made"] - sum(jumps["excluded"].values())
    says(good(labbook("study", "emulator", at=changed)).out, "Apexes are those of", "112 among the first 2", "packet")
    without(changed, r"\nexclude_first_jumps = 2\n", "\n")
    refused(labbook("study", "emulator", at=changed), 2, "[protocol]", "exclude_first_jumps = 2")
    without(changed, r"\nexclude_gap_jumps = true\n", "\n")
    refused(labbook("study", "emulator", at=changed), 2, "exclude_first_jumps = 2 and exclude_gap_jumps = true")
    without(changed, r"\n\[protocol\]\n", "\n[protocol]\nexclude_first_jumps = 0\nexclude_gap_jumps = false\n")
    assert study(changed)["jumps"]["counted"] > jumps["counted"]


def test_the_page_s_commands_work_and_the_answer_comes_first_with_the_thesis_beside(book: Path, tmp_path: Path) -> None:
    page = (DOCS / "emulator.md").read_text(encoding="utf-8")
    demo, ask, _compare = (line.split() for line in re.findall(r"^ {4}labbook (.*)$", page, re.MULTILINE))
    assert demo[:3] == ["demo", "--study", "emulator"]
    plot = [str(tmp_path / "drawn.pdf") if word == "emulator.pdf" else word for word in ask]
    told = good(labbook(*plot, at=book)).out
    says(told, "Scaled active damping saves", "thesis")
    says(told, "apex height", "6 %", "of 9 intervals")  # at gain 300 constant and scaled are the same runs
    assert (tmp_path / "drawn.pdf").stat().st_size > 10_000
    (own,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    assert set(tomllib.loads(own)["factors"]) == {"k_gain", "b_ad_gain"}
    refused(labbook("demo", "--study", "emulater", str(tmp_path / "none"), at=tmp_path), 2, "emulator")


@pytest.mark.soak
def test_the_page_s_comparison_with_predictions(book: Path) -> None:
    page = (DOCS / "emulator.md").read_text(encoding="utf-8")
    (compare,) = (line.split() for line in re.findall(r"^ {4}labbook (compare.*)$", page, re.MULTILINE))
    answer = labbook(*compare, at=book)
    assert answer.code == 1
    says(answer.out, "same at gains 400 and 500", "fails")
    published = re.findall(r"\d+ (?:mm|%) \([\d.]+\)$", answer.out, re.MULTILINE)
    assert {*published} == {"20 % (4.3.2)", "256 mm (4.4)", "493 mm (4.4)"}
