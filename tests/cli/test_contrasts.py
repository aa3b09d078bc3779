"""Contrasts that were decided on: from labbook.toml to the first page, the table and the plan."""

from __future__ import annotations

import csv
import html
import re
from pathlib import Path

from tests.cli.shell import good, labbook
from tests.helpers.known_campaign import KnownCampaign, begun, shuffled
from tests.helpers.wording import says

CONTRASTS = """
contrasts = [
  { kind = "interaction", factor = "foot", levels = ["large", "small"] },
  { kind = "difference", factor = "foot", side = "control" },
  { kind = "difference", factor = "foot", side = "treated", outcome = "apex" },
]
"""
RUNS = {("large", 0): 1, ("large", 100): 1, ("small", 0): 1, ("small", 100): 1}


def book_of(folder: Path, campaign: KnownCampaign) -> Path:
    campaign.write(folder / "files", 5)
    book = begun(folder)
    good(labbook("ingest", "../files/charges", at=book))
    return book


def page_one(book: Path) -> str:
    page = (book / "one" / "report.html").read_text(encoding="utf-8")
    return html.unescape(re.sub("<[^>]+>", "", page[: page.index('id="results"')])).replace("\u00a0", " ")


def contrasts(book: Path) -> list[dict[str, str]]:
    with (book / "one" / "tables" / "contrasts.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_a_planned_interaction_is_answered_on_the_first_page(tmp_path: Path) -> None:
    """And what was planned of heights, which no log has, cannot be told."""
    days = shuffled(6, RUNS, 5)
    book = book_of(tmp_path, KnownCampaign({"large": 4.0, "small": 18.0}, days, run_sd=0.02, analysis=CONTRASTS))
    says(good(labbook("analysis", at=book)).out, "contrasts", "interaction foot", "difference foot control")
    good(labbook("report", "--out", "one", at=book))
    says(page_one(book), "Saving with small foot less that with large foot", "points", "Holm")
    says(page_one(book), "cannot be told", "no runs have what it compares", "foot")
    interaction, difference, of_apexes = contrasts(book)
    assert of_apexes["estimate"] == ""
    assert interaction["exploratory"] == difference["exploratory"] == ""
    assert float(interaction["ci_low"]) < 14.0 < float(interaction["ci_high"])
    assert (interaction["days"], interaction["n"], interaction["t_df"]) == ("6", "24", "5.0")
    assert float(difference["ci_low"]) < 0.0 < float(difference["ci_high"])


def test_without_a_plan_the_contrasts_of_the_factors_are_exploratory_and_off_the_first_page(tmp_path: Path) -> None:
    book = book_of(tmp_path, KnownCampaign({"large": 4.0, "small": 18.0}, shuffled(4, RUNS, 5), run_sd=0.02))
    good(labbook("report", "--out", "one", at=book))
    assert "Saving with small foot" not in page_one(book)
    found = contrasts(book)
    assert [row["kind"] for row in found] == ["difference", "difference", "interaction"]
    assert all(row["exploratory"] for row in found)
