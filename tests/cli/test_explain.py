"""`labbook ingest --explain` and `--draft-profile`: how a file is read and why, and the profile of one that is not."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.cli.shell import good, labbook, refused, rows, unchanged
from tests.helpers.books import SmallBook
from tests.helpers.wording import says


@pytest.fixture
def odd(tmp_path: Path) -> Path:
    """A log of which neither the unit of time nor the height is said, with two columns of one name."""
    path = tmp_path / "r001_odd.txt"
    lines = [f"{4 * k};{400 + k % 7},5;{k % 3};ok" for k in range(600)]
    path.write_text("\n".join(["Logger 3", "rate 250 Hz", "t;z;z;note", *lines]) + "\n")
    return path


def test_explain_says_how_a_file_is_read_and_stores_nothing(fresh: SmallBook, odd: Path) -> None:
    said = ["--unit", "t=ms", "--column", "z#1=body_height:mm"]
    with unchanged(fresh.folder):
        (told,) = good(labbook("ingest", odd, *said, "--explain", "--json", at=fresh.folder)).json
        lines = good(labbook("ingest", odd, *said, "--explain", at=fresh.folder)).out
    assert (told["format"], told["refused"], told["run"], told["run_known"]) == ("delimited_log", False, "r001", False)
    (table,) = told["explanation"]["tables"]
    assert table["text"] == {
        "delimiter": ";", "decimal": ",", "header_line": 3, "units_line": None, "first_line": 4,
    }  # fmt: skip
    assert "'t'" in table["rate_from"]
    time, height, other, note = table["columns"]
    assert (time["holds"], time["unit"], time["unit_from"]) == ("time", "ms", "declared")
    assert (height["holds"], height["unit"], height["stored_unit"]) == ("body_height", "mm", "m")
    assert (other["holds"], note["holds"]) == ("z", None)
    (part,) = told["parts"]
    assert (part["samples"], round(part["rate_hz"], 6), part["gaps"]) == (600, 250.0, 0)
    facts = ("delimiter ';'", "header in line 3", "body_height", "600 samples", "250 Hz", "run r001")
    assert all(fact in lines for fact in facts)
    refused_too = labbook("ingest", odd, "--explain", at=fresh.folder)
    assert (refused_too.code, refused_too.err) == (2, "")
    assert all(fact in refused_too.out for fact in ("would be refused", "time_unit_missing", "header in line 3"))


def test_explain_names_format_profile_and_the_next_likely_one(fresh: SmallBook, tmp_path: Path) -> None:
    path = tmp_path / "sheet.csv"
    path.write_text("run,mAh,minutes\nr001,812,61\n")
    (told,) = good(labbook("ingest", path, "--explain", "--json", at=fresh.folder)).json
    assert [each["format"] for each in told["explanation"]["candidates"]] == ["charger_sheet", "delimited_log"]
    assert [charge["charge_mah"] for charge in told["charges"]] == [812.0]
    (table,) = told["explanation"]["tables"]
    assert [column["holds"] for column in table["columns"]] == ["run", "charge", "duration"]


def edited(draft: str, *changes: tuple[str, str]) -> str:
    """A draft with the # before some keys taken away, and their values changed."""
    for key, value in changes:
        pattern = rf'(?m)^#?("?{re.escape(key)}"?) = .*$'
        draft, found = re.subn(pattern, lambda m, v=value: f"{m[1]} = {v}", draft, count=1)
        assert found == 1, key
    return draft


