"""Sheets of studies in a book: kept, of no run, found by their study, and asked with what labbook.toml says."""

from __future__ import annotations

import functools
import re
import shlex
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from labbook.demo.studies.sheets import flasks, oscillation_campaign, walks
from tests.cli.shell import good, labbook, refused
from tests.helpers.attention import told
from tests.helpers.books import SmallBook
from tests.helpers.study_pages import DOCS
from tests.helpers.wording import says

GRAIN = "[studies.compaction]\ngrain_mm = 3.4\n"


@pytest.fixture
def book(tmp_path: Path) -> Path:
    """A new book, and beside it two sheets of flasks and one of walks."""
    good(labbook("init", "book", "--as", "Ada Nwosu", at=tmp_path))
    for seed, name in enumerate(("flasks.csv", "later.csv")):
        (tmp_path / name).write_text(flasks(np.random.default_rng(seed)), encoding="utf-8")
    (tmp_path / "walks.csv").write_text(walks(np.random.default_rng(1)), encoding="utf-8")
    return tmp_path / "book"


@functools.cache
def trials_of_a_length() -> dict[str, str]:
    """The first trials of a leg's gains at 15 cm alone, as a sheet and the log of each."""
    files = {record.path: record.content.decode() for record in oscillation_campaign(2).records}
    head, *rows = files["trials.csv"].splitlines(keepends=True)
    logs = {name: text for name, text in files.items() if name.startswith("15cm") and name.endswith("_1.csv")}
    return {**logs, "trials.csv": "".join([head, *(row for row in rows if row.partition(",")[0] in logs)])}


def keep_trials(folder: Path, end: str = "\n") -> list[Path]:
    """Write the trials' sheet to a folder and their logs beside it; returns the logs."""
    for name, text in trials_of_a_length().items():
        (folder / name).write_text(text if name == "trials.csv" else text.rstrip("\n") + end, encoding="utf-8")
    return [folder / name for name in trials_of_a_length() if name != "trials.csv"]


def configure(book: Path, table: str) -> None:
    path = book / "labbook.toml"
    path.write_text(path.read_text(encoding="utf-8") + table, encoding="utf-8")


def asked(book: Path, *words: str) -> dict[str, Any]:
    found: dict[str, Any] = good(labbook("study", *words, "--json", at=book)).json
    return found


def test_a_sheet_in_the_book_says_what_the_file_says(book: Path) -> None:
    good(labbook("ingest", "../flasks.csv", "../walks.csv", at=book))
    configure(book, GRAIN)
    (book.parent / "flasks.csv").rename(book.parent / "gone.csv")
    alone = asked(book, "compaction", "../gone.csv", "--grain", "3.4")
    assert asked(book, "compaction") == alone
    assert asked(book, "compaction", "--grain", "3.0") != alone
    assert asked(book, "field") == asked(book, "field", "../walks.csv")
    assert "inbox" not in told(book, "today")
    assert good(labbook("runs", "inbox", "--json", at=book)).json == []
    good(labbook("rebuild", at=book))
    assert asked(book, "compaction") == alone


def test_of_several_sheets_one_is_named_or_the_others_are_withdrawn(book: Path) -> None:
    good(labbook("ingest", "../flasks.csv", "../later.csv", at=book))
    uid = good(labbook("files", "list", "--json", at=book)).json[-1]["reading"]["file_uid"]
    refused(labbook("study", "compaction", "--grain", "3.4", at=book), 2, "2 sheets", "flasks.csv", f'sheet = "{uid}"')
    configure(book, f'{GRAIN}sheet = "{uid}"\nlevel = 0.9\n')
    later = asked(book, "compaction", "../later.csv", "--grain", "3.4", "--level", "0.9")
    assert asked(book, "compaction") == later
    toml = book / "labbook.toml"
    toml.write_text(toml.read_text(encoding="utf-8").replace(f'sheet = "{uid}"', ""), encoding="utf-8")
    good(labbook("files", "withdraw", "flasks.csv", "--why", "measured again", at=book))
    assert asked(book, "compaction") == later


