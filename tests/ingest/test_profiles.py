"""Profiles: which one applies, before a format is recognised, and each thing that one can say."""

from __future__ import annotations

import gzip
import unicodedata
from dataclasses import replace

import numpy as np
import pytest

from data_schema.vocabulary import ChargeMode
from ingest.model import ColumnDeclaration, Declarations, Profile, ReadFile
from ingest.read import read_file
from tests.helpers.wording import says
from tests.ingest.reading import finding, only_part, refusal, rules, values
from tests.ingest.synthetic import text

HEIGHT = ColumnDeclaration("body_height", "mm")
MILLISECONDS = ColumnDeclaration("time", "ms")
ROWS = [f"{4 * k};{400 + k % 7};{k % 3}" for k in range(60)]


def read(data: bytes, *profiles: Profile, name: str = "r001.csv", **declared: object) -> ReadFile:
    return read_file(data, replace(Declarations(profiles=profiles, file_name=name), **declared))


def height(result: ReadFile) -> np.ndarray:
    assert only_part(result).rate_hz == pytest.approx(250.0)
    return values(result)["body_height"]


def test_a_profile_names_columns_however_their_letters_are_composed() -> None:
    parted = unicodedata.normalize("NFD", "Höhe")
    profile = Profile("p", (parted,), columns={"t": MILLISECONDS, parted: HEIGHT})
    assert np.array_equal(height(read(text("t;Höhe;x", ROWS), profile)), EXPECTED)


EXPECTED = np.array([0.4 + k % 7 / 1000 for k in range(60)])
BY_PLACE = {"1": MILLISECONDS, "2": HEIGHT}


@pytest.mark.parametrize(
    ("data", "profile"),
    [
        (text("t;h;x", ROWS), Profile("p", ("t", "h"), columns={"t": MILLISECONDS, "h": HEIGHT})),
        (text("t;h;x", ROWS), Profile("p", files="R*.csv", columns={"t": MILLISECONDS, "h": HEIGHT})),
        (text("t;z;z", ROWS), Profile("p", files="*", columns={"t": MILLISECONDS, "z#1": HEIGHT})),
        (text("t;z;z", ROWS), Profile("p", files="*", columns=BY_PLACE)),
        ("\n".join(ROWS).encode(), Profile("p", files="r*", columns=BY_PLACE)),
        (text("1;2;3", ROWS), Profile("p", files="r*", header_row=0, first_row=2, columns=BY_PLACE)),
        (
            text("7;8;9\nt;h;x\nms;mm;-\n1;2;3", ROWS),
            Profile("p", files="*", header_row=2, units_row=3, first_row=5, columns={"h": HEIGHT}),
        ),
        (
            text("t;h;x", ["8;9;9", *ROWS, "END OF LOG", "8;9;9"]),
            Profile("p", ("h",), first_row=3, footer="END", columns={"t": MILLISECONDS, "h": HEIGHT}),
        ),
        (
            text("'a;b;c\nt;h;x", [*ROWS[:30], "' 1;2;3", *ROWS[30:]]),
            Profile("p", ("h",), comment="'", columns={"t": MILLISECONDS, "h": HEIGHT}),
        ),
        (
            text("t~h~x", [row.replace(";", "~") for row in ROWS]),
            Profile("p", ("h",), delimiter="~", columns={"t": MILLISECONDS, "h": HEIGHT}),
        ),
        (
            text("t;Höhe;x", ROWS).decode().encode("cp850"),
            Profile("p", ("Höhe",), encoding="cp850", columns={"t": MILLISECONDS, "Höhe": HEIGHT}),
        ),
        (
            text("h;x", [row.partition(";")[2] for row in ROWS]),
            Profile("p", ("h",), rate_hz=250, columns={"h": HEIGHT}),
        ),
    ],
    ids=[
        "by columns", "by file name", "equal names", "by place", "no header", "header to be ignored", "rows", "footer",
        "comment", "delimiter", "page", "rate",
    ],
)  # fmt: skip
def test_profile_says_how_a_file_is_read(data: bytes, profile: Profile) -> None:
    result = read(data, profile)
    assert height(result) == pytest.approx(EXPECTED)
    assert result.profile == "p"
    declared = result.declared
    assert declared is not None
    assert declared.profiles == ()
    again = read_file(data, declared)
    assert height(again) == pytest.approx(EXPECTED)
    assert (again.profile, again.declared) == ("p", declared)


