"""`labbook study bed`: the numbers of the report and of the predictions, its page, flasks beside it, refusals."""

from __future__ import annotations

import hashlib
import json
import re
import shlex
import shutil
import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labbook.actions.studies.bed import bed_study_of
from labbook.book.opening import opened
from labbook.demo.studies.registry import STUDIES
from labbook.demo.studies.sheets import flasks
from labbook.presenting.report.content import make_report
from labbook.presenting.studies.bed import comparison_rows
from simulator.steady.published_results import published_numbers
from tests.cli.shell import good, labbook, refused
from tests.helpers.books import SmallBook, small_book
from tests.helpers.demos import made_demo
from tests.helpers.study_pages import DOCS, prints_page_one_on_a_sheet
from tests.helpers.tomls import without
from tests.helpers.wording import says

GRAIN = "[studies.compaction]\ngrain_mm = 3.4\n"


@pytest.fixture(scope="module")
def book() -> Path:
    """A demonstration of all 24 conditions, with few runs; it is only read."""
    return Path(made_demo("two_runs_a_condition").book)


@pytest.fixture
def small(tmp_path: Path) -> SmallBook:
    """A book of both feet at one gain and one active damping, without a scene and without bounds."""
    return small_book(tmp_path)


def study(book: Path, *words: str) -> Any:
    return good(labbook("study", "bed", "--json", *words, at=book)).json


@pytest.fixture(scope="module")
def found(book: Path) -> Any:
    """What the study says of the whole demonstration."""
    return study(book)


@pytest.fixture(scope="module")
def told(book: Path) -> str:
    """The same in words."""
    return good(labbook("study", "bed", at=book)).out


def configure(book: Path, text: str) -> None:
    toml = book / "labbook.toml"
    toml.write_text(f"{toml.read_text(encoding='utf-8')}\n{text}", encoding="utf-8")


def flasks_ingested(book: Path) -> None:
    (book / "flasks.csv").write_text(flasks(np.random.default_rng(1)), encoding="utf-8")
    good(labbook("ingest", "flasks.csv", at=book))


def test_its_claims_are_the_report_s_and_its_predictions_those_of_compare(book: Path, found: Any) -> None:
    with opened(book) as of_book, of_book.reading() as connection:
        made = make_report(connection, of_book.store, of_book.configuration, where=None, made_at="2021-07-01T12:00:00Z")
    assert found["claims"] == [claim.text for claim in made.content.claims]
    predictions = labbook("compare", "--json", at=book).json["predictions"]
    compared = {(one["quantity"], *one["group"].values(), one["level"]): one["predicted"] for one in predictions}
    assert len(found["conditions"]) == 24
    (softest,) = [
        one for one in found["conditions"] if [*one["group"].values(), one["level"]] == ["large", "300", "50"]
    ]
    assert softest["published"]["id"] == "bed.p.l.soft.1"
    for one in found["conditions"]:
        assert set(one["measured"]) == {"joules", "apex"}
        names = {"joules": "joules a jump", "apex": "apex height"}
        for quantity, number in one["simulated"].items():
            place = (names.get(quantity, quantity), *one["group"].values(), one["level"])
            assert number["value"] == compared[place]["value"]


def test_every_comparison_of_the_thesis_is_there(told: str, found: Any) -> None:
    joules = [one for one in found["comparisons"] if one["quantity"] == "joules a jump"]
    families = {family: [one for one in joules if one["family"] == family] for family in {x["family"] for x in joules}}
    assert len(families["each level against the control"]) == 4 * 5
    assert len(families["all levels pooled against the control"]) == 4
    of_foot = [one for one in found["contrasts"] if one["factor"] == "foot"]
    assert [one["kind"] for one in of_foot] == ["difference", "difference", "interaction"]
    for one in joules:
        assert one["test_over_runs"] in ("Student", "Welch")
        assert 0.0 <= one["p_over_runs"] <= 1.0
    assert len([one for one in found["anovas"] if one["quantity"] == "joules a jump"]) == 4
    beside = {one["quantity"]: one for one in found["beside"]}
    best = 100.0 * published_numbers()["bed.saving_best"]
    assert beside["saving, small foot, k\u00a0=\u00a01091\u00a0N/m"]["published"] == f"about {best:g}\u00a0% (5.2.1)"
    published = [one["published"] for one in found["beside"]]
    assert published.count("p > .5 (5.2.1)") == published.count("p < .0001 (5.2.1)") == 1
    for said in (" .041 ", "p = .071 (5.2.1)", "p > .15 (5.2.1)", "at most 3 mm (5.2.2)"):
        assert said in told.replace("\u00a0", " ")