def test_what_is_missing_is_said(book: Path) -> None:
    refused(labbook("study", "compaction", at=book), 2, "no sheet", "radius_mm,state,water_ml")
    good(labbook("ingest", "../flasks.csv", at=book))
    refused(labbook("study", "compaction", at=book), 2, "--grain 3.4", "grain_mm = 3.4", "[studies.compaction]")
    refused(labbook("study", "compaction", "../flasks.csv", "--book", ".", at=book), 2, "--book")
    refused(labbook("study", "field", at=book.parent), 2, "no book", "--book DIR")


def test_a_sheet_belongs_to_no_run(stated: SmallBook) -> None:
    run = good(labbook("runs", "list", "--json", at=stated.folder)).json[0]["name"]
    sheet = stated.folder.parent / f"{run}_flasks.csv"
    sheet.write_text(flasks(np.random.default_rng(1)), encoding="utf-8")
    refused(labbook("ingest", sheet, "--run", run, at=stated.folder), 2, sheet.name, "no run")
    good(labbook("ingest", sheet, at=stated.folder))
    refused(labbook("assign", sheet.name, run, at=stated.folder), 2, "belongs to no run")
    assert sheet.name not in good(labbook("show", run, at=stated.folder)).out


def test_a_sheet_or_log_that_is_damaged_is_not_taken_in(book: Path) -> None:
    whole = (book.parent / "flasks.csv").read_text(encoding="utf-8")
    for text, said, *flags in (
        (f"{whole}15,loose", "line 12"),
        (f"{whole}15,loose\n15,loose,6.2,1\n", "line 12 of damaged.csv: 2 cells"),
        ("time_ms,position_mm,velocity (m/s)\n0,1,2\n0,x,2\n", "line 3", "--format", "study_log"),
        ("time_s,power_W\n0,1\n0,1\n", "does not rise", "--format", "study_log"),
    ):
        (book.parent / "damaged.csv").write_text(text, encoding="utf-8")
        answer = labbook("ingest", "../damaged.csv", *flags, at=book)
        assert (answer.code, said in answer.out) == (2, True), answer.out
    assert good(labbook("files", "list", "--json", at=book)).json == []


WALK, TRIAL = "walk,robot,mass_kg,distance_m,energy_Wh\n", "file,gain,damping_gain,mass_kg\n"


@pytest.mark.parametrize(
    ("study", "text"),
    [
        ("compaction", "radius_mm,state,water_ml\n15,loose,6.3\n15,hard,5,9\n"),
        ("compaction", "radius_mm,state,water_kg\n15,loose,6.3\n"),
        ("field", WALK + "dune,thin,8.1,430,12\ndune,wide,8,430,11\nmoor,thin,8.1,430,12\nmoor,wade,8,430,12\n"),
        ("characterisation", TRIAL + "a.csv,60,0,1\n" * 2),
    ],
)
def test_ingest_refuses_what_the_study_would_in_the_same_words(book: Path, study: str, text: str) -> None:
    (book / "sheet.csv").write_text(text, encoding="utf-8")
    by_study = labbook("study", study, "sheet.csv", *(("--grain", "3.4") if study == "compaction" else ()), at=book)
    answer = labbook("ingest", "sheet.csv", "--json", at=book)
    assert (by_study.code, answer.code) == (2, 2)
    (finding,) = answer.json[0]["findings"]
    assert f"labbook: {finding['message']}" in by_study.err.replace("\n", " "), by_study.err
    if finding["line"]:
        assert f"line {finding['line']} of sheet.csv" in finding["message"]


