"""Run sheets as people return them: rewritten by spreadsheets, half filled, wrong in every way at once."""

from __future__ import annotations

import datetime
from typing import Any

import pytest

from data_schema.errors import InputRefused
from data_schema.vocabulary import RunKind
from ingest.tables.sheet import SheetFile, SheetRefused
from labbook.plan.drawing import PlanFactor
from labbook.plan.local_time import SheetQuestion
from labbook.plan.sheet_reader import RunSheetRow, read_run_sheet
from tests.helpers.wording import refuses, says

FACTORS = (PlanFactor("foot", ("small", "large")), PlanFactor("k_gain", ("300", "62.5"), control="300"))
HEADER = "run,date,position,kind,foot,k_gain,battery,robot,started,duration_s,jumps_made,starts,note"
JUMPS = "r1,2021-06-01,1,jumps,small,300,A,hopper,9:05,720,25,2,first of the day"
IDLE = "r2,2021-06-01,2,idle,,,A,hopper,09:30,1200.5,,1,"


def read(*lines: str, **known: Any) -> tuple[RunSheetRow, ...]:
    return read_run_sheet(SheetFile("runs.csv", ("\n".join(lines) + "\n").encode()), FACTORS, **known)[0]


def faults(*lines: str, **known: Any) -> list[tuple[int, str | None, str, str]]:
    with pytest.raises(SheetRefused) as caught:
        read(*lines, **known)
    assert all(fault.sentence in str(caught.value) for fault in caught.value.faults[:50])
    return [(fault.line, fault.column, fault.value, fault.sentence) for fault in caught.value.faults]


def test_a_filled_row_is_read() -> None:
    jumps, idle = read(HEADER, JUMPS, IDLE)
    assert jumps == RunSheetRow(
        line=2,
        name="r1",
        date=datetime.date(2021, 6, 1),
        position=1,
        kind=RunKind.JUMPS,
        levels={"foot": "small", "k_gain": "300"},
        battery="A",
        robot="hopper",
        started=datetime.time(9, 5),
        duration_s=720.0,
        jumps_made=25,
        starts=2,
        note="first of the day",
    )
    assert jumps.done
    assert (idle.kind, idle.levels, idle.jumps_made, idle.duration_s) == (RunKind.IDLE, {}, None, 1200.5)


def test_columns_stand_in_any_order_and_hand_made_sheets_may_leave_some_out() -> None:
    (row,) = read("k_gain,foot,kind,position,date,run", "300,large,jumps,3,2021-06-01,r7")
    assert (row.name, row.position, row.levels) == ("r7", 3, {"foot": "large", "k_gain": "300"})
    assert (row.battery, row.note, row.done) == (None, "", False)


@pytest.mark.parametrize(
    ("old", "new", "column", "words"),
    [
        ("2021-06-01", "13.13.2021", "date", "is not a date"),
        ("2021-06-01", "2021-02-30", "date", "is not a date"),
        ("2021-06-01", "20210601", "date", "is not a date"),
        ("2021-06-01", "", "date", "the cell is empty"),
        ("r1", "", "run", "the cell is empty"),
        ("r1", "r\x001", "run", "NUL"),
        (",1,", ",0,", "position", "'0' is not a count: write a whole number, 1 or more"),
        (",1,", ",1.5,", "position", "is not a count"),
        (",jumps", ",jump", "kind", "did you mean 'jumps'?"),
        ("small", "smal", "foot", "'smal' is not a known level of foot: did you mean 'small'?"),
        ("small", "", "foot", "a run of jumps has a level of every factor"),
        ("300", "310", "k_gain", "did you mean '300'?"),
        ("300", "NaN", "k_gain", "is not a known level of k_gain"),
        (",A,", ",B,", "battery", "'B' is not a known battery"),
        ("hopper", "hoper", "robot", "did you mean 'hopper'?"),
        ("9:05", "25:00", "started", "is not a time of day"),
        ("9:05", "9:05 AM", "started", "write hours and minutes, such as 14:05"),
        ("720", "12 min", "duration_s", "write seconds, such as 720"),
        ("720", "0", "duration_s", "is not a duration"),
        ("720", "1e9", "duration_s", "is not a duration"),
        (",720", ',"1,200"', "duration_s", "'1,200' is not a duration"),  # 1.2 or 1200: not guessed
        (",25,", ",-1,", "jumps_made", "is not a count"),
        (",25,", ",,", "jumps_made", "count its jumps, 0 if there were none"),
        ("25,2", "25,0", "starts", "1 or more"),
        ("jumps,small,300,A,hopper,9:05,720,25", "idle,,300,A,hopper,9:05,720,0", "k_gain", "which has no levels"),
        ("jumps,small,300", "idle,,", "jumps_made", "which has no jumps"),
        ("first", "fi\x1brst", "note", "unprintable"),
    ],
)
def test_each_fault_has_its_place_and_remedy(old: str, new: str, column: str, words: str) -> None:
    found = faults(HEADER, JUMPS.replace(old, new, 1), batteries=["A"], robots=["hopper"])
    assert len(found) == 1
    line, where, _value, sentence = found[0]
    assert (line, where) == (2, column)
    assert words in sentence
    assert sentence.endswith((".", "?"))