def test_more_columns_win_then_the_longer_pattern_and_equal_ones_are_refused() -> None:
    data = text("t;h;x", ROWS)
    said = {"t": MILLISECONDS, "h": HEIGHT}
    two = Profile("two", ("t", "h"), columns=said)
    by_name = Profile("by_name", ("t",), "r0*.csv", columns=said)
    longer = Profile("longer", ("t",), "r001*.csv", columns=said)
    assert read(data, by_name, two).profile == "two"
    assert read(data, by_name, longer).profile == "longer"
    assert read(data, by_name, name="other.csv").profile is None
    refused = read(data, two, replace(two, name="other"))
    assert refusal(refused).rule == "profile_ambiguous"
    says(refusal(refused).message, "'two' and 'other'")
    assert read(data, two, replace(two, name="other"), profile="other").profile == "other"


def test_flags_stand_over_the_profile_column_by_column() -> None:
    columns = {"t": MILLISECONDS, "h": ColumnDeclaration("x", "mm", -1)}
    profile = Profile("p", ("t", "h"), rate_hz=1.0, columns=columns)
    said = {"h": ColumnDeclaration("body_height", None)}
    assert height(read(text("t;h;x", ROWS), profile, columns=said, rate_hz=250.0)) == pytest.approx(-EXPECTED)


@pytest.mark.parametrize(
    "said",
    [
        {"t": ColumnDeclaration(None, "ms")},
        {"t": ColumnDeclaration("time", "ms")},
        {"t": ColumnDeclaration("own_clock"), "x": ColumnDeclaration("time", "ms")},
        {"x": ColumnDeclaration("time", "ms")},
    ],
    ids=["unit", "column", "another column", "another column alone"],
)
def test_flags_stand_over_the_time_of_a_profile(said: dict[str, ColumnDeclaration]) -> None:
    """A profile's `time` stood over `--unit` and `--column`, and `--explain` said `declared, or profile`."""
    rows = [f"{4 * k};{400 + k % 7};{4 * k}" for k in range(60)]
    profile = Profile("p", ("t", "h"), time_column="t", time_unit="s", columns={"h": HEIGHT})
    result = read(text("t;h;x", rows), profile, columns=said)
    assert height(result) == pytest.approx(EXPECTED)
    (time,) = [column for column in result.explanation.tables[0].columns if column.holds == "time"]
    assert (time.unit, time.unit_from) == ("ms", "declared")
    assert read(text("t;h;x", rows), profile).refused


GERMAN = """Ladebuch 2021
Akku;Versuch;Kapazität;geladen;Dauer;Spannung;Programm
A;r001;6600;812,5;61:30;16,81;Laden
B;r002;6600;790,0;60:00;16,80;Laden
Summe;;;1602,5;;;
"""
GERMAN_COLUMNS = {
    "Akku": ColumnDeclaration("pack"),
    "Versuch": ColumnDeclaration("run"),
    "geladen": ColumnDeclaration("charge", "mAh"),
    "Dauer": ColumnDeclaration("duration", "min"),
    "Spannung": ColumnDeclaration("end_voltage", "V"),
}


def test_charger_sheet_of_any_language_and_order() -> None:
    profile = Profile("ladebuch", ("Versuch", "geladen"), format="charger_sheet", columns=GERMAN_COLUMNS)
    result = read(GERMAN.encode("cp1252"), profile)
    assert not result.refused, result.findings
    first, second = result.charges
    assert (first.stated_run, first.stated_pack, first.charge_mah, first.duration_s) == ("r001", "A", 812.5, 3690.0)
    assert (second.end_voltage_v, second.mode) == (16.8, ChargeMode.CHARGE)


