"""What is possible but odd is remarked on, never refused: one remark a rule, with the runs that it is about."""

from __future__ import annotations

import datetime
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

from data_schema.queries.charges import charges_of_run
from ingest.tables.sheet import SheetFile
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.runs.correcting import correct, runs_corrected, state_charge, void
from labbook.actions.runs.remarks import MOST_NAMED, remarks_on
from labbook.actions.runs.rig_line import rig_lines_of
from labbook.actions.runs.runs_importing import RunsImported, import_runs
from labbook.book.naming import run_named
from labbook.book.opening import Book
from tests.helpers.books import ADA, instrument_files, small_book
from tests.helpers.statements import state
from tests.helpers.wording import says

NEXT_YEAR = (datetime.datetime.now(datetime.UTC) + datetime.timedelta(days=366)).date().isoformat()


@pytest.fixture
def book(tmp_path: Path) -> Iterator[Book]:
    with small_book(tmp_path, ingested=False).open() as book:
        yield book


def sheet(*rows: Mapping[str, str]) -> str:
    """A run sheet of jump runs r901, r902, ... as the protocol has them, but for what `rows` say."""
    usual = {"date": "2021-06-17", "kind": "jumps", "foot": "small", "k_gain": "400", "b_ad_gain": "0", "battery": "A"}
    usual |= {"robot": "hopper", "started": "09:30", "duration_s": "720", "jumps_made": "25", "starts": "1"}
    header = instrument_files()["runs.csv"].decode().splitlines()[0]
    lines = [header]
    for number, row in enumerate(rows, start=1):
        cells = {**usual, "run": f"r{900 + number}", "position": str(number), **row}
        lines.append(",".join(cells.get(column, "") for column in header.split(",")))
    return "\n".join(lines) + "\n"


def imported(book: Book, text: str) -> RunsImported:
    return state(book, import_runs, SheetFile("runs.csv", text.encode()))


IDLE = {"kind": "idle", "foot": "", "k_gain": "", "b_ad_gain": "", "jumps_made": ""}


@pytest.mark.parametrize(
    ("row", "rule", "said"),
    [
        ({"duration_s": "72"}, "duration_unusual", ("72 s", "720 s")),
        ({"duration_s": "1441"}, "duration_unusual", ("1441 s",)),
        ({**IDLE, "duration_s": "599"}, "duration_unusual", ("1200 to 3600 s",)),
        ({**IDLE, "duration_s": "7201"}, "duration_unusual", ("7201 s",)),
        ({"date": NEXT_YEAR}, "date_in_future", (NEXT_YEAR,)),
        ({"date": "2012-06-14"}, "date_long_ago", ("before", "2021-06-14")),
        ({"jumps_made": "0"}, "jumps_unusual", ("0 jumps", "25")),
        ({"jumps_made": "51"}, "jumps_unusual", ("51 jumps",)),
    ],
)
def test_what_is_odd_on_a_sheet_is_remarked_and_stated_all_the_same(
    row: dict[str, str], rule: str, said: tuple[str, ...], book: Book
) -> None:
    done = imported(book, sheet(row))
    assert done.stated == ["r901"]
    (remark,) = done.remarks
    assert (remark.rule, remark.count, remark.first, remark.more) == (rule, 1, "r901", ())
    says(remark.message, "r901", *said)
    assert imported(book, sheet(row)).remarks == []


def test_what_is_usual_is_not_remarked(book: Book) -> None:
    usual = [
        {"duration_s": "360"},
        {"duration_s": "1440", "jumps_made": "50"},
        {**IDLE, "duration_s": "600"},
        {**IDLE, "duration_s": "7200"},
        {"kind": "characterisation", "duration_s": "5", "jumps_made": "0"},
        {"duration_s": "", "jumps_made": "0"},
        {"date": "2020-06-15"},
    ]
    assert imported(book, sheet(*usual)).remarks == []


