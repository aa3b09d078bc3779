"""From the plan to the run sheet to what a day still needs."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import pytest

from tests.cli.shell import contents, good, labbook, refused, rows, unchanged
from tests.helpers.books import SmallBook, small_book

PLAN = ("plan", "--seed", "7", "--n", "2", "--per-day", "8", "--start", "2021-06-01")


def table(path: Path) -> list[dict[str, str]]:
    return list(csv.DictReader(path.read_text().splitlines()))


def write(path: Path, lines: list[dict[str, str]]) -> Path:
    stream = io.StringIO()
    writer = csv.DictWriter(stream, lines[0].keys(), lineterminator="\n")
    writer.writeheader()
    writer.writerows(lines)
    path.write_text(stream.getvalue())
    return path


def test_same_seed_gives_the_same_bytes_and_nothing_is_overwritten(tmp_path: Path) -> None:
    sheets = []
    for name in ("one", "two"):
        book = small_book(tmp_path / name, runs=False, ingested=False)
        done = good(labbook(*PLAN, "--json", at=book.folder)).json
        assert (done["runs"], done["idle"]) == (14, 6)
        sheets.append((book.folder / "runs.csv").read_bytes() + (book.folder / "runs.html").read_bytes())
        with unchanged(book.folder):
            refused(labbook(*PLAN, at=book.folder), 2, "runs.csv exists", "--out")
    assert sheets[0] == sheets[1]
    good(labbook("plan", "--seed", "8", "--n", "2", "--per-day", "8", "--out", "other.csv", at=book.folder))
    assert (book.folder / "other.csv").read_bytes() not in sheets[1]


@pytest.mark.parametrize("method", ["randomised", "blocked"])
def test_every_condition_reaches_its_n_and_every_day_has_its_controls(method: str, fresh: SmallBook) -> None:
    good(labbook(*PLAN, "--method", method, "--no-idle", at=fresh.folder))
    planned = table(fresh.folder / "runs.csv")
    conditions = [(row["foot"], row["k_gain"], row["b_ad_gain"]) for row in planned]
    assert {conditions.count(condition) for condition in set(conditions) if condition[2] != "0"} == {2}
    assert all(conditions.count((foot, "400", "0")) >= 2 for foot in ("small", "large"))
    for day in {row["date"] for row in planned}:
        of_day = [row for row in planned if row["date"] == day]
        assert len(of_day) <= 8
        groups = {(row["foot"], row["k_gain"]) for row in of_day}
        assert groups == {(row["foot"], row["k_gain"]) for row in of_day if row["b_ad_gain"] == "0"}


def test_dry_run_writes_the_sheet_and_states_nothing(fresh: SmallBook) -> None:
    before = rows(fresh.folder, "SELECT count(*) FROM journal")
    good(labbook(*PLAN, "--dry-run", at=fresh.folder))
    assert (fresh.folder / "runs.csv").exists()
    assert rows(fresh.folder, "SELECT count(*) FROM journal") == before


def test_study_without_factors_cannot_be_planned(tmp_path: Path) -> None:
    good(labbook("init", "book", "--as", "Ada", at=tmp_path))
    with unchanged(tmp_path / "book"):
        refused(labbook("plan", "--seed", "1", at=tmp_path / "book"), 2, "no factors", "[factors]")


def test_plan_is_filled_in_row_by_row(fresh: SmallBook) -> None:
    good(labbook(*PLAN, at=fresh.folder))
    sheet = fresh.folder / "runs.csv"
    lines = table(sheet)
    waiting = good(labbook("runs", "import", "runs.csv", "--json", at=fresh.folder)).json
    assert (waiting["stated"], len(waiting["not_made"])) == ([], 14)
    assert "planned, not done (14)" in good(labbook("today", "--day", "2021-06-01", at=fresh.folder)).out

    first = next(line for line in lines if line["kind"] == "jumps")
    first.update(started="09:30", battery="A", jumps_made="3")
    write(sheet, lines)
    with unchanged(fresh.folder):
        tried = good(labbook("runs", "import", "runs.csv", "--dry-run", at=fresh.folder))
    assert "1 runs stated" in tried.out
    assert "nothing stored" in tried.out
    stated = good(labbook("runs", "import", "runs.csv", "--json", at=fresh.folder)).json
    assert stated["stated"] == [first["run"]]
    assert rows(fresh.folder, "SELECT started_utc, state FROM run") == [("2021-06-01T13:30:00Z", "open")]

    first.update(duration_s="722", note="left rail squeaked")
    write(sheet, lines)
    filled = good(labbook("runs", "import", "runs.csv", "--json", at=fresh.folder)).json
    assert filled["filled_in"] == [first["run"]]
    assert rows(fresh.folder, "SELECT state, duration_s FROM run") == [("complete", 722.0)]
    with unchanged(fresh.folder):
        again = good(labbook("runs", "import", "runs.csv", "--json", at=fresh.folder)).json
    assert (again["stated"], again["filled_in"], again["unchanged"]) == ([], [], [first["run"]])
    assert "planned, not done (13)" in good(labbook("today", "--day", "2021-06-01", at=fresh.folder)).out


def test_contradictions_with_the_book_are_refused_all_at_once(stated: SmallBook) -> None:
    sheet = stated.instruments / "runs.csv"
    lines = table(sheet)
    lines[0].update(foot="large")
    lines[1].update(duration_s="900", jumps_made="2")
    write(sheet, lines)
    with unchanged(stated.folder):
        answer = labbook("runs", "import", sheet, at=stated.folder)
        refused(answer, 2, "run r001", "condition", "run r002", "duration_s, jumps_made", "labbook correct r002")


def test_faults_of_a_sheet_are_told_all_at_once_with_line_and_column(fresh: SmallBook) -> None:
    sheet = fresh.instruments / "runs.csv"
    lines = table(sheet)
    for number, wrong in enumerate(
        [
            {"date": "14.6.21"},
            {"foot": "smal"},
            {"kind": "jump"},
            {"battery": "Z"},
            {"started": "25:00"},
            {"duration_s": "long"},
            {"jumps_made": "-1"},
            {"run": "r001"},
            {"position": "1"},
        ]
    ):
        lines[number].update(wrong)
    write(sheet, lines)
    with unchanged(fresh.folder):
        answer = labbook("runs", "import", sheet, at=fresh.folder)
        refused(
            answer,
            2,
            "nothing was stored",
            "line 2, date",
            "line 3, foot: 'smal'",
            "line 4, kind: 'jump'",
            "line 5, battery: 'Z'",
            "line 6, started",
            "line 7, duration_s",
            "line 8, jumps_made",
            "line 9, run: 'r001' is on line 2 too",
        )


def test_run_sheet_of_a_spreadsheet_with_semicolons_and_mark(fresh: SmallBook) -> None:
    sheet = fresh.instruments / "runs.csv"
    sheet.write_bytes(b"\xef\xbb\xbf" + sheet.read_bytes().replace(b",", b";").replace(b"\n", b"\r\n"))
    done = good(labbook("runs", "import", sheet, at=fresh.folder))
    assert done.out.startswith("16 runs stated")


def test_today_lists_what_a_day_still_needs(stated: SmallBook) -> None:
    day = ("today", "--day", "2021-06-14")
    shown = good(labbook(*day, at=stated.folder)).out
    assert "2021-06-14: 8 runs." in shown
    assert "neither log nor charge (8): r001, r002" in shown
    assert "checks not made (3): lubrication" in shown
    good(labbook("ingest", stated.log("r001"), stated.log("r002"), at=stated.folder))
    good(labbook("ingest", stated.instruments / "charger" / "2021-06-14.csv", at=stated.folder))
    found = good(labbook(*day, "--json", at=stated.folder)).json
    assert found["log_without_charge"] == []
    assert found["charge_without_log"] == ["r003", "r004", "r005", "r006"]
    for kind in ("lubrication", "battery_conditioned", "sensor_zero"):
        good(labbook("check", kind, "--day", "2021-06-14", at=stated.folder))
    for run in ("r003", "r004", "r005", "r006"):
        good(labbook("ingest", stated.log(run), at=stated.folder))
    assert good(labbook(*day, at=stated.folder)).out == "2021-06-14: 8 runs.\nnothing is missing.\n"


def test_checks_are_kept_with_value_unit_person_and_verdict(stated: SmallBook) -> None:
    good(
        labbook(
            "check",
            "rail_angle",
            "--value",
            "1.6",
            "--unit",
            "deg",
            "--failed",
            "--day",
            "2021-06-14",
            at=stated.folder,
        )
    )
    found = rows(
        stated.folder,
        "SELECT kind, value, unit, passed, person.name FROM day_check JOIN person ON person = person.id "
        "ORDER BY day_check.id DESC LIMIT 1",
    )
    assert found == [("rail_angle", 1.6, "deg", 0, "Ada Nwosu")]


def test_runs_are_listed_by_what_is_asked(whole: SmallBook) -> None:
    def listed(where: str) -> list[str]:
        return [run["name"] for run in good(labbook("runs", "list", "--where", where, "--json", at=whole.folder)).json]

    everything = [run["name"] for run in good(labbook("runs", "list", "--json", at=whole.folder)).json]
    assert len(everything) == 16
    small = listed("foot=small")
    assert len(small) == 8
    assert listed("not foot=small") == [run for run in everything if run not in small and run in listed("kind=jumps")]
    assert listed("kind=idle and duration_s>=2400") == ["r008", "r016"]
    assert listed("day>=2021-06-16 and (foot in (large) or b_ad_gain=0)") == ["r009", "r011", "r013", "r014"]
    assert listed("run='; DROP TABLE run; --'") == []
    good(labbook("void", "r002", "--reason", "foot came loose", at=whole.folder))
    assert "r002" in listed("foot=small")
    assert "r002" not in listed("foot=small and not state=void")
    assert labbook("runs", "list", "--where", "foot=small", at=whole.folder).out.splitlines()[0].startswith("run ")


def made_one(book: SmallBook) -> tuple[str, list[dict[str, str]]]:
    """Draw a plan of 14 runs and make the first jump run of it."""
    good(labbook(*PLAN, at=book.folder))
    lines = table(book.folder / "runs.csv")
    first = next(line for line in lines if line["kind"] == "jumps")
    first.update(started="09:30", battery="A", jumps_made="25", duration_s="720")
    write(book.folder / "runs.csv", lines)
    good(labbook("runs", "import", "runs.csv", at=book.folder))
    return first["run"], lines


def test_withdrawn_plan_leaves_what_was_made_and_makes_room_for_another(fresh: SmallBook) -> None:
    made, lines = made_one(fresh)
    with unchanged(fresh.folder):
        tried = good(labbook("plan", "--withdraw", "--why", "new foot", "--dry-run", at=fresh.folder))
        assert "nothing stored" in tried.out
        refused(labbook("plan", "--withdraw", "--seed", "8", "--why", "x", at=fresh.folder), 2, "plans with seed 7")
    done = good(labbook("plan", "--withdraw", "--why", "new foot", "--json", at=fresh.folder)).json
    assert (len(done["withdrawn"]), done["made"]) == (13, [made])
    assert "planned, not done" not in good(labbook("today", at=fresh.folder)).out
    assert made in good(labbook("runs", "list", at=fresh.folder)).out
    with unchanged(fresh.folder):
        again = good(labbook("runs", "import", "runs.csv", "--json", at=fresh.folder)).json
        assert (again["not_made"], len(again["withdrawn"])) == ([], 13)
        refused(labbook("plan", "--withdraw", "--why", "x", at=fresh.folder), 2, "no planned run is left")
    before = contents(fresh.folder).rows
    good(labbook("rebuild", at=fresh.folder))
    assert contents(fresh.folder).rows == before
    assert "planned, not done" not in good(labbook("today", at=fresh.folder)).out

    good(labbook(*PLAN, "--out", "next.csv", at=fresh.folder))
    drawn = {line["run"] for line in table(fresh.folder / "next.csv")}
    assert not drawn & {line["run"] for line in lines}, "a sheet of the withdrawn plan may still be around"
    assert "planned, not done (14)" in good(labbook("today", at=fresh.folder)).out


def test_run_of_a_withdrawn_plan_can_be_made_all_the_same(fresh: SmallBook) -> None:
    _made, lines = made_one(fresh)
    good(labbook("plan", "--withdraw", "--seed", "7", "--why", "new foot", at=fresh.folder))
    later = next(line for line in lines if line["kind"] == "jumps" and not line["started"])
    later.update(started="10:30", battery="B", jumps_made="25", duration_s="720")
    write(fresh.folder / "runs.csv", lines)
    assert good(labbook("runs", "import", "runs.csv", "--json", at=fresh.folder)).json["stated"] == [later["run"]]
    planned = rows(fresh.folder, "SELECT name, planned_run IS NOT NULL FROM run ORDER BY id")
    assert planned[-1] == (later["run"], 0)
    assert "planned, not done" not in good(labbook("today", at=fresh.folder)).out


def test_what_is_odd_is_told_after_the_summary_and_refuses_nothing(fresh: SmallBook) -> None:
    lines = table(fresh.instruments / "runs.csv")
    for line in lines[:3]:
        line["duration_s"] = "72"
    sheet = write(fresh.folder / "odd.csv", lines)
    with unchanged(fresh.folder):
        tried = good(labbook("runs", "import", sheet, "--dry-run", "--json", at=fresh.folder)).json
        assert [(remark["rule"], remark["count"], remark["more"]) for remark in tried["remarks"]] == [
            ("duration_unusual", 3, ["r002", "r003"])
        ]
    summary, remark = good(labbook("runs", "import", sheet, at=fresh.folder)).out.splitlines()
    assert summary.startswith("16 runs stated")
    assert remark == ("look again: run r001 lasted 72 s where the protocol has 720 s; the same of r002, r003.")
    typed = good(labbook("charge", "r001", "0", at=fresh.folder)).out.splitlines()
    assert typed[-1] == "look again: run r001 has a charge of 0 mAh."
    fixed = good(labbook("correct", "r001", "duration_s=7200", "--why", "x", at=fresh.folder)).out.splitlines()
    assert fixed[-1].startswith("look again: run r001 lasted 7200 s")
    good(labbook("check", "rail_angle", "--value", "0.4", "--unit", "deg", at=fresh.folder))
    checked = good(labbook("check", "rail_angle", "--value", "0.4", at=fresh.folder)).out
    assert "look again: rail_angle 0.4 has no unit" in checked