def test_a_recharge_ended_at_a_date_of_any_order_in_one_column_or_two() -> None:
    columns = {"Tag": ColumnDeclaration("date"), "Uhr": ColumnDeclaration("ended")}
    sheet = "run;mAh;Tag;Uhr\nr001;812;3.4.2021;14:30\nr002;790;3.4.2021;15:10\n"
    (first, _) = read(sheet.encode(), columns=columns, time_zone="UTC").charges
    assert (first.ended_original, first.ended_utc) == ("3.4.2021 14:30", "2021-04-03T14:30:00.000000Z")
    unclear = sheet.replace("3.4.2021", "3/4/2021").encode()
    result = read(unclear, columns=columns, time_zone="UTC")
    assert [charge.ended_utc for charge in result.charges] == [None, None]
    says(finding(result, "date_unclear").message, "--dates")
    (first, _) = read(unclear, columns=columns, time_zone="UTC", date_format="m/d/y").charges
    assert first.ended_utc == "2021-03-04T14:30:00.000000Z"


@pytest.mark.parametrize(("header", "header_row"), [("", 0), ("a;b;c;d;e;f;g\n", None)], ids=["no header", "a header"])
def test_charger_sheet_by_place(header: str, header_row: int | None) -> None:
    rows = "\n".join(GERMAN.splitlines()[2:4]) + "\n"
    columns = {"2": ColumnDeclaration("run"), "4": ColumnDeclaration("charge", "mAh")}
    profile = Profile("bare", files="*.csv", format="charger_sheet", header_row=header_row, columns=columns)
    result = read((header + rows).encode(), profile)
    assert [(charge.stated_run, charge.charge_mah) for charge in result.charges] == [("r001", 812.5), ("r002", 790.0)]


def test_file_declared_a_sheet_without_charges_is_refused_with_what_to_say() -> None:
    result = read(text("a;b", ["1;2"]), format="charger_sheet")
    says(finding(result, "charge_column_missing").message, "--column")


@pytest.mark.parametrize("names", [["left", "right", "left"], ["1", "2", "1"]], ids=["words", "numbers"])
def test_trials_in_one_file_are_told_apart_by_a_column(names: list[str]) -> None:
    rows = [f"{4 * k},{400 + k % 7},{name}" for name in names[:2] for k in range(60)]
    result = read(text("t [ms],body height [mm],trial", rows), trials="trial")
    assert not result.refused, result.findings
    assert [part.part for part in result.parts] == [f"trial_{name}" for name in names[:2]]
    for part in result.parts:
        assert (len(part.time_s), part.rate_hz) == (60, pytest.approx(250.0))
    absent = read(text("t [ms],body height [mm]", ["0,1", "4,1"]), trials="trail")
    assert refusal(absent).rule == "trial_column_absent"


def test_profile_by_file_name_acts_inside_an_archive() -> None:
    profile = Profile("ladebuch", files="*.gz", format="charger_sheet", columns=GERMAN_COLUMNS)
    result = read(gzip.compress(GERMAN.encode("cp1252")), profile, name="lade.csv.gz")
    assert not result.refused, result.findings
    assert (result.format, len(result.charges), result.profile) == ("gzip", 2, "ladebuch")


@pytest.mark.parametrize(
    ("said", "rule", "severity", "line", "words"),
    [
        ({"footer": "1"}, "footer_ends_data", "row", 5, "56 of 56"),
        ({"footer": "20;"}, "footer_ends_data", "row", 7, "54 of 54"),
        ({"comment": "1"}, "comment_like_data", "row", 5, "'1'"),
    ],
)
def test_rows_that_a_mistaken_footer_or_comment_takes_are_reported(
    said: dict[str, str], rule: str, severity: str, line: int, words: str
) -> None:
    result = read(text("t;h;x", ROWS), Profile("p", ("h",), columns={"t": MILLISECONDS, "h": HEIGHT}, **said))
    found = finding(result, rule)
    assert (found.severity, found.line) == (severity, line)
    assert words in found.message


def test_a_footer_before_words_is_noted_and_one_at_the_end_or_a_true_comment_is_not() -> None:
    profile = Profile("p", ("h",), footer="END", comment="'", columns={"t": MILLISECONDS, "h": HEIGHT})
    rows = [*ROWS, "' 1;2;3", "END OF LOG"]
    said = {"footer_ends_data", "comment_like_data"}
    assert not said & rules(read(text("t;h;x", rows), profile))
    (found,) = [f for f in read(text("t;h;x", [*rows, "mean 3.4"]), profile).findings if f.rule in said]
    assert (found.severity, found.line) == ("note", 63)