def test_one_remark_a_rule_names_its_runs_and_counts_the_rest(book: Book) -> None:
    (remark,) = imported(book, sheet(*[{"duration_s": "72"}] * 30)).remarks
    assert (remark.count, remark.first, len(remark.more)) == (30, "r901", MOST_NAMED)
    says(remark.message, "r901", "72 s", f"r{901 + MOST_NAMED}", f"{29 - MOST_NAMED} more")


def test_a_place_that_a_run_of_another_sheet_has_is_remarked(book: Book) -> None:
    (remark,) = imported(book, sheet({"date": "2021-06-14"}, {"date": "2021-06-14", "position": "40"})).remarks
    assert (remark.rule, remark.first, remark.count) == ("position_taken", "r901", 1)
    says(remark.message, "r901", "has position", "2021-06-14", "r001")
    for run in ("r901", "r001"):
        state(book, void, run, "typed twice")
    assert imported(book, sheet({"run": "r903", "date": "2021-06-14", "position": "1"})).remarks == []


def after_correction(book: Book, target: str, *fields: str) -> list[str]:
    """The rules of what is remarked on."""
    with book.session(ADA) as session:
        changed = correct(book, session, target, fields, "x")
        runs = runs_corrected(session.connection, target, changed)
        return [one.rule for one in remarks_on(session.connection, book.configuration, runs, list(changed))]


def charge_of(book: Book, run: str) -> str:
    with book.reading() as connection:
        (charge,) = charges_of_run(connection, run_named(connection, run).uid)
    return f"charge:{charge.uid}"


def test_a_correction_is_looked_at_where_it_changes_something(book: Book) -> None:
    assert after_correction(book, "r001", "duration_s=72", "name=r101") == ["duration_unusual"]
    assert after_correction(book, "r101", "position_in_day=12") == []
    assert after_correction(book, "r002", f"day={NEXT_YEAR}", "jumps_made=0") == ["date_in_future", "jumps_unusual"]
    assert after_correction(book, "study", "jumps_nominal=1") == []
    assert after_correction(book, "battery:A", "capacity_mah=100") == []


def test_a_charge_is_compared_with_the_pack_of_its_run(book: Book) -> None:
    for run, mah in (("r001", 6700.0), ("r002", 6800.0), ("r003", 0.0)):
        state(book, state_charge, run, mah, None, None)
    with book.reading() as connection:
        remark, zero = remarks_on(connection, book.configuration, ["r001", "r002", "r003"])[-2:]
    assert (remark.rule, remark.count, remark.more) == ("charge_above_pack", 2, ("r002",))
    says(remark.message, "6700 mAh", "6600 mAh", "pack A holds", "r002")
    assert (zero.rule, zero.first, zero.count) == ("charge_zero", "r003", 1)
    charge = charge_of(book, "r001")
    assert after_correction(book, charge, "charge_mah=0") == ["charge_zero"]
    assert after_correction(book, charge, "charge_mah=120") == []
    assert after_correction(book, "r001", "battery=C") == ["pack_differs"]


@pytest.mark.parametrize(
    ("mah", "ended", "rules"),
    [
        ("461", "2021-06-14 10:00", []),
        ("461", "2021-06-14", []),
        ("461", "2021-06-13", ["charge_date"]),
        ("461", "2021-06-14 09:29", ["charge_date"]),
        ("461", "2021-06-12 10:00", ["charge_date"]),
        ("7900", "2021-06-14 10:00", ["charge_above_pack"]),
    ],
)
def test_a_charge_that_cannot_be_is_questioned_at_ingest(
    mah: str, ended: str, rules: list[str], book: Book, tmp_path: Path
) -> None:
    path = tmp_path / "odd.csv"
    path.write_text(f"run,mAh,minutes,end_voltage,pack,ended\nr001,{mah},12,16.8,A,{ended}\n")
    (lines,) = rig_lines_of(book, [ingest_file(book, path, IngestRequest(person=ADA))])
    assert [line.concern for line in lines][1:] == rules
    assert after_correction(book, charge_of(book, "r001"), f"charge_mah={float(mah) + 1}") == rules
