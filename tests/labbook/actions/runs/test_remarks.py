"""What is possible but odd is remarked on, never refused: one remark a rule, with the runs that it is about."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from pathlib import Path

import pytest

from data_schema.queries.charges import charges_of_run
from data_schema.queries.study import checks_by_day
from ingest.tables.sheet import SheetFile
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.runs.charges import state_charge
from labbook.actions.runs.correcting import correct, runs_corrected, void
from labbook.actions.runs.remarks import MOST_NAMED, Remark, remark_lines, remarks_on, remarks_on_check
from labbook.actions.runs.rig_line import rig_lines_of
from labbook.actions.runs.runs_importing import RunsImported, import_runs
from labbook.book.naming import run_named
from labbook.book.opening import Book
from tests.helpers.books import ADA, SmallBook, instrument_files, small_book
from tests.helpers.wording import says

NEXT_YEAR = (datetime.datetime.now(datetime.UTC) + datetime.timedelta(days=366)).date().isoformat()


@pytest.fixture
def stated(tmp_path: Path) -> SmallBook:
    return small_book(tmp_path, ingested=False)


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
    with book.session(ADA) as session:
        return import_runs(book, session, SheetFile("runs.csv", text.encode()))


IDLE = {"kind": "idle", "foot": "", "k_gain": "", "b_ad_gain": "", "jumps_made": ""}


@pytest.mark.parametrize(
    ("row", "rule", "said"),
    [
        ({"duration_s": "72"}, "duration_unusual", "run r901 lasted 72 s where the protocol has 720 s."),
        ({"duration_s": "1441"}, "duration_unusual", "1441 s"),
        ({**IDLE, "duration_s": "599"}, "duration_unusual", "where the protocol has 1200 to 3600 s."),
        ({**IDLE, "duration_s": "7201"}, "duration_unusual", "7201 s"),
        ({"date": NEXT_YEAR}, "date_in_future", f"run r901 is of {NEXT_YEAR}, which is yet to come."),
        (
            {"date": "2012-06-14"},
            "date_long_ago",
            "more than a year before the other days, the first of them 2021-06-14",
        ),
        ({"jumps_made": "0"}, "jumps_unusual", "run r901 has 0 jumps made where the protocol has 25."),
        ({"jumps_made": "51"}, "jumps_unusual", "51 jumps made"),
    ],
)
def test_what_is_odd_on_a_sheet_is_remarked_and_stated_all_the_same(
    row: dict[str, str], rule: str, said: str, stated: SmallBook
) -> None:
    with stated.open() as book:
        done = imported(book, sheet(row))
        assert done.stated == ["r901"]
        (remark,) = done.remarks
        assert (remark.rule, remark.count, remark.first, remark.more) == (rule, 1, "r901", ())
        assert said in remark.message
        assert remark_lines(done.remarks) == [f"look again: {remark.message}"]
        assert imported(book, sheet(row)).remarks == []


def test_what_is_usual_is_not_remarked(stated: SmallBook) -> None:
    usual = [
        {"duration_s": "360"},
        {"duration_s": "1440", "jumps_made": "50"},
        {**IDLE, "duration_s": "600"},
        {**IDLE, "duration_s": "7200"},
        {"kind": "characterisation", "duration_s": "5", "jumps_made": "0"},
        {"duration_s": "", "jumps_made": "0"},
        {"date": "2020-06-15"},
    ]
    with stated.open() as book:
        assert imported(book, sheet(*usual)).remarks == []


def test_one_remark_a_rule_names_its_runs_and_counts_the_rest(stated: SmallBook) -> None:
    with stated.open() as book:
        (remark,) = imported(book, sheet(*[{"duration_s": "72"}] * 30)).remarks
    assert (remark.count, remark.first, len(remark.more)) == (30, "r901", MOST_NAMED)
    says(remark.message, "r901", "lasted", "72 s")
    assert remark.message.endswith(f"r{901 + MOST_NAMED} and {29 - MOST_NAMED} more.")


def after_correction(book: Book, target: str, *fields: str) -> list[Remark]:
    with book.session(ADA) as session:
        changed = correct(book, session, target, fields, "x")
        return remarks_on(
            session.connection, book.configuration, runs_corrected(session.connection, target, changed), list(changed)
        )


def test_a_place_that_a_run_of_another_sheet_has_is_remarked(stated: SmallBook) -> None:
    with stated.open() as book:
        (remark,) = imported(book, sheet({"date": "2021-06-14"}, {"date": "2021-06-14", "position": "40"})).remarks
        assert (remark.rule, remark.first, remark.count) == ("position_taken", "r901", 1)
        says(remark.message, "r901", "has position", "2021-06-14", "r001")
        with book.session(ADA) as session:
            void(session, "r901", "typed twice")
            void(session, "r001", "typed twice")
        again = sheet({"run": "r903", "date": "2021-06-14", "position": "1"})
        assert imported(book, again).remarks == []


def rules(remarks: list[Remark]) -> list[str]:
    return [remark.rule for remark in remarks]


def test_a_correction_is_looked_at_where_it_changes_something(stated: SmallBook) -> None:
    with stated.open() as book:
        assert rules(after_correction(book, "r001", "duration_s=72", "name=r101")) == ["duration_unusual"]
        assert rules(after_correction(book, "r101", "position_in_day=12")) == []
        assert rules(after_correction(book, "r002", f"day={NEXT_YEAR}", "jumps_made=0")) == [
            "date_in_future",
            "jumps_unusual",
        ]
        assert rules(after_correction(book, "study", "jumps_nominal=1")) == []
        assert rules(after_correction(book, "battery:A", "capacity_mah=100")) == []


def test_a_charge_is_compared_with_the_pack_of_its_run(stated: SmallBook) -> None:
    with stated.open() as book:
        with book.session(ADA) as session:
            state_charge(session, book.configuration, "r001", 6700.0, None, None)
            state_charge(session, book.configuration, "r002", 0.0, None, None)
            (remark,) = remarks_on(session.connection, book.configuration, ["r001", "r002", "r003"])[-1:]
            (charge,) = charges_of_run(session.connection, run_named(session.connection, "r001").uid)
        assert (remark.rule, remark.count, remark.more) == ("charge_unusual", 2, ("r002",))
        says(remark.message, "6700 mAh", "6600 mAh", "pack A holds", "r002")
        assert rules(after_correction(book, f"charge:{charge.uid}", "charge_mah=0")) == ["charge_unusual"]
        assert rules(after_correction(book, f"charge:{charge.uid}", "charge_mah=120")) == []
        (differs,) = after_correction(book, "r001", "battery=C")
        says(differs.message, "r001", "made with pack")
        assert rules([differs]) == ["pack_differs"]


@pytest.mark.parametrize(
    ("mah", "ended", "rule"),
    [
        ("461", "2021-06-14 10:00", None),
        ("461", "2021-06-14", None),
        ("461", "2021-06-13", "charge_before_run"),
        ("461", "2021-06-14 09:29", "charge_before_run"),
        ("461", "2021-06-12 10:00", "charge_before_run"),
        ("7900", "2021-06-14 10:00", "charge_unusual"),
    ],
)
def test_a_charge_that_cannot_be_is_questioned_at_ingest(
    mah: str, ended: str, rule: str | None, stated: SmallBook
) -> None:
    path = stated.folder.parent / "odd.csv"
    path.write_text(f"run,mAh,minutes,end_voltage,pack,ended\nr001,{mah},12,16.8,A,{ended}\n")
    with stated.open() as book:
        outcome = ingest_file(book, path, IngestRequest(person=ADA))
        (lines,) = rig_lines_of(book, [outcome])
        assert [line.concern for line in lines][1:] == ([] if rule is None else [rule])
        with book.reading() as connection:
            (charge,) = charges_of_run(connection, run_named(connection, "r001").uid)
        said = rules(after_correction(book, f"charge:{charge.uid}", f"charge_mah={float(mah) + 1}"))
        assert said == ([] if rule is None else [rule])


def test_a_check_without_the_unit_of_earlier_ones_is_remarked(stated: SmallBook) -> None:
    with stated.open() as book, book.reading() as connection:
        earlier = [check for checks in checks_by_day(connection).values() for check in checks]
    (remark,) = remarks_on_check(earlier, "rail_angle", 0.4, None)
    assert remark.rule == "check_without_unit"
    says(remark.message, "earlier ones were")
    (other,) = remarks_on_check(earlier, "rail_angle", 400.0, "parsec")
    assert other.rule == "check_in_other_unit"
    says(other.message, "rail_angle 400", "in parsec", "in deg")
    assert remarks_on_check(earlier, "rail_angle", 0.4, "deg") == []
    assert remarks_on_check(earlier, "rail_angle", None, None) == []
    assert remarks_on_check(earlier, "lubrication", 3.0, None) == []
