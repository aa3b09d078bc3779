"""One reader for every sheet: runs, recharges, studies, tables for statistics and logs say the same in any form."""

from __future__ import annotations

import codecs
import contextlib
import datetime
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

from data_schema.errors import InputRefused, UnknownName, UsageError
from ingest.formats.study_sheets import read_flasks
from ingest.model import Declarations
from ingest.read import read_file
from ingest.tables.sheet import Sheet, SheetFile, SheetRefused, decimal_sign, numbers_of, read_sheet
from labbook.actions.stats.answering import observe
from labbook.actions.stats.asked import Values
from labbook.plan.drawing import PlanFactor
from labbook.plan.sheet_reader import read_run_sheet
from tests.helpers.wording import refuses, says
from tests.ingest.synthetic_workbooks import Rows, ods, workbook

Content = list[tuple[object, ...]]
FACTORS = (PlanFactor("foot", ("Füße", "large")), PlanFactor("gain", ("300", "62.5"), control="300"))


def run_sheet(data: bytes) -> Content:
    rows, _page = read_run_sheet(SheetFile("sheet", data), FACTORS)
    return [
        (row.name, row.date.isoformat(), row.levels["foot"], float(row.levels["gain"]), row.duration_s) for row in rows
    ]


def recharges(data: bytes) -> Content:
    found = read_file(data, Declarations(file_name="sheet"))
    assert not [finding for finding in found.findings if finding.severity != "note"], found.findings
    return [
        (charge.stated_run, charge.stated_pack, charge.charge_mah, charge.end_voltage_v) for charge in found.charges
    ]


def flasks(data: bytes) -> Content:
    sheet = read_flasks(SheetFile("sheet", data))
    assert read_file(data, Declarations(file_name="sheet")).rows_read == len(sheet.lines)
    return [
        (state, round(radius * 1e3, 9), round(water * 1e6, 9))
        for state, radius, water in zip(
            sheet.words["state"], sheet.values["radius"], sheet.values["water"], strict=True
        )
    ]


def values(data: bytes) -> Content:
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "sheet"
        file.write_bytes(data)
        asked = Values(file, value="energy_J", by="controller")
        return [(row.label, row.value) for row in observe(asked, lambda _step: None).rows]


def log(data: bytes) -> Content:
    found = read_file(data, Declarations(file_name="sheet"))
    assert not found.refused, found.findings
    assert not found.rows_rejected, found.findings
    (part,) = found.parts
    return list(
        zip(
            part.time_s.round(9).tolist(), *(channel.values.round(9).tolist() for channel in part.channels), strict=True
        )
    )


class Kind(NamedTuple):
    """A kind of sheet: what reads it, its rows with plain numbers, what is read of it, and a column of numbers."""

    read: Callable[[bytes], Content]
    rows: Rows
    content: Content
    column: str


KINDS = {
    "runs": Kind(
        run_sheet,
        [
            ["run", "date", "position", "kind", "foot", "gain", "duration_s", "jumps_made", "note"],
            ["r1", "2021-06-01", 1, "jumps", "Füße", 62.5, 720.5, 25, "a"],
            ["r2", "2021-06-01", 2, "jumps", "large", 300, 719.25, 24, "b"],
        ],
        [("r1", "2021-06-01", "Füße", 62.5, 720.5), ("r2", "2021-06-01", "large", 300.0, 719.25)],
        "duration_s",
    ),
    "recharges": Kind(
        recharges,
        [["run", "mAh", "end_voltage", "pack"], ["r1", 812.5, 8.41, "Füße"], ["r2", 799.5, 8.40, "B"]],
        [("r1", "Füße", 812.5, 8.41), ("r2", "B", 799.5, 8.4)],
        "mAh",
    ),
    "flasks": Kind(
        flasks,
        [["radius_mm", "state", "water_ml"], [15.5, "lose, weiß", 6.43], [20.5, "fest", 13.2], [25, "fest", 24.75]],
        [("lose, weiß", 15.5, 6.43), ("fest", 20.5, 13.2), ("fest", 25.0, 24.75)],
        "water_ml",
    ),
    "values": Kind(
        values,
        [["controller", "energy_J", "remark"], ["Füße", 120.25, "a"], ["CE", 131.5, "b"], ["CE", 129.75, "c"]],
        [("Füße", 120.25), ("CE", 131.5), ("CE", 129.75)],
        "energy_J",
    ),
    "log": Kind(
        log,
        [["time [s]", "body height [m]", "Größe [m]"], *([n / 100, 0.3 + n / 64, n / 8] for n in range(30))],
        [(n / 100, round(0.3 + n / 64, 9), n / 8) for n in range(30)],
        "body height [m]",
    ),
}