HEIGHT = '{ channel = "body_height", unit = "mm" }'
OF_SHEET = ("run,charge,pack,duration", "r001,812,A,61", "r002,790,B,60")
GERMAN = [f"r{n:03};{n:02}.09.2021;08:{n:02};{70 + n},8;16,7{n};A" for n in range(1, 8)]
STAMPED = [f"{400 + k % 7};5.6.2021 14:30:{k // 100:02d}.{k % 100:02d}" for k in range(600)]
DRAFTS = {
    "log": (
        (),
        ["#time = "],
        [("time", '{ column = "t", unit = "ms" }'), ("z#1", HEIGHT)],
        ("SELECT source_unit FROM channel WHERE name = 'body_height'", [("mm",)]),
    ),
    "log with dates": (
        ("z;Datum", *STAMPED),
        ['column = "Datum"'],
        [("time", '{ column = "Datum" }'), ("z", HEIGHT)],
        ("SELECT round(rate_hz) FROM signal", [(100.0,)]),
    ),
    "sheet": (  # the charge was declared without a unit, as if that were settled
        OF_SHEET,
        ['#"charge" = ', '#"duration" = ', '\n"run" = { channel = "run" }\n', '"pack" = { channel = "pack" }\n'],
        [("charge", '{ channel = "charge", unit = "mAh" }'), ("duration", '{ channel = "duration", unit = "min" }')],
        ("SELECT charge_mah, duration_s FROM charge", [(812.0, 3660.0), (790.0, 3600.0)]),
    ),
    "sheet in other words": (  # its first column was drafted as the time, and every other as a charge
        ("Versuch;Tag;beendet;geladen (mAh);Endspannung (V);Akku", *GERMAN),
        [],
        [("Versuch", '{ channel = "run" }')],
        ("SELECT count(*), round(sum(charge_mah), 6) FROM charge", [(7, 523.6)]),
    ),
}


@pytest.mark.parametrize("kind", DRAFTS)
def test_a_draft_is_a_profile_already_and_works_when_filled_in(kind: str, fresh: SmallBook, odd: Path) -> None:
    lines, drafted, filled_in, (query, expected) = DRAFTS[kind]
    if lines:
        odd.write_text("\n".join([*lines, ""]))
    assert labbook("ingest", odd, at=fresh.folder).code == 2
    with unchanged(fresh.folder):
        draft = good(labbook("ingest", odd, "--draft-profile", at=fresh.folder)).out
    assert all(part in draft for part in drafted)
    assert ("time" in draft) is ("log" in kind)
    before = fresh.toml.read_text()
    fresh.toml.write_text(before + draft)
    still_open = labbook("ingest", odd, "--dry-run", at=fresh.folder).code
    assert still_open == (0 if kind == "sheet in other words" else 2)  # recharges may be of no run
    fresh.toml.write_text(before + edited(draft, *filled_in))
    good(labbook("ingest", odd, at=fresh.folder))
    assert rows(fresh.folder, query) == expected
    good(labbook("rebuild", at=fresh.folder))
    assert rows(fresh.folder, query) == expected


def test_a_column_of_a_log_that_is_called_as_one_of_a_sheet_is_left_open(fresh: SmallBook, tmp_path: Path) -> None:
    path = tmp_path / "r7.csv"
    rows = (f"{n * 5},{400 + n % 7},{12.1 - n / 1000:.3f}" for n in range(200))
    path.write_text("\n".join(["t_ms,pot [mm],pack [V]", *rows]) + "\n")
    draft = good(labbook("ingest", path, "--draft-profile", at=fresh.folder)).out
    says(draft, '#"pack [V]" = { channel = "own.')


def test_words_that_are_none_are_refused_with_the_nearest(fresh: SmallBook, odd: Path) -> None:
    for flag, given, named in (
        ("--format", "delimited", "delimited_log"),
        ("--dates", "dd.mm.y", "d.m.y"),
        ("--clock", "mm:ss", "m:s"),
        ("--axes", "y", "y up"),
        ("--profile", "serial", "profile"),
        ("--delimiter", "a", "delimiter"),
    ):
        refused(labbook("ingest", odd, flag, given, "--dry-run", at=fresh.folder), 2, repr(given), named)


@pytest.mark.parametrize("flag", ["--explain", "--draft-profile"])
def test_what_is_only_told_keeps_to_the_limits(flag: str, fresh: SmallBook, odd: Path) -> None:
    with fresh.toml.open("a") as toml:
        toml.write("\n[files.limits]\nlargest_file_bytes = 1000\n")
    refused(labbook("ingest", odd, flag, at=fresh.folder), 2, "largest_file_bytes")
