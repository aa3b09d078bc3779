"""Hand-kept charger sheets: spellings, units, decimal signs, modes, unfinished rows; all synthetic."""

from __future__ import annotations

from dataclasses import replace

import pytest

from ingest.model import ColumnDeclaration, Declarations, PackFacts, ReadFile
from ingest.read import read_file
from tests.helpers.wording import says
from tests.ingest.reading import finding, rules
from tests.ingest.synthetic import SHEET


def read(text: str, declared: Declarations | None = None) -> ReadFile:
    return read_file(text.encode(), declared or Declarations(time_zone="America/New_York"))


WITH_PACK = Declarations(time_zone="America/New_York", packs=(PackFacts("A", 6600.0),))


def test_labbooks_own_sheet() -> None:
    result = read(SHEET)
    assert (result.format, result.role, result.findings) == ("charger_sheet", "charge", ())
    first, _, third = result.charges
    assert (first.row_number, first.stated_run, first.stated_pack) == (1, "r001", "A")
    assert (first.charge_mah, first.resolution_mah, first.end_voltage_v) == (461.0, 1.0, 16.8)
    assert (first.duration_s, third.duration_s) == (750.0, 750.0)  # 12.5 and 12:30
    assert first.mode == "charge"


@pytest.mark.parametrize(
    "sheet",
    [
        "Run;Charge (Ah);Duration [min];End V (mV);Battery\nr001;0,461;12,5;16800;A\n",
        "experiment\tCharge mAh\ttime (s)\tvoltage [V]\tpack id\nr001\t461\t750\t16.8\tA\n",
        "Charger sheet of June\n\nrun no,charge,time,v end,lipo\nr001,461 mAh,12.5 min,16.8 V,A\n",
        "#run,mAh,minutes,end_voltage,pack,remarks\nr001,461,0:12:30,16.8,A,\"warm, but fine\"\n",
        'run,mAh,minutes,end_voltage,pack\nr001,"461,0","12,5","16,8",A\n',
        "run|mah_in|hours|volts|accu\nr001|461|0:12:30|16.8|A\n".replace("mah_in", "mAh in"),
    ],
)  # fmt: skip
def test_other_spellings_units_and_signs_say_the_same(sheet: str) -> None:
    result = read(sheet)
    assert not result.refused, result.findings
    (charge,) = result.charges
    assert (charge.stated_run, charge.stated_pack) == ("r001", "A")
    assert charge.charge_mah == pytest.approx(461.0)
    assert charge.duration_s == pytest.approx(750.0)
    assert charge.end_voltage_v == pytest.approx(16.8)


def test_a_sheet_without_units_is_asked_for_each() -> None:
    result = read("run,charge,duration,voltage\nr1,461,12,16.8\n")
    missing = [found for found in result.findings if (found.rule, found.severity) == ("unit_missing", "file")]
    assert len(missing) == 3
    says(missing[0].message, '--column "charge=charge:UNIT"', "mAh, Ah")


def test_declared_columns_complete_a_header() -> None:
    declared = Declarations(columns={"what": ColumnDeclaration("charge", "Ah"), "no": ColumnDeclaration("run")})
    (charge,) = read("no,what\n7,0.461\n", declared).charges
    assert charge.stated_run == "7"
    assert charge.charge_mah == pytest.approx(461.0)


def test_the_resolution_is_that_of_the_finest_reading() -> None:
    result = read("run,Ah\nr1,0.47\nr2,0.461\n")
    assert [charge.resolution_mah for charge in result.charges] == [pytest.approx(1.0)] * 2


@pytest.mark.parametrize(
    ("row", "rule"),
    [
        ("r9,-461,charge", "charge_sign"),
        ("r9,-461,", "charge_sign"),
        ("r9,461,fast", "mode_unknown"),
        ("r9,ERR,charge", "not_a_number"),
        ('r9,"39,l",charge', "not_a_number"),
        ("r9,461 V,charge", "unit_differs"),
        ("r9,999999,charge", "out_of_range"),
        ("r9,1.234,charge", "thousands_separator"),
        ('r9,"1,234",charge', "decimal_sign_unclear"),
        ("r9,8581,charge", "charge_implausible"),
        ("r9,461,charge,more", "ragged_row"),
        ('r9,"461,charge', "quote_unbalanced"),
    ],
)
def test_a_row_that_cannot_be_read_is_left_out_and_named(row: str, rule: str) -> None:
    rows = [f"r{number},461,charge" for number in range(36)]
    result = read("\n".join(["run,mAh,mode", *rows[:20], row, *rows[20:]]) + "\n", WITH_PACK)
    first = result.findings[0]
    assert (first.severity, first.rule, first.line, first.count) == ("row", rule, 22, 1)
    assert (result.rows_kept, result.rows_rejected, result.refused) == (36, 1, False)
    assert [charge.row_number for charge in result.charges] == list(range(1, 37))