def text(rows: Rows, delimiter: str, decimal: str, page: str = "utf-8", mark: bytes = b"") -> bytes:
    def written(cell: object) -> str:
        shown = str(cell).replace(".", decimal) if isinstance(cell, float) else str(cell)
        return f'"{shown}"' if delimiter in shown else shown

    lines = [delimiter.join(map(written, row)) for row in rows]
    return mark + "".join(f"{line}\r\n" for line in lines).encode(page)


FORMS: dict[str, Callable[[Rows], bytes]] = {
    "comma": lambda rows: text(rows, ",", "."),
    "semicolon and decimal comma": lambda rows: text(rows, ";", ","),
    "tab": lambda rows: text(rows, "\t", "."),
    "tab and decimal comma": lambda rows: text(rows, "\t", ","),
    "UTF-8 with mark": lambda rows: text(rows, ";", ",", mark=codecs.BOM_UTF8),
    "UTF-16": lambda rows: text(rows, "\t", ",", "utf-16-le", codecs.BOM_UTF16_LE),
    "cp1252": lambda rows: text(rows, ",", ".", "cp1252"),
    "xlsx": lambda rows: workbook({"Sheet": rows}),
    "ods": lambda rows: ods({"Sheet": rows}),
}


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_sheet_says_the_same_in_every_form(kind: str, form: str) -> None:
    found = KINDS[kind].read(FORMS[form](KINDS[kind].rows))
    assert found == KINDS[kind].content


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_cell_that_is_no_number_is_named_by_file_line_and_column(kind: str, form: str) -> None:
    known = KINDS[kind]
    rows = [list(row) for row in known.rows]
    rows[2][rows[0].index(known.column)] = "1x5"
    data = FORMS[form](rows)
    if kind in ("recharges", "log"):
        found = read_file(data, Declarations(file_name="sheet")).findings
        (fault,) = [finding for finding in found if finding.value == "1x5"]
        assert (fault.line, fault.column) == (3, known.column)
        return
    with refuses(SheetRefused, "line 3 of sheet", known.column, "'1x5'") as refused:
        known.read(data)
    assert [(fault.line, fault.column) for fault in refused.value.faults] == [(3, known.column)]


def test_all_that_is_wrong_is_said_at_once() -> None:
    sheet = read_sheet(SheetFile("a.csv", b"x,x,y\n1,2\n1,2,3\n1,\x00,3\n1,2,3,4\n1,,\n"))
    with refuses(SheetRefused, "a.csv", "4 faults") as refused:
        sheet.refuse()
    assert [(fault.line, fault.column) for fault in refused.value.faults] == [(1, "x"), (2, None), (4, "x"), (5, None)]
    assert sheet.rows == (("1", "2", "3"), ("1", "", ""))


@pytest.mark.parametrize(
    ("data", "facts"),
    [
        (b"", ["a.csv", "empty"]),
        (b"\n ,, \n", ["a.csv", "empty"]),
        (b"hello\nworld\n", ["several columns"]),
        (b"a,b\n", ["a header and no rows"]),
        (b'a,b\n"1', ["line 2", "quotes"]),
        (b'a,b\n1,2\n"1"x,2\n', ["line 3", "quotes"]),
        (b"a,b\n" + b"x" * 200_000, ["line 2"]),
        (bytes(range(256)) * 4, ["neither text nor a workbook"]),
        ("a,b\n1,ü\x9d\n".encode("latin-1"), ["neither UTF-8 nor cp1252", "line 2", "--encoding"]),
        (codecs.BOM_UTF8 + b"a,b\n1,2\n1,\xfc\n", ["neither UTF-8 nor cp1252", "line 3", "--encoding"]),
        (workbook({"One": [["a", "b"], [1, 2]], "Two": [["a", "b"], [1, 2]]}), ["2 sheets", "One, Two"]),
        (workbook({"One": [["a", "b"], [1, 2]]})[:300], ["workbook"]),
    ],
)
def test_what_is_no_sheet_is_refused_in_one_sentence(data: bytes, facts: Sequence[str]) -> None:
    with refuses(InputRefused, "a.csv", *facts) as refused:
        read_sheet(SheetFile("a.csv", data)).refuse()
    assert "\n" not in str(refused.value)