def test_mass_and_distance_that_may_be_swapped_are_named(book: Path) -> None:
    """Their product is the same: no number of the study would show it."""
    head, *rows = (book.parent / "walks.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    swapped = head.replace("mass_kg,distance_m", "distance_m,mass_kg")
    assert swapped != head
    (book / "swapped.csv").write_text("".join([swapped, *rows]), encoding="utf-8")
    said = good(labbook("ingest", "swapped.csv", at=book)).out
    says(said, "Line 2", "are mass and distance swapped?")
    assert "are mass and distance swapped?" in good(labbook("study", "field", at=book)).out
    assert "swapped" in asked(book, "field")["doubt"]
    assert asked(book, "field", "../walks.csv")["doubt"] is None


def test_a_decimal_sign_that_the_study_may_be_told_later_is_a_note(book: Path) -> None:
    """`decimal` of labbook.toml, or `--decimal`, settles it: the sheet is taken in, and the question is asked."""
    (book / "flasks.csv").write_text("radius_mm;state;water_ml\n15;a;6.430\n15;b;6.130\n20;a;14.230\n")
    said = good(labbook("ingest", "flasks.csv", at=book)).out
    says(said, "3 rows")
    says(said, "add --decimal , or --decimal .")


def test_a_last_line_that_may_be_cut_is_refused_of_a_file_too(book: Path) -> None:
    """430 of 4300: nothing shows that a digit is gone, as with a file for ingest."""
    path = book.parent / "walks.csv"
    path.write_text(path.read_text(encoding="utf-8").rstrip("\n"), encoding="utf-8")
    refused(labbook("study", "field", path, at=book), 2, "walks.csv", "no line end", "--complete")
    good(labbook("study", "field", path, "--complete", at=book))
    keep_trials(book, end="")
    refused(labbook("study", "characterisation", "trials.csv", at=book), 2, "15cm_60_1kg_1.csv", "no line end")
    good(labbook("study", "characterisation", "trials.csv", "--complete", at=book))


def test_trials_find_their_logs_in_the_book(book: Path) -> None:
    logs = keep_trials(book.parent)
    good(labbook("ingest", "../trials.csv", at=book))
    refused(labbook("study", "characterisation", at=book), 2, "15cm_60_1kg_1.csv", "--format study_log")
    good(labbook("ingest", *logs, "--format", "study_log", at=book))
    assert asked(book, "characterisation") == asked(book, "characterisation", "../trials.csv")
    assert good(labbook("runs", "inbox", "--json", at=book)).json == []


def test_each_log_of_a_book_has_its_own_decimal_sign(book: Path) -> None:
    """A sheet from a spreadsheet has commas, logs from a logger have points that could be thousands."""
    rows = [f"{walk};{robot};8,1;430,5;{robot}{walk}.csv" for walk in (1, 2) for robot in ("thin", "wide")]
    sheet = "\n".join(["walk;robot;mass_kg;distance_m;log", *rows]) + "\n"
    (book.parent / "walks.csv").write_text(sheet, encoding="utf-8")
    for number, row in enumerate(rows):
        log = [f"{second}.000,120.{200 + second + number}" for second in range(1, 60)]
        (book.parent / row.split(";")[-1]).write_text("\n".join(["time_s,power_W", *log]) + "\n", encoding="utf-8")
    good(labbook("ingest", "../walks.csv", "--decimal", ",", at=book))
    logs = [f"../{row.split(';')[-1]}" for row in rows]
    good(labbook("ingest", *logs, "--format", "study_log", "--decimal", ".", at=book))
    assert asked(book, "field") == asked(book, "field", "../walks.csv")


def test_a_log_that_two_names_mean_is_refused(book: Path) -> None:
    """A book knows logs without their folders: one of the same name that was not ingested would count as the other."""
    (book.parent / "day1").mkdir()
    logs = keep_trials(book.parent / "day1")
    head, *rows = trials_of_a_length()["trials.csv"].splitlines()
    sheet = "\n".join([head, *(f"day1/{row}" for row in rows), f"day2/{rows[0]}"]) + "\n"
    (book.parent / "trials.csv").write_text(sheet, encoding="utf-8")
    good(labbook("ingest", *logs, "--format", "study_log", at=book))
    good(labbook("ingest", "../trials.csv", at=book))
    both = [f"{day}/15cm_60_1kg_1.csv" for day in ("day1", "day2")]
    refused(labbook("study", "characterisation", at=book), 2, *both, "count twice")
    shutil.copytree(book.parent / "day1", book.parent / "day2")
    refused(labbook("study", "characterisation", "../trials.csv", at=book), 2, both[1], "same bytes")


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ("[studies.compaction]\ngrain_mm = 0\n", ("grain_mm",)),
        ("[studies.field]\nlevel = 95\n", ("studies.field.level", "95")),
        ("[studies.force-plate]\nwindow = 2.5\n", ("window", "whole number")),
        ("[studies.emulator]\nsame_percent = 100\n", ("same_percent", "100")),
    ],
)
def test_a_protocol_that_is_none_is_refused(book: Path, table: str, said: tuple[str, ...]) -> None:
    configure(book, table)
    refused(labbook("study", "field", at=book), 2, *said)