def test_a_last_row_that_lacks_its_unit_is_left_out() -> None:
    rows = "".join(f"r{number},461 mAh\n" for number in range(36))
    result = read(f"run,charge\n{rows}r36,461\n")
    assert (result.findings[0].rule, result.findings[0].line) == ("unit_missing", 38)
    assert (result.rows_kept, result.rows_rejected, result.refused) == (36, 1, False)


def test_a_sheet_of_which_most_rows_cannot_be_read_is_refused() -> None:
    """`2,1` of Ah between commas is the charge 2 of a pack called 1, where one row seems whole."""
    result = read("run,Ah,pack\nr1,0,461,A\nr2,0,47,B\nr3,2,1\n")
    assert result.refused
    assert {"ragged_row", "too_many_rejected"} <= rules(result)


def test_a_day_that_the_calendar_lacks_is_said_with_its_line() -> None:
    """It was `'31.02.2024 11:35' is no ISO date and time`, of a sheet read as d.m.y."""
    declared = Declarations(time_zone="America/New_York", date_format="d.m.y")
    result = read("run,mAh,ended\nr1,461,28.02.2024 11:35\nr2,461,31.02.2024 11:35\n", declared)
    assert [charge.ended_utc for charge in result.charges] == ["2024-02-28T16:35:00.000000Z", None]
    unknown = finding(result, "instant_unknown")
    assert unknown.line == 3
    says(unknown.message, "31.02.2024", "d.m.y")


@pytest.mark.parametrize("minutes", ["0", "0:00"])
def test_a_recharge_that_took_no_time_is_left_out(minutes: str) -> None:
    """The book has no place for it: its sheet could not be stored."""
    rows = [f"r{number},461,90" for number in range(200)]
    result = read("\n".join(["run,mAh,minutes", *rows, f"r200,461,{minutes}", "r201,461,90"]) + "\n")
    assert (result.rows_kept, result.rows_rejected, result.refused) == (201, 1, False)
    assert "out_of_range" in rules(result)


def test_all_that_is_wrong_in_a_row_is_reported() -> None:
    result = read("run,mAh,minutes,end_voltage,mode\nr1,ERR,x,1680,fast\n")
    assert {"not_a_number", "out_of_range", "mode_unknown", "no_rows_kept"} <= rules(result)


def test_a_discharge_may_be_negative_and_is_stored_positive() -> None:
    (charge,) = read("run,mAh,mode\nr1,-461,Discharge\n").charges
    assert (charge.charge_mah, charge.mode) == (461.0, "discharge")


def test_totals_comments_and_rows_not_filled_in_are_no_recharges() -> None:
    result = read("run,mAh,pack\nr1,461,A\n# battery B is new\nr2,,B\n,,\n\nTotal,461,\n")
    assert (len(result.charges), result.rows_read, result.refused) == (1, 1, False)
    assert {"summary_row", "row_not_filled", "comment_line"} <= rules(result)


def test_only_a_hash_begins_a_comment() -> None:
    result = read("run,mAh,pack\n#r1,461,A\n%r2,462,A\n//r3,463,A\n")
    assert [(charge.stated_run, charge.charge_mah) for charge in result.charges] == [("%r2", 462.0), ("//r3", 463.0)]
    assert rules(result) == {"comment_line"}


def test_a_header_in_two_lines_that_stands_again_is_skipped() -> None:
    header = 'run,"charged\n(mAh)",pack\n'
    result = read(f'{header}r1,461,A\n{header}r2,470,"B\nold"\n')
    assert [(charge.stated_run, charge.stated_pack, charge.line) for charge in result.charges] == [
        ("r1", "A", 3),
        ("r2", "B old", 6),
    ]
    assert rules(result) == {"header_repeated"}