@given(st.text('run,date\n"\r;\t0123\x00\u2028', max_size=80))
def test_any_text_is_read_or_refused(written: str) -> None:
    for data in (written.encode(), f"run,date,position,kind\n{written}".encode()):
        with contextlib.suppress(InputRefused):
            read_run_sheet(SheetFile("a.csv", data), ())


def table(cells: str, decimal: str | None = None, delimiter: str = ",") -> Sheet:
    rows = "".join(f'a{delimiter}"{cell}"\n' for cell in cells.split())
    return read_sheet(SheetFile("a.csv", f"g{delimiter}v\n{rows}".encode(), decimal=decimal))


def numbers(cells: str, decimal: str | None = None, delimiter: str = ",") -> list[float | None]:
    sheet = table(cells, decimal, delimiter)
    return numbers_of(sheet, "v", "--value", decimal_sign(sheet, ["v"]))


NUMBERS = st.decimals(-(10**9), 10**9, places=4) | st.decimals(-1, 1, places=2)


@given(st.lists(NUMBERS, min_size=1, max_size=12), st.sampled_from([",", ";", "\t", "|"]), st.booleans())
def test_numbers_are_those_that_were_written(written: list[object], delimiter: str, comma: bool) -> None:
    cells = " ".join(str(value).replace(".", "," if comma else ".") for value in written)
    assert numbers(cells, "," if comma else ".", delimiter) == [float(str(value)) for value in written]


@pytest.mark.parametrize(
    ("cells", "delimiter"), [("1,234 5,678", ";"), ("1.234 -5.678 2", ";"), ("1.234 999", ","), ("1,234", "\t")]
)
def test_what_could_be_thousands_is_asked_about(cells: str, delimiter: str) -> None:
    with refuses(UsageError, "a.csv", "'v'", "--decimal"):
        numbers(cells, None, delimiter)
    assert None not in numbers(cells, "," if "," in cells else ".", delimiter)


def test_what_can_be_one_number_only_is_read() -> None:
    assert numbers("\N{MINUS SIGN}1.5 2e\N{MINUS SIGN}3 NA") == [-1.5, 0.002, None]
    assert numbers("\N{MINUS SIGN}1,5 1,25", delimiter=";") == [-1.5, 1.25]
    assert numbers("1.234 0.678", delimiter=";") == numbers("1.234 0.678") == [1.234, 0.678]
    assert numbers("1.234 5.67", delimiter=";") == [1.234, 5.67]


@pytest.mark.parametrize(
    ("cell", "facts"),
    [
        ("1.5J", ["write 1.5", "'J' is a unit", "'v (J)'"]),
        ("-3%", ["write -3"]),
        ("1,234.5", ["thousands", "1234.5"]),
        ("#DIV/0!", ["no number", "12.5"]),
        ("1e999", ["no number"]),
    ],
)
def test_what_is_no_number_is_refused_with_what_to_write(cell: str, facts: Sequence[str]) -> None:
    with refuses(SheetRefused, "line 3 of a.csv", "v", repr(cell), *facts):
        numbers(f"1.5 {cell}")
    with refuses(UnknownName, "'v'"):
        table("1.5").cells("vv", "--value")


def test_a_line_that_names_the_separator_is_no_row_and_a_cell_may_hold_lines() -> None:
    for delimiter in ",;\t|":
        data = f'sep={delimiter}\nrun{delimiter}note\nr1{delimiter}"say ""no""\ntwice"\nr2{delimiter}b\n'
        sheet = read_sheet(SheetFile("a.csv", data.encode()))
        assert (sheet.rows, sheet.lines) == ((("r1", 'say "no"\ntwice'), ("r2", "b")), (3, 5))


def test_a_quote_within_a_cell_is_a_mark_of_inches() -> None:
    sheet = read_sheet(SheetFile("a.csv", b'run,note\nr1,foot 2" wide\nr2,"two\nlines"\nr3,rail at 3"\n'))
    assert sheet.rows == (("r1", 'foot 2" wide'), ("r2", "two\nlines"), ("r3", 'rail at 3"'))
    assert sheet.lines == (2, 3, 5)