def test_the_difference_of_feet_is_simulated_as_it_is_measured(found: Any) -> None:
    j = {(*one["group"].values(), one["level"]): one["simulated"]["joules"]["value"] for one in found["conditions"]}
    (row,) = [one for one in found["beside"] if "small foot less large foot, control" in one["quantity"]]
    differences = [j["small", stiffness, "0"] - j["large", stiffness, "0"] for stiffness in ("300", "400")]
    found_j = float(row["simulated"].split("\u00a0")[0].replace("\u2212", "-"))
    assert found_j == pytest.approx(sum(differences) / 2.0, abs=0.051)


@pytest.mark.soak
def test_its_demonstration_leads_to_its_page(tmp_path: Path) -> None:
    folder, page = tmp_path / "demo", tmp_path / "bed.html"
    command = good(labbook("demo", "--study", "bed", "--json", folder, at=tmp_path)).json["next"]
    good(labbook(*shlex.split(command)[1:], "--page", page, at=tmp_path))
    assert page.read_text(encoding="utf-8").count("<svg") == 1
    found = study(folder / "book")
    truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    assert found["overall_saving"]["ci_low"] < 100.0 * truth["saving_overall"] < found["overall_saving"]["ci_high"]
    assert len(found["conditions"]) == 24 == len(truth["conditions"])


def test_each_factor_of_words_has_its_rows(book: Path) -> None:
    """Not only the feet, where the robot also jumped on two surfaces, say."""
    found = bed_study_of(book, None, None, lambda _text: None).study
    names = [row[0] for row in comparison_rows(replace(found, named=("foot", "k_gain")))]
    assert [row[0] for row in comparison_rows(found)] == [name for name in names if "less k" not in name]
    assert sum("less k" in name for name in names) == 2


def test_what_flasks_say_has_the_level_asked_for_and_needs_the_grain(small: SmallBook) -> None:
    flasks_ingested(small.folder)
    told = good(labbook("study", "bed", at=small.folder)).out
    says(told, "How densely the grains lie is not told", "grain_mm = 3.4", "[studies.compaction]")
    configure(small.folder, GRAIN)
    assert study(small.folder)["compaction"]["grain_m"] == 0.0034
    levels = ("0.99", "0.9")
    wide, narrow = (study(small.folder, "--level", level)["compaction"]["difference"]["ci"] for level in levels)
    assert wide[0] < narrow[0]
    assert list(good(labbook("study", "all", "--json", at=small.folder)).json) == ["bed", "compaction"]


def test_its_page_is_one_sheet_with_both_figures_and_what_flasks_say(book: Path, tmp_path: Path) -> None:
    own, page = tmp_path / "book", tmp_path / "bed.html"
    shutil.copytree(book, own)
    flasks_ingested(own)
    configure(own, GRAIN)
    told = good(labbook("study", "bed", "--page", page, "--plot", tmp_path / "bed.svg", at=own)).out
    says(told, "Without walls the grains fill", "loose")
    text = page.read_text(encoding="utf-8")
    assert text.count("<svg") == 1
    assert "granular bed (synthetic)" in text
    assert hashlib.sha256((own / "flasks.csv").read_bytes()).hexdigest() in text
    prints_page_one_on_a_sheet(page)


def test_a_level_is_that_of_intervals_and_tests(small: SmallBook) -> None:
    wide, found, narrow = (study(small.folder, *words) for words in (("--level", "0.99"), (), ("--level", "0.8")))
    assert wide["overall_saving"]["ci_low"] < found["overall_saving"]["ci_low"] < narrow["overall_saving"]["ci_low"]
    asked = study(small.folder, "--level", "0.95")
    says(asked["remarks"][0], "95 %")
    assert asked | {"remarks": asked["remarks"][1:]} == found
    says(wide["remarks"][0], "99 %")
    refused(labbook("study", "bed", "--level", "95", at=small.folder), 2, "--level")


def test_a_book_without_scene_and_bounds_says_so(small: SmallBook) -> None:
    told = good(labbook("study", "bed", at=small.folder)).out
    says(told, "Not simulated", "[simulation]")
    says(told, "apex_bounds_percent = [-3, 3]")
    says(told, "saved", "small foot")
    configure(small.folder, '[studies.bed]\nwhere = "foot=small"\n')
    assert {one["group"]["foot"] for one in study(small.folder)["conditions"]} == {"small"}