def test_a_decimal_comma_that_may_group_thousands_is_asked_for() -> None:
    sheet = "run;mAh\nr1;1,234\nr2;2,345\n"
    assert "decimal_sign_unclear" in rules(read(sheet))
    assert "thousands_separator" in rules(read(sheet, Declarations(decimal_sign=",")))


@pytest.mark.parametrize("declared", [Declarations(), Declarations(decimal_sign=",")])
def test_ampere_hours_under_a_heading_of_mah_are_no_thousands(declared: Declarations) -> None:
    """It was `thousands_separator ... export without them`, though 0,108 has none."""
    sheet = "Run;Charged mAh\nr1;0,17\nr2;0,108\nr3;0,106\n"
    refused = read(sheet, declared)
    assert refused.refused
    assert "thousands_separator" not in rules(refused)
    says(finding(refused, "out_of_range").message, "charge:Ah", "--override-units")
    columns = {"Charged mAh": ColumnDeclaration("charge", "Ah")}
    result = read(sheet, replace(declared, columns=columns, override_units=True))
    assert [charge.charge_mah for charge in result.charges] == pytest.approx([170.0, 108.0, 106.0])


def test_times_are_local_to_the_book() -> None:
    never, twice = "2021-03-14 02:30", "2021-11-07 01:30"  # summer time begins and ends
    ends = {"2021-06-05 14:30": "2021-06-05T18:30:00.000000Z", "05/06/2021 14:30": None, never: None, twice: None}
    result = read("run,mAh,ended\n" + "".join(f"r1,461,{end}\n" for end in ends))
    assert {charge.ended_original: charge.ended_utc for charge in result.charges} == ends
    assert {"instant_unclear", "date_unclear"} <= rules(result)


def test_a_run_with_two_recharges_keeps_both() -> None:
    result = read("run,mAh\nr1,461\nr1,20\n")
    assert len(result.charges) == 2
    assert "run_repeated" in rules(result)


def test_cells_that_a_spreadsheet_would_run_stay_plain_text() -> None:
    (charge,) = read("run,mAh\n=cmd|'/c calc'!A0,461\n").charges
    assert charge.stated_run == "=cmd|'/c calc'!A0"


def test_a_log_with_a_charge_column_is_no_sheet() -> None:
    rows = "\n".join(f"{1000 * second},{second},{16.0 + second / 1000:.3f}" for second in range(100))
    for log in (f"time [ms],charge [mAh],battery [V]\n{rows}\n", "time,mAh\n1,2\n2,3\n3,4\n"):
        assert read(log).format == "delimited_log"
    assert read(f"time [ms],trial,energy [Wh]\n{rows}\n").format == "delimited_log"


@pytest.mark.parametrize("name", ["beendet um", "fertig um", "Ende [m]"])
def test_a_declared_column_is_used_whatever_its_name_ends_in(name: str) -> None:
    said = {"Datum": ColumnDeclaration("date"), name: ColumnDeclaration("ended")}
    declared = Declarations(columns=said, date_format="d.m.y", time_zone="America/New_York")
    (charge,) = read(f"run,Datum,{name},mAh\nr1,05.06.2021,09:30,461\n", declared).charges
    assert charge.ended_utc == "2021-06-05T13:30:00.000000Z"


def test_a_declared_column_in_a_unit_of_another_quantity_is_refused() -> None:
    result = read("run,in [V],minutes\nr1,461,12\n", Declarations(columns={"in [V]": ColumnDeclaration("charge")}))
    assert "unit_not_convertible" in rules(result)
    assert result.refused


@pytest.mark.parametrize(
    "sheet",
    [
        "run,date,ended,charge (mAh)\nr1,2021-06-05,09:30,461\n",
        "run,date,end time,charge (mAh)\nr1,2021-06-05,09:30,461\n",
        "run,ended,date,charge (mAh)\nr1,09:30,2021-06-05,461\n",
        "run,ended,date,charge (mAh)\nr1,2021-06-05 09:30,2021-06-04,461\n",
        "run,when,ended,charge (mAh)\nr1,2021-06-05 09:00,2021-06-05 09:30,461\n",
        "run,date,charge (mAh)\nr1,2021-06-05 09:30,461\n",
    ],
)
def test_the_end_of_a_recharge_with_its_date_in_any_order_of_columns(sheet: str) -> None:
    (charge,) = read(sheet).charges
    assert charge.ended_utc == "2021-06-05T13:30:00.000000Z"


