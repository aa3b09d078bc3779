"""Charges that no pack can take, a unit that is another's, and dates read the wrong way round are refused by name."""

from __future__ import annotations

import datetime

import pytest

from tests.cli.shell import good, labbook
from tests.helpers.attention import told
from tests.helpers.books import SmallBook
from tests.helpers.wording import says

AH = ("--column", "capacity=charge:mAh", "--override-units")


def ingested(book: SmallBook, text: str, *flags: str) -> tuple[int, str]:
    path = book.folder / "sheet.csv"
    path.write_text(text)
    answer = labbook("ingest", path, *flags, at=book.folder)
    return answer.code, answer.out


def test_a_charge_above_its_pack_is_refused_and_the_remedies_work(stated: SmallBook) -> None:
    sheet = "run,capacity_Ah,pack\nr001,40.1,A\nr002,39.5,A\n"
    code, told = ingested(stated, sheet)
    assert code == 2
    says(told, "charge_implausible", "line 2 and 1 more", "40100 mAh", "pack A", "8580 mAh", *AH)
    assert "would be refused" in labbook("ingest", "sheet.csv", "--explain", at=stated.folder).out
    assert ingested(stated, sheet, "--dry-run", *AH)[0] == 0
    good(labbook("correct", "battery:A", "capacity_mah=66000", "--why", "a zero was missing", at=stated.folder))
    stated.toml.write_text(stated.toml.read_text().replace("capacity_mah = 6600", "capacity_mah = 66000", 1))
    assert ingested(stated, sheet)[0] == 0


@pytest.mark.parametrize(("run", "pack"), [("r001", ""), ("r001", "Z"), ("r900", "Z")])
def test_without_its_pack_a_charge_is_compared_with_that_of_its_run_or_the_largest(
    run: str, pack: str, stated: SmallBook
) -> None:
    assert ingested(stated, f"run,mAh,pack\n{run},8581,{pack}\n")[0] == 2
    assert ingested(stated, f"run,mAh,pack\n{run},8580,{pack}\n")[0] == 0


def test_one_charge_above_its_pack_is_left_out_alone_and_mended(stated: SmallBook) -> None:
    rows = {f"r{number:03d}": 100 + number for number in range(1, 17)}
    sheet = "run,mAh\n" + "".join(f"{run},{mah}\n" for run, mah in rows.items())
    code, told = ingested(stated, sheet.replace("r007,107", "r007,10700"))
    assert code == 0
    assert told.index("charge_implausible") < told.index("  run r001:")
    says(told, "row: charge_implausible", "line 8", "10700 mAh", "pack")
    code, told = ingested(stated, sheet)
    says(told, "charge_known", "15 rows")
    assert "mAh" in good(labbook("show", "r007", at=stated.folder)).out


def test_ah_under_a_heading_in_mah_is_refused_unless_declared(stated: SmallBook) -> None:
    sheet = "run,mAh\nr001,0.11\nr002,0.42\n"
    code, told = ingested(stated, sheet)
    assert code == 2
    says(told, "charge_implausible", "0.42 mAh", "mAh=charge:Ah", "mAh=charge:mAh")
    assert ingested(stated, sheet, "--dry-run", "--column", "mAh=charge:Ah", "--override-units")[0] == 0
    assert ingested(stated, sheet, "--dry-run", "--column", "mAh=charge:mAh")[0] == 0
    assert ingested(stated, "run,mAh\nr001,0.11\nr002,42\n")[0] == 0


def test_a_charge_above_its_pack_that_came_otherwise_is_told_by_today_and_the_report(whole: SmallBook) -> None:
    good(labbook("correct", "r001", "mah=9000", "--why", "misread", at=whole.folder))
    (found,) = told(whole.folder, "today", "--day", "2021-06-14")["charge_above_pack"]
    assert found["run"] == "r001"
    says(found["what"], "9000 mAh", "6600")
    good(labbook("report", "--out", "page", at=whole.folder))
    assert "(r001) is more than the pack holds" in (whole.folder / "page" / "report.html").read_text()


def moved(book: SmallBook, *runs: str) -> None:
    for run in runs:
        good(labbook("correct", run, "date=2021-03-11", f"position={run[1:]}", "--why", "misread", at=book.folder))


def test_a_sheet_with_day_and_month_exchanged_is_refused_by_the_dates_of_its_runs(stated: SmallBook) -> None:
    moved(stated, "r001", "r002")
    sheet = "run,mAh,ended\nr001,112,03/11/2021 10:00\nr002,105,03/11/2021 10:30\n"
    code, told = ingested(stated, sheet, "--dates", "d/m/y")
    assert code == 2
    says(told, "day_month_swapped", "line 2 and 1 more", "2021-11-03", "2021-03-11", "--dates m/d/y", "correct r001")
    assert ingested(stated, sheet, "--dates", "m/d/y")[0] == 0


def test_a_single_date_exchanged_among_right_ones_is_asked_about(stated: SmallBook) -> None:
    moved(stated, "r001")
    code, told = ingested(stated, "run,mAh,ended\nr003,112,14/06/2021 10:00\nr001,105,03/11/2021 10:30\n")
    assert code == 0
    says(told, "look again", "r001", "2021-03-11", "2021-11-03", "labbook correct charge:")


def test_a_date_to_come_that_is_past_with_day_and_month_exchanged_is_refused(fresh: SmallBook) -> None:
    today = datetime.datetime.now(datetime.UTC).date()
    pairs = ((month, day) for month in range(1, 13) for day in range(1, 13))
    ahead = (
        f"{month}/{day}/{today.year}"
        for month, day in pairs
        if datetime.date(today.year, month, day) > today + datetime.timedelta(days=2)
        and datetime.date(today.year, day, month) < today
    )
    date = next(ahead, None)
    if date is None:
        pytest.skip("there is no such date in the days about New Year")
    assert ingested(fresh, f"run,mAh,ended\nx1,112,{date}\n", "--dates", "m/d/y")[0] == 2


def test_of_unknown_runs_the_days_of_the_book_decide_where_they_explain_all_dates(stated: SmallBook) -> None:
    moved(stated, "r001")
    good(labbook("correct", "r009", "date=2021-03-10", "--why", "misread", at=stated.folder))
    sheet = "run,mAh,ended\nx1,112,03/11/2021\nx2,105,03/10/2021\n"
    assert ingested(stated, sheet, "--dates", "d/m/y")[0] == 2
    assert ingested(stated, sheet, "--dates", "m/d/y")[0] == 0
    one = "run,mAh,ended\nx3,112,03/11/2021\n"
    assert ingested(stated, one, "--dates", "d/m/y")[0] == 0, "a single date may be that of another day"


def test_what_could_not_be_known_of_a_date_is_remarked_when_its_run_is_there(fresh: SmallBook) -> None:
    sheet = fresh.instruments / "runs.csv"
    sheet.write_text(sheet.read_text().replace("r001,2021-06-14", "r001,2021-03-11"))
    assert ingested(fresh, "run,mAh,ended\nr001,112,03/11/2021\n", "--dates", "d/m/y")[0] == 0
    told = good(labbook("runs", "import", sheet, at=fresh.folder)).out
    says(told, "r001 is of 2021-03-11", "2021-11-03", "labbook files reread")
    good(labbook("files", "reread", "sheet.csv", "--dates", "m/d/y", "--why", "m/d", at=fresh.folder))