def test_a_book_that_lacks_what_it_takes_is_refused_with_the_line_to_write(small: SmallBook) -> None:
    refused(labbook("study", "bed", "--where", "b_ad_gain=0", at=small.folder), 2, "joules", "b_ad_gain")
    good(labbook("files", "withdraw", "2021-06-14.csv", "--why", "other robot", at=small.folder))
    good(labbook("files", "withdraw", "2021-06-16.csv", "--why", "other robot", at=small.folder))
    refused(labbook("study", "bed", at=small.folder), 2, "12 runs", "charge")
    assert "bed" in labbook("study", "all", "--json", at=small.folder).json
    without(small.folder, r"\ncontrol = 0\n", "\n")
    refused(labbook("study", "bed", at=small.folder), 2, "[factors.b_ad_gain]", "control = 0")
    refused(labbook("study", "all", at=small.folder), 2, "no study")


def test_a_book_of_another_study_of_runs_is_not_the_bed_s(small: SmallBook) -> None:
    assert list(good(labbook("study", "all", "--json", at=small.folder)).json) == ["bed"]
    assert "studies beside it" not in good(labbook("report", at=small.folder)).out
    assert study(small.folder)["beside"][-1]["published"] == "at most 3\u00a0mm (5.2.2)"
    without(small.folder, '\nkind = "bed"\n', '\nkind = "field"\n')
    assert {one["published"] for one in study(small.folder)["beside"]} == {"\u2013"}
    without(small.folder, '\nkind = "field"\n', '\nkind = "bed"\n')
    configure(small.folder, "[studies.emulator]\n")
    assert list(labbook("study", "all", "--json", at=small.folder).json) == ["emulator"]


def test_the_page_s_commands_work(book: Path, tmp_path: Path) -> None:
    page = (DOCS / "bed.md").read_text(encoding="utf-8")
    demo, ask, compare = (shlex.split(line) for line in re.findall(r"^ {4}labbook (.*)$", page, re.MULTILINE))
    assert (demo[:3], "bed" in STUDIES) == (["demo", "--study", "bed"], True)
    good(labbook(*[str(tmp_path / "drawn.pdf") if word == "bed.pdf" else word for word in ask], at=book))
    assert "published (thesis)" in labbook(*compare, at=book).out
    (own,) = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    assert tomllib.loads(own)["factors"]["b_ad_gain"]["control"] == 0


def test_numbers_that_a_scene_takes_as_they_stand_are_said(small: SmallBook) -> None:
    scene = 'scene = "bed"\nfactors = { foot = "foot_radius", b_ad_gain = "b_ad" }\n'
    configure(small.folder, f"[simulation]\n{scene}")
    without(small.folder, r"\[gains.b_ad_gain\].*?\n\n", "")
    says(good(labbook("study", "bed", at=small.folder)).out, "b_ad_gain as b_ad in kg/m", "[gains.b_ad_gain]")
    told = labbook("compare", at=small.folder).out
    says(told, "b_ad_gain as b_ad in kg/m", "[gains.b_ad_gain]")
    says(told, "Not simulated")


def test_gains_taken_for_stiffness_are_named_where_the_robot_does_not_jump(small: SmallBook) -> None:
    configure(small.folder, '[simulation]\nscene = "bed"\nfactors = { k_gain = "k_extension" }\n')
    without(small.folder, r"\[gains.k_gain\].*?\n\n", "")
    refused(labbook("calibrate", at=small.folder), 2, "robot jumps", "k_gain as k_extension in N/m", "[gains.k_gain]")
    assert labbook("compare", "--check", at=small.folder).code == 1  # nothing can be compared
    assert labbook("compare", at=small.folder).code == 0


def test_means_have_the_error_of_the_drain_line_and_feet_without_a_common_day_no_test_by_days(
    told: str, found: Any
) -> None:
    assert "joules ± SE (J)" in told
    assert told.count("no test by days") == 2
    small_means = re.findall(r"CE +\d+ +[\d.]+ ± ([\d.]+)", told)
    joules = [one["measured"]["joules"] for one in found["conditions"] if one["control"]]
    for shown, number in zip(small_means, joules, strict=True):
        assert float(shown) > number["se"]
        half = 0.5 * (number["ci_high"] - number["ci_low"])
        assert 1.9 < half / float(shown) < 13.0


def test_jumps_without_logs_lack_apexes_with_the_reason(small: SmallBook) -> None:
    for path in sorted((small.instruments / "logs").glob("*.csv")):
        good(labbook("files", "withdraw", path.name, "--why", "no log", at=small.folder))
    told = good(labbook("study", "bed", at=small.folder)).out
    says(told, "There are no apex heights of these runs", "runs")
    assert "Limitations" not in told
