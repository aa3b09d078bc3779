"""A plan becomes a sheet that reads back as the plan, and one on paper that holds every run once."""

from __future__ import annotations

import csv
import datetime
import hashlib
import html
import io
import re

import pytest

from data_schema.vocabulary import PlanMethod
from ingest.tables.sheet import SheetFile
from labbook.config.run_names import RunNames
from labbook.plan.drawing import Plan, PlanFactor, draw_plan
from labbook.plan.sheet import BLANKS, format_run_sheet_for_print, write_run_sheet
from labbook.plan.sheet_reader import read_run_sheet
from tests.helpers.wording import says


def run_names(plan: Plan, first: int = 1) -> tuple[str, ...]:
    return tuple(map(RunNames().name, range(first, first + len(plan.runs))))


FACTORS = (
    PlanFactor("foot", ("small", "lar,ge")),
    PlanFactor("k_gain", ("300", "400")),
    PlanFactor("b_ad_gain", ("0", "50", "62.5"), control="0"),
)
DATES = [datetime.date(2021, 6, 1) + datetime.timedelta(days=2 * day) for day in range(40)]
IDLE = (20.0, 24.5)


@pytest.mark.parametrize("method", PlanMethod)
def test_a_written_sheet_reads_back_as_the_plan(method: PlanMethod) -> None:
    plan = draw_plan(FACTORS, 3, 7, method, seed=4, idle_minutes=IDLE, run_duration_s=720.0)
    names = run_names(plan, first=98)
    file = SheetFile("runs.csv", write_run_sheet(plan, names, DATES, robot="hopper").encode())
    rows, _page = read_run_sheet(file, FACTORS, robots=["hopper"], batteries=["A"])
    assert [row.name for row in rows] == list(names)
    assert names[:3] == ("r098", "r099", "r100")
    for row, run in zip(rows, plan.runs, strict=True):
        assert (row.date, row.position) == (DATES[run.day - 1], run.position_in_day)
        assert (row.kind, tuple(row.levels.items())) == (run.kind, run.condition or ())
        assert (row.robot, row.battery) == ("hopper", None)
        assert (row.started, row.duration_s, row.jumps_made, row.starts) == (None, None, None, None)
        assert not row.done
    assert sorted(row.note for row in rows if row.note) == ["planned 20 min", "planned 24.5 min"]


def test_the_same_seed_gives_the_same_bytes_for_ever() -> None:
    def sheet(seed: int) -> bytes:
        plan = draw_plan(FACTORS, 10, 12, PlanMethod.RANDOMISED, seed, idle_minutes=IDLE, run_duration_s=720.0)
        return write_run_sheet(plan, run_names(plan), DATES, battery="A", robot="hopper").encode()

    assert sheet(2021) == sheet(2021)
    assert sheet(2021) != sheet(2022)
    assert hashlib.sha256(sheet(2021)).hexdigest() == "8485f8314b14528bbb6b356cf15dcb1f8d4454dbbdab91a9c0ee04f4513cec34"


def test_no_cell_is_a_formula_and_numbers_stay_numbers() -> None:
    labels = ('=HYPERLINK("http://x")', "+1+1", "-2+3", "@SUM(A1)", "-5", "+0,5", "'quoted'", "a=b")
    factors = (PlanFactor("foot", labels, control="-5"),)
    plan = draw_plan(factors, 2, 8, PlanMethod.RANDOMISED, seed=1)
    sheet = write_run_sheet(plan, run_names(plan), DATES, robot="=cmd|' /C calc'!A0", battery="@pack")
    cells = {cell for row in csv.reader(io.StringIO(sheet)) for cell in row}
    assert {cell for cell in cells if cell.startswith(("=", "+", "-", "@", "\t", "\r"))} == {"-5", "+0,5"}
    assert {"'@pack", "'-2+3", "'quoted'", "a=b"} <= cells
    file = SheetFile("runs.csv", sheet.encode())
    rows, _page = read_run_sheet(file, factors, robots=["=cmd|' /C calc'!A0"], batteries=["@pack"])
    assert {row.levels["foot"] for row in rows} == set(labels)
    assert {(row.robot, row.battery) for row in rows} == {("=cmd|' /C calc'!A0", "@pack")}


PRINTED_FACTORS = (PlanFactor("foot", ("<small>", "large & wide")), PlanFactor("b_ad_gain", ("0", "50"), control="0"))


def pages_of(text: str) -> list[list[list[str]]]:
    """The cells of each page's rows."""
    return [
        [
            [html.unescape(cell) for cell in re.findall(r"<t[hd][^>]*>(.*?)</t[hd]>", row, re.DOTALL)]
            for row in re.findall(r"<tr[^>]*>(.*?)</tr>", page, re.DOTALL)
        ]
        for page in re.findall(r"<section[^>]*>(.*?)</section>", text, re.DOTALL)
    ]


def test_every_run_is_on_the_page_of_its_day() -> None:
    plan = draw_plan(PRINTED_FACTORS, 4, 6, PlanMethod.BLOCKED, seed=2, idle_minutes=(20.0,), run_duration_s=720.0)
    names = run_names(plan)
    text = format_run_sheet_for_print(plan, names, DATES, study="sand & <gravel>", robot="hopper", jumps_nominal=25)
    assert not re.search(r"\b(src|href)=", text)
    for page, day in zip(pages_of(text), plan.days, strict=True):
        header, *rows = page
        assert header == ["run", "", "kind", "foot", "b_ad_gain", "min", "battery", "robot", *BLANKS]
        for row, run in zip(rows, day, strict=True):
            levels = ["", ""] if run.condition is None else [level for _, level in run.condition]
            minutes = "20" if run.condition is None else "12"
            assert row[:3] == [names[run.position - 1], str(run.position_in_day), run.kind.value]
            assert row[3:8] == [*levels, minutes, "", "hopper"]
            assert row[8:] == [""] * len(BLANKS)
    says(text, "sand &amp", "1")
    assert "<small>" not in text
    says(text, "&lt;small&gt;")