@pytest.mark.parametrize("said", [{}, {"over": ColumnDeclaration("ended"), "out": ColumnDeclaration("ended")}])
def test_two_columns_that_may_both_be_the_end_are_refused(said: dict[str, ColumnDeclaration]) -> None:
    header = "over,out" if said else "ended,end time"
    result = read(f"run,{header},mAh\nr1,2021-06-05 09:30,2021-06-05 11:30,461\n", Declarations(columns=said))
    assert "column_ambiguous" in rules(result)
    assert result.refused


@pytest.mark.parametrize("rows", ["1,1.12,1\n2,1.05,1\n", "r001,1.12,A\nr002,1.05,B\n"])
@pytest.mark.parametrize("heading", ["energy_Wh", "charge (Wh)", "E [kJ]", "Wh"])
def test_a_sheet_of_energies_asks_for_charges_and_not_for_a_rate(heading: str, rows: str) -> None:
    result = read(f"run,{heading},pack\n{rows}")
    assert rules(result) == {"charge_column_missing"}
    columns = {heading: ColumnDeclaration("charge", "mAh")}
    as_said = Declarations(columns=columns, override_units=True, time_zone="UTC")
    assert [charge.charge_mah for charge in read(f"run,{heading},pack\n{rows}", as_said).charges] == [1.12, 1.05]


ASKED: dict[str, tuple[str, list[str], dict[str, ColumnDeclaration], str, list[object]]] = {
    "no runs": (
        "name,mAh,minutes\nr001,112,10\nr002,105,10\n",
        ['--column "name=run" --column "mAh=charge:mAh"'],
        {"name": ColumnDeclaration("run")},
        *("stated_run", ["r001", "r002"]),
    ),
    "words not known here": (
        "Lauf;Ladung in mAh;Akku\nr001;112;A\nr002;105;B\n",
        ['--column "Lauf=run" --column "Ladung=charge:mAh"'],
        {"Lauf": ColumnDeclaration("run"), "Ladung in mAh": ColumnDeclaration("charge", "mAh")},
        *("charge_mah", [112.0, 105.0]),
    ),
    "clock times": (
        "run,mAh,charge time\nr001,112,12:30\nr002,105,13:30\n",
        ['--column "charge time=duration:UNIT"', "one of min, h)"],
        {"charge time": ColumnDeclaration("duration", "min")},
        *("duration_s", [750.0, 810.0]),
    ),
    "no such charges": (
        "run,capacity_Ah\nr001,812\nr002,805\n",
        ["=charge:mAh", "--override-units"],
        {"capacity_Ah": ColumnDeclaration("charge", "mAh")},
        *("charge_mah", [812.0, 805.0]),
    ),
    **{
        f"no such {heading}": (
            f"run,mAh,{heading}\nr001,112,{value}\n",
            [f"={role}:{unit}", "--override-units"],
            {heading: ColumnDeclaration(role, unit)},
            *(stored, [pytest.approx(number)]),
        )
        for heading, value, role, unit, stored, number in (
            ("end voltage (mV)", "16.8", "end_voltage", "V", "end_voltage_v", 16.8),
            ("end voltage (V)", "16800", "end_voltage", "mV", "end_voltage_v", 16.8),
            ("time (h)", "720", "duration", "s", "duration_s", 720.0),
        )
    },
}


@pytest.mark.parametrize(("text", "facts", "columns", "stored", "values"), ASKED.values(), ids=ASKED)
def test_what_a_sheet_lacks_or_has_wrong_is_asked_for_by_flags_that_read_it(
    text: str, facts: list[str], columns: dict[str, ColumnDeclaration], stored: str, values: list[object]
) -> None:
    says([finding.message for finding in read(text).findings], *facts)
    declared = Declarations(columns=columns, override_units="--override-units" in facts, time_zone="UTC")
    assert [getattr(charge, stored) for charge in read(text, declared).charges] == values
