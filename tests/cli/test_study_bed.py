"""`labbook study bed`: the numbers of the report and of the predictions, its page, flasks beside it, refusals."""

from __future__ import annotations

import json
import re
import shlex
import tomllib
from pathlib import Path
from typing import Any

import pytest

from labbook.config.studies import STUDIES
from simulator.steady.published_results import published_numbers
from tests.cli.shell import good, labbook, refused
from tests.helpers.books import SmallBook, small_book
from tests.helpers.demos import made_demo
from tests.helpers.pages import content_of
from tests.helpers.study_pages import DOCS, prints_page_one_on_a_sheet
from tests.helpers.tomls import without
from tests.helpers.wording import says


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


def configure(book: Path, text: str) -> None:
    toml = book / "labbook.toml"
    toml.write_text(f"{toml.read_text(encoding='utf-8')}\n{text}", encoding="utf-8")


def test_it_is_the_report_and_what_is_published_stands_beside(book: Path, tmp_path: Path) -> None:
    found = study(book)
    assert found["claims"] == [claim.text for claim in content_of(book).claims]
    assert len(found["tables"]["joules_by_condition"]) == 24 == len(found["tables"]["apex_by_condition"])
    assert len(found["tables"]["headlines"]) == 5
    published = {one["quantity"]: one["published"] for one in found["beside"]}
    assert f"about {100.0 * published_numbers()['bed.saving_best']:g}\u00a0% (5.2.1)" in published.values()
    assert "p = .041 (5.2.1)" in published.values()
    page = tmp_path / "bed.html"
    good(labbook("study", "bed", "--page", page, at=book))
    assert page.read_text(encoding="utf-8").count("<svg") == 1
    assert "granular bed (synthetic)" in page.read_text(encoding="utf-8")
    prints_page_one_on_a_sheet(page)


def test_a_level_is_that_of_intervals(small: SmallBook) -> None:
    wide, narrow = (study(small.folder, "--level", level)["claims"][0] for level in ("0.99", "0.8"))
    says(wide, "99 %")
    says(narrow, "80 %")
    refused(labbook("study", "bed", "--level", "95", at=small.folder), 2, "--level")


@pytest.mark.soak
def test_its_demonstration_leads_to_its_page(tmp_path: Path) -> None:
    folder, page = tmp_path / "demo", tmp_path / "bed.html"
    command = good(labbook("demo", "--study", "bed", "--json", folder, at=tmp_path)).json["next"]
    good(labbook(*shlex.split(command)[1:], "--page", page, at=tmp_path))
    assert page.read_text(encoding="utf-8").count("<svg") == 1
    truth = json.loads((folder / "truth.json").read_text(encoding="utf-8"))
    *_groups, overall = study(folder / "book")["tables"]["headlines"]
    assert overall["savings_ci_low_percent"] < 100.0 * truth["saving_overall"] < overall["savings_ci_high_percent"]


def test_a_book_without_scene_and_bounds_says_so(small: SmallBook) -> None:
    told = good(labbook("study", "bed", at=small.folder)).out
    says(told, "Not simulated", "[simulation]")
    says(told, "apex_bounds_percent = [-3, 3]")
    configure(small.folder, '[studies.bed]\nwhere = "foot=small"\n')
    assert {one["foot"] for one in study(small.folder)["tables"]["joules_by_condition"]} == {"small"}


def test_a_book_that_lacks_what_it_takes_is_refused_with_the_line_to_write(small: SmallBook) -> None:
    refused(labbook("study", "bed", "--where", "b_ad_gain=0", at=small.folder), 2, "joules", "b_ad_gain")
    for sheet in ("2021-06-14.csv", "2021-06-16.csv"):
        good(labbook("files", "withdraw", sheet, "--why", "other robot", at=small.folder))
    refused(labbook("study", "bed", at=small.folder), 2, "12 runs", "charge")
    assert "bed" in labbook("study", "all", "--json", at=small.folder).json
    without(small.folder, r"\ncontrol = 0\n", "\n")
    refused(labbook("study", "bed", at=small.folder), 2, "[factors.b_ad_gain]", "control = 0")
    refused(labbook("study", "all", at=small.folder), 2, "no study")


def test_a_book_of_another_study_of_runs_is_not_the_bed_s(small: SmallBook) -> None:
    assert list(good(labbook("study", "all", "--json", at=small.folder)).json) == ["bed"]
    assert "studies beside it" not in good(labbook("report", at=small.folder)).out
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
    factors = '{ foot = "foot_radius", b_ad_gain = "b_ad" }'
    configure(small.folder, f'[simulation]\nscene = "bed"\nfactors = {factors}\n')
    without(small.folder, r"\[gains.b_ad_gain\].*?\n\n", "")
    says(good(labbook("study", "bed", at=small.folder)).out, "b_ad_gain as b_ad in kg/m", "[gains.b_ad_gain]")
    says(labbook("compare", at=small.folder).out, "b_ad_gain as b_ad in kg/m", "[gains.b_ad_gain]")