def test_all_studies_of_a_book_are_shown_and_one_that_cannot_be_made_is_named(book: Path) -> None:
    refused(labbook("study", "all", at=book), 2, "no study", "[studies.NAME]")
    refused(labbook("study", "all", "--pages", "../flasks.csv", at=book), 2, "--pages ../flasks.csv", "name a folder")
    good(labbook("ingest", "../flasks.csv", "../walks.csv", at=book))
    without_grain = labbook("study", "all", "--json", at=book)
    assert (without_grain.code, set(without_grain.json)) == (2, {"compaction", "field"})
    assert "grain_mm" in without_grain.json["compaction"]["refused"]
    configure(book, GRAIN)
    found = good(labbook("study", "all", "--pages", "pages", "--json", at=book)).json
    assert [one["page"] for one in found.values()] == [f"pages/{name}.html" for name in ("compaction", "field")]
    assert asked(book, "field") == {key: value for key, value in found["field"].items() if key != "page"}
    assert "SHA-256" in (book / "pages" / "compaction.html").read_text(encoding="utf-8")
    assert good(labbook("study", "all", at=book)).out.index("compaction:") == 0
    assert "compaction, field (`labbook study all`)" in good(labbook("report", at=book)).out


def test_the_page_works_as_it_says(book: Path) -> None:
    text = (DOCS / "studies.md").read_text(encoding="utf-8")
    sheets, logs, *asks = (shlex.split(line) for line in re.findall(r"^ {7}labbook (.*)$", text, re.MULTILINE))
    (book / "logs").mkdir()
    keep_trials(book / "logs")
    (book / "logs" / "trials.csv").rename(book / "trials.csv")
    for name in ("flasks.csv", "walks.csv"):
        shutil.copy(book.parent / name, book)
    for words in (sheets, logs):
        good(labbook(*words, at=book))
    (table,) = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    configure(book, table)
    answers = [good(labbook(*words, at=book)).out for words in asks]
    assert answers[0].split("\n")[0] in answers[1]
    pages = {f"{study}.html" for study in ("compaction", "characterisation", "field")}
    assert {path.name for path in (book / "studies").iterdir()} == pages


def test_a_withdrawn_file_leaves_its_name_to_the_one_in_use(book: Path) -> None:
    good(labbook("ingest", "../flasks.csv", at=book))
    first = good(labbook("files", "list", "--json", at=book)).json[0]["reading"]["file_uid"]
    shutil.copy(book.parent / "later.csv", book.parent / "flasks.csv")
    good(labbook("ingest", "../flasks.csv", at=book))
    said = good(labbook("files", "withdraw", first, "--why", "measured again", at=book)).out
    assert f"files restore {first}" in said
    configure(book, f'{GRAIN}sheet = "flasks.csv"\n[studies.field]\nsheet = "flasks.csv"\n')
    assert asked(book, "compaction") == asked(book, "compaction", "../later.csv", "--grain", "3.4")
    refused(labbook("study", "field", at=book), 2, "flask_sheet", "walk_sheet")