def test_all_faults_of_all_rows_are_reported_at_once() -> None:
    found = faults(
        HEADER.replace("foot", "foott") + ",weather,kind",
        "r1,1.6.x,1,jumps,small,300,A,hopper,,,,,,,jumps",
        "r2,2021-06-01,x,jumps,small,350,A,hopper,,,,,,,jumps",
        "r1,2021-06-01,2,jumps,small,300,A,hopper,,,,,,,jumps",
        "r3,2021-06-01,2,jumps,small,300,A,hopper,,,,,,,jumps",
        "r4,2021-06-01,3,jumps",
    )
    places = "1 kind, 1 foott, 1 weather, 2 date, 3 position, 3 k_gain, 4 run, 5 position, 6 None"
    assert ", ".join(f"{line} {column}" for line, column, _, _ in found) == places
    sentences = [sentence for *_, sentence in found]
    says(sentences[1], "'foot'")
    assert "there twice" in sentences[0]
    says(sentences[6], "'r1'", "is on line", "2 too")
    says(sentences[7], "2021-06-01", "on line", "4 too")
    says(sentences[8], "4 cells", "15")


def test_missing_and_many_unknown_columns_are_named() -> None:
    found = faults("run,date,kind,foot", "r1,2021-06-01,jumps,small")
    assert [column for _, column, _, _ in found] == ["position", "k_gain"]
    for _, column, _, sentence in found:
        says(sentence, column, "is missing")
    unknown = [f"extra {number}" for number in range(1000)]
    ((line, where, _value, sentence),) = faults(",".join([HEADER, *unknown]), JUMPS + "," * 1000)
    assert (line, where) == (1, None)
    says(sentence, "1000 columns", "'extra 0'")


def test_what_ails_many_lines_alike_is_told_once_with_their_number() -> None:
    rows = [JUMPS.replace("r1,", f"r{n},", 1).replace(",1,", f",{n},", 1) for n in range(1, 31)]
    with pytest.raises(SheetRefused) as caught:
        read(HEADER, *(row.replace(",720,25,", ",720,,") for row in rows))
    assert len(caught.value.faults) == 30
    (told,) = str(caught.value).splitlines()
    says(told, "30 lines", "2", "jumps_made", "10 more")


def test_what_is_no_sheet_of_runs_is_told_in_one_sentence() -> None:
    for text in (HEADER, HEADER + "\n,,,", "hello", "a,b\n1,2"):
        with refuses(InputRefused, "runs.csv", "`labbook plan`") as refused:
            read(text)
        assert str(refused.value).count("\n") == 0


@pytest.mark.parametrize(
    "written", ["2021-06-01", "2021/06/01", "2021-6-1", "1.6.2021", "01.06.2021", "1. 6. 2021", "1.6.21"]
)
def test_dates_that_can_be_one_day_only_are_read(written: str) -> None:
    """`d.m.y` was refused."""
    (row,) = read(HEADER, JUMPS.replace("2021-06-01", written))
    assert row.date == datetime.date(2021, 6, 1)


def test_the_order_of_a_date_with_slashes_is_asked_for() -> None:
    sheet = [HEADER, JUMPS.replace("2021-06-01", "03/04/2019")]
    with pytest.raises(SheetQuestion, match=r"--dates d/m/y.*--dates m/d/y"):
        read(*sheet)
    assert read(*sheet, dates="d/m/y")[0].date == datetime.date(2019, 4, 3)
    assert read(*sheet, dates="m/d/y")[0].date == datetime.date(2019, 3, 4)
    with refuses(SheetRefused, "'31/12/2019'", "not a date"):
        read(HEADER, JUMPS.replace("2021-06-01", "31/12/2019"), dates="m/d/y")


def test_a_time_of_day_may_state_its_offset() -> None:
    (row,) = read(HEADER, JUMPS.replace("9:05", "02:30+02:00"))
    assert row.started == datetime.time(2, 30, tzinfo=datetime.timezone(datetime.timedelta(hours=2)))