@pytest.mark.parametrize("kind", ["recharges", "flasks", "values", "log"])
def test_a_mark_of_inches_in_the_header_costs_no_column(kind: str) -> None:
    """A column of charger sheets was lost: quotes were counted wherever they stood in a header."""
    names, *rows = KINDS[kind].rows
    marked = [[names[0], 'foot 2" size', *names[1:]], *([row[0], '3" wide', *row[1:]] for row in rows)]
    assert KINDS[kind].read(text(marked, ",", ".")) == KINDS[kind].content


@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_a_note_of_a_sheet_may_have_as_many_lines_as_in_a_spreadsheet(end: str) -> None:
    note = end.join(f"line {n}" for n in range(254))
    data = f'run,mAh,pack,note{end}r1,461,A,"{note}"{end}r2,470,B,{end}'.encode()
    assert [row[:2] for row in recharges(data)] == [("r1", "A"), ("r2", "B")]
    sheet = read_sheet(SheetFile("a.csv", data))
    sheet.refuse()
    assert (sheet.rows[0][3].count("\n"), sheet.lines) == (253, (2, 256))


def test_a_quote_that_is_not_closed_in_place_costs_its_own_row() -> None:
    for closing in ("", 'r7,"b",', 'r7,b"c,'):
        rows = [f"r{n},a,b" for n in range(9)]
        rows[2:3] = ['r2,"a,b']
        rows[7:8] = [f"{closing}b" if closing else "r7,a,b"]
        sheet = read_sheet(SheetFile("a.csv", ("run,x,y\n" + "\n".join(rows) + "\n").encode()))
        assert [fault.line for fault in sheet.faults] == [4]
        assert len(sheet.rows) == 8


def test_quotes_out_of_place_cost_time_by_the_line() -> None:
    began_s = time.process_time()
    for line in ('x","', '1,"2', "1,2", '"1","2"'):
        with contextlib.suppress(InputRefused):
            read_sheet(SheetFile("a.csv", f'a,b\n1,"2\n{f"{line}{chr(10)}" * 30_000}'.encode()))
    assert time.process_time() - began_s < 20  # minutes where what follows a quote is searched for each line


def test_the_separator_is_the_one_that_fits_all_rows() -> None:
    sheet = read_sheet(SheetFile("a.csv", b"run;mass, with leg, kg;note\nr1;1.5;a\nr2;1.25;b\n"))
    assert (sheet.delimiter, sheet.names, len(sheet.rows)) == (";", ("run", "mass, with leg, kg", "note"), 2)


def test_a_last_line_that_may_be_cut_is_a_fault_unless_it_is_said_to_be_whole() -> None:
    cut = SheetFile("a.csv", b"a,b\n1,2\n1,2", complete=False)
    with refuses(SheetRefused, "line 3 of a.csv", "--complete"):
        read_sheet(cut).refuse()
    read_sheet(SheetFile("a.csv", cut.data)).refuse()
    read_sheet(SheetFile("a.ods", ods({"S": [["a", "b"], [1, 2]]}), complete=False)).refuse()


@pytest.mark.parametrize("pack", [workbook, ods])
def test_dates_of_a_workbook_are_dates(pack: Callable[[dict[str, Rows]], bytes]) -> None:
    day = datetime.datetime(2021, 6, 1, tzinfo=datetime.UTC).replace(tzinfo=None)
    rows = [list(row) for row in KINDS["runs"].rows]
    for row in rows[1:]:
        row[1] = day
    assert run_sheet(pack({"Sheet": rows})) == KINDS["runs"].content


def test_cells_of_a_spreadsheet_far_apart_are_no_memory_bomb() -> None:
    cell = '<table:table-cell table:number-columns-repeated="16000" office:value-type="float" office:value="1"/>'
    row = f'<table:table-row table:number-rows-repeated="1000000">{cell}</table:table-row>'
    with refuses(InputRefused, "most_cells"):
        read_sheet(SheetFile("a.ods", ods({"S": []}, row)))
    (finding,) = read_file(ods({"S": []}, row), Declarations()).findings
    says(finding.message, "most_cells")
