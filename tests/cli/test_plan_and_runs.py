"""From the plan to the run sheet to what a day still needs."""

from __future__ import annotations

import csv
import io
import re
from pathlib import Path

import pytest

from tests.cli.shell import contents, good, labbook, refused, rows, unchanged
from tests.helpers.attention import runs_told, told
from tests.helpers.books import SmallBook, small_book
from tests.helpers.tomls import without
from tests.helpers.wording import says

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
            refused(labbook(*PLAN, at=book.folder), 2, "seed 7")
            for there in ("runs.csv", "."):
                refused(labbook(*PLAN, "--seed", "9", "--out", there, at=book.folder), 2, f"{there} exists", "--out")
    assert sheets[0] == sheets[1]
    good(labbook("plan", "--seed", "8", "--n", "2", "--per-day", "8", "--out", "other.csv", at=book.folder))
    assert (book.folder / "other.csv").read_bytes() not in sheets[1]


@pytest.mark.parametrize(("n", "test"), [(2, "within days"), (12, "on day means")])
def test_plan_says_which_test_its_days_allow(n: int, test: str, fresh: SmallBook) -> None:
    drawn = ("plan", "--seed", "7", "--n", str(n), "--per-day", "8", "--dry-run")
    done = good(labbook(*drawn, "--json", at=fresh.folder)).json
    both: dict[tuple[str, str], dict[str, set[bool]]] = {}
    for row in table(fresh.folder / "runs.csv"):
        if row["kind"] == "jumps":
            of_day = both.setdefault((row["foot"], row["k_gain"]), {}).setdefault(row["date"], set())
            of_day.add(row["b_ad_gain"] == "0")
    assert done["shared_days"] == min(sum(len(sides) == 2 for sides in days.values()) for days in both.values())
    assert done["too_few"] is (n < 12)
    said = good(labbook(*drawn, "--out", "again.csv", at=fresh.folder)).out
    assert test in said
    assert ("Too few runs" in said) is (n < 12)


def test_dry_run_writes_the_sheet_and_states_nothing(fresh: SmallBook) -> None:
    before = rows(fresh.folder, "SELECT count(*) FROM journal")
    good(labbook(*PLAN, "--dry-run", at=fresh.folder))
    sheet = (fresh.folder / "runs.csv").read_bytes()
    assert rows(fresh.folder, "SELECT count(*) FROM journal") == before
    good(labbook(*PLAN, at=fresh.folder))  # the plan that was looked at
    assert (fresh.folder / "runs.csv").read_bytes() == sheet
    assert rows(fresh.folder, "SELECT count(*) FROM journal") > before


def test_plan_is_filled_in_row_by_row(fresh: SmallBook) -> None:
    good(labbook(*PLAN, at=fresh.folder))
    sheet = fresh.folder / "runs.csv"
    lines = table(sheet)
    waiting = good(labbook("runs", "import", "runs.csv", "--json", at=fresh.folder)).json
    assert (waiting["stated"], len(waiting["not_made"])) == ([], 14)
    assert len(planned_not_made(fresh)) == 14

    first = next(line for line in lines if line["kind"] == "jumps")
    refused(labbook("show", first["run"], at=fresh.folder), 2, "planned", "labbook runs import")
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
    assert len(planned_not_made(fresh)) == 13


def test_contradictions_with_the_book_are_refused_all_at_once_as_a_sheet_has_them(stated: SmallBook) -> None:
    sheet = stated.instruments / "runs.csv"
    lines = table(sheet)
    lines[0].update(foot="large")
    lines[1].update(duration_s="900", jumps_made="2")
    lines[2].update(battery="B", started="10:30", date="2021-06-13", kind="characterisation")
    write(sheet, lines)
    with unchanged(stated.folder):
        refused(
            labbook("runs", "import", sheet, at=stated.folder),
            2,
            "run r001 is in the book with foot=small where the sheet has large: correct",
            "duration_s=720 where the sheet has 900, jumps_made=3 where the sheet has 2: correct",
            "labbook correct r002",
            "battery=C where the sheet has B",
            "day=2021-06-14 where the sheet has 2021-06-13",
            "where the sheet has 2021-06-13T14:30:00Z",
            "kind=jumps where the sheet has characterisation",
        )


def test_today_lists_what_a_day_still_needs(stated: SmallBook) -> None:
    day = ("today", "--day", "2021-06-14")
    says(good(labbook(*day, at=stated.folder)).out, "2021-06-14: 8 runs")
    assert runs_told(stated.folder, "charge_missing", *day) == [f"r00{n}" for n in range(1, 9)]
    assert runs_told(stated.folder, "log_missing", *day) == [f"r00{n}" for n in range(1, 7)]
    assert [one["command"] for one in told(stated.folder, *day)["check_not_made"]] == [
        "labbook check lubrication --day 2021-06-14"
    ]
    sheets = stated.instruments / "charger"
    good(labbook("ingest", stated.log("r001"), stated.log("r002"), sheets / "2021-06-14.csv", at=stated.folder))
    assert runs_told(stated.folder, "charge_missing", *day) == []
    assert runs_told(stated.folder, "log_missing", *day) == ["r003", "r004", "r005", "r006"]
    good(labbook("check", "lubrication", "--day", "2021-06-14", at=stated.folder))
    good(labbook("ingest", stated.instruments / "logs", at=stated.folder))
    (line,) = told(stated.folder, *day)["no_drain_line"]
    says(line["costs"], "r001", "r002")
    good(labbook("ingest", sheets / "2021-06-16.csv", at=stated.folder))
    says(good(labbook(*day, at=stated.folder)).out, "nothing needs attention")


def test_checks_are_kept_with_value_unit_person_and_verdict(stated: SmallBook) -> None:
    words = "check rail_angle --value 1.6 --unit deg --failed --day 2021-06-14"
    good(labbook(*words.split(), at=stated.folder))
    of_person = "FROM day_check JOIN person ON person = person.id ORDER BY day_check.id"
    found = rows(stated.folder, f"SELECT kind, value, unit, passed, person.name {of_person}")[-1]
    assert found == ("rail_angle", 1.6, "deg", 0, "Ada Nwosu")


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


def test_withdrawn_plan_leaves_what_was_made_and_makes_room_for_another(fresh: SmallBook) -> None:
    good(labbook(*PLAN, at=fresh.folder))
    lines = table(fresh.folder / "runs.csv")
    first = next(line for line in lines if line["kind"] == "jumps")
    first.update(started="09:30", battery="A", jumps_made="25", duration_s="720")
    good(labbook("runs", "import", write(fresh.folder / "runs.csv", lines), at=fresh.folder))
    with unchanged(fresh.folder):
        tried = good(labbook("plan", "--withdraw", "--why", "new foot", "--dry-run", at=fresh.folder))
        assert "nothing stored" in tried.out
        refused(labbook("plan", "--withdraw", "--seed", "8", "--why", "x", at=fresh.folder), 2, "plans with seed 7")
    done = good(labbook("plan", "--withdraw", "--why", "new foot", "--json", at=fresh.folder)).json
    assert (len(done["withdrawn"]), done["made"]) == (13, [first["run"]])
    assert planned_not_made(fresh) == []
    with unchanged(fresh.folder):
        again = good(labbook("runs", "import", "runs.csv", "--json", at=fresh.folder)).json
        assert (again["not_made"], len(again["withdrawn"])) == ([], 13)
        refused(labbook("plan", "--withdraw", "--why", "x", at=fresh.folder), 2, "no planned run is left")
    later = next(line for line in lines if line["kind"] == "jumps" and not line["started"])
    later.update(started="10:30", battery="B", jumps_made="25", duration_s="720")
    write(fresh.folder / "runs.csv", lines)  # a withdrawn run can be made all the same
    assert good(labbook("runs", "import", "runs.csv", "--json", at=fresh.folder)).json["stated"] == [later["run"]]
    planned = rows(fresh.folder, "SELECT name, planned_run IS NOT NULL FROM run ORDER BY id")
    assert planned[-1] == (later["run"], 0)
    before = contents(fresh.folder).rows
    good(labbook("rebuild", at=fresh.folder))
    assert contents(fresh.folder).rows == before

    good(labbook(*PLAN, "--out", "next.csv", at=fresh.folder))
    drawn = {line["run"] for line in table(fresh.folder / "next.csv")}
    assert not drawn & {line["run"] for line in lines}  # a sheet of the withdrawn plan may still be around
    assert len(planned_not_made(fresh)) == 14


def test_what_is_odd_is_told_after_the_summary_and_refuses_nothing(fresh: SmallBook) -> None:
    sheet = fresh.instruments / "runs.csv"
    lines = table(sheet)
    for line in lines[:3]:
        line["duration_s"] = "72"
    write(sheet, lines)
    with unchanged(fresh.folder):
        tried = good(labbook("runs", "import", sheet, "--dry-run", "--json", at=fresh.folder)).json
    (odd,) = tried["remarks"]
    assert (odd["rule"], odd["count"], odd["more"]) == ("duration_unusual", 3, ["r002", "r003"])
    summary, remark = good(labbook("runs", "import", sheet, at=fresh.folder)).out.splitlines()
    assert summary.startswith("16 runs stated")
    says(remark, "look again", "r001", "72 s", "720 s", "r002", "r003")
    for words, said in (
        ("charge r001 0", "0 mAh"),
        ("correct r001 duration_s=7200 --why x", "7200 s"),
    ):
        says(good(labbook(*words.split(), at=fresh.folder)).out, "look again", said)


def test_a_run_that_differs_from_its_plan_or_has_almost_its_name_is_remarked(fresh: SmallBook) -> None:
    good(labbook(*PLAN, at=fresh.folder))
    lines = table(fresh.folder / "runs.csv")
    first, second = [line for line in lines if line["kind"] == "jumps"][:2]
    idle = next(line for line in lines if line["kind"] == "idle")
    for minute, line in enumerate((first, second, idle)):
        line.update(started=f"09:3{minute}", battery="A", duration_s="720", jumps_made="3")
    planned_gain, planned_name = first["b_ad_gain"], second["run"]
    first.update(b_ad_gain={"0": "100", "100": "0"}[planned_gain])
    idle.update(kind="jumps", foot="small", k_gain="400", b_ad_gain="0")
    renamed = planned_name.upper()
    second.update(run=f"{renamed} ")
    write(fresh.folder / "runs.csv", lines)
    done = good(labbook("runs", "import", "runs.csv", at=fresh.folder)).out.splitlines()
    told = [line for line in done if line.startswith("look again")]
    says(told, first["run"], f"b_ad_gain={planned_gain}")
    says(told, idle["run"], "an idle run")
    says(told[-1], renamed, "is another run", planned_name, "their names differ")

    assert planned_name in planned_not_made(fresh)
    good(labbook("correct", renamed, f"name={planned_name}", "--why", "typed large", at=fresh.folder))
    assert planned_name not in planned_not_made(fresh)
    before = contents(fresh.folder).rows
    good(labbook("rebuild", at=fresh.folder))
    assert contents(fresh.folder).rows == before


def planned_not_made(book: SmallBook) -> list[str]:
    return runs_told(book.folder, "planned_not_made", "today")


def test_today_and_ingest_say_that_a_second_log_takes_the_first_out_of_the_count(whole: SmallBook) -> None:
    day = ("today", "--day", "2021-06-14")
    again = whole.folder / "r001 again.csv"
    again.write_bytes(b"".join(whole.log("r003").read_bytes().splitlines(keepends=True)[:-1]))
    said_of_it = ("look again", "run r001", "2 log", "1 start")
    says(good(labbook("ingest", again, "--run", "r001", at=whole.folder)).out, *said_of_it)
    assert runs_told(whole.folder, "logs_too_many", *day) == ["r001"]
    good(labbook("assign", again.name, "none", "--why", "another run's", at=whole.folder))
    said = good(labbook("assign", again.name, "r001", at=whole.folder)).out.splitlines()
    says(said, *said_of_it, "none of them counts", f"labbook assign '{again.name}' none")
    good(labbook("correct", "r001", "starts=2", "--why", "it was switched on twice", at=whole.folder))
    assert runs_told(whole.folder, "logs_too_many", *day) == []


def test_plan_says_what_it_leaves_open(fresh: SmallBook) -> None:
    assert "look again" not in good(labbook(*PLAN, "--dry-run", "--out", "one.csv", at=fresh.folder)).out
    text = fresh.toml.read_text()
    robot = text[text.index("[robots.hopper]") : text.index("[batteries.A]")]
    changed = text.replace(robot, robot + robot.replace("hopper", "second")).replace("control = 0\n", "")
    fresh.toml.write_text(changed)
    drawn = good(labbook(*PLAN, "--out", "two.csv", at=fresh.folder)).out.splitlines()[2:]
    assert [line.startswith("look again: ") for line in drawn] == [True, True]
    assert "control = ..." in drawn[0]
    says(drawn[1], "2 robots", "three or more", "6")


def test_checks_are_those_of_the_lab_and_none_where_it_lists_none(fresh: SmallBook) -> None:
    listed = 'checks = ["rail_angle", "lubrication"]'
    without(fresh.folder, re.escape(listed), 'checks = ["plate zeroed"]')
    (found,) = told(fresh.folder, "today")["check_not_made"]
    says(found["command"], "labbook check 'plate zeroed'")
    refused(labbook("check", "rail_angle", at=fresh.folder), 2, "rail_angle", "'plate zeroed'", "[protocol]")
    good(labbook("check", "plate zeroed", at=fresh.folder))
    good(labbook("plan", "--seed", "1", "--n", "2", at=fresh.folder))
    assert "plate zeroed" in (fresh.folder / "runs.html").read_text()
    without(fresh.folder, re.escape('checks = ["plate zeroed"]'))
    assert "check_not_made" not in told(fresh.folder, "today", "--day", "2021-06-01")


def test_a_lab_names_its_runs_as_it_does(fresh: SmallBook) -> None:
    without(fresh.folder, r"(?<=\[study\]\n)", 'run_names = "LOG{:04d}"\n')
    drawn = []
    for seed in ("1", "2"):
        good(labbook("plan", "--seed", seed, "--n", "1", "--no-idle", "--out", f"{seed}.csv", at=fresh.folder))
        drawn.append(table(fresh.folder / f"{seed}.csv"))
    assert [line["run"] for lines in drawn for line in lines] == [f"LOG000{number}" for number in range(1, 9)]
    lines = drawn[1]
    for minute, line in enumerate(lines):
        line.update(started=f"09:3{minute}", battery="A", duration_s="720", jumps_made="3")
    lines[1]["run"] = "hop-a"
    done = good(labbook("runs", "import", write(fresh.folder / "done.csv", lines), at=fresh.folder))
    says(done.out, "look again", "hop-a", "LOG{:04d}")
    files = {"2021-06-14_LOG0005.csv": "LOG0005", "hop-a_2.csv": "hop-a", "LOG0005-LOG0007.csv": None}
    for number, file in enumerate(files, start=1):
        (fresh.folder / file).write_bytes(fresh.log(f"r00{number}").read_bytes())
        good(labbook("ingest", file, at=fresh.folder))
    assert dict(rows(fresh.folder, "SELECT original_name, stated_run FROM ingest")) == files


def test_a_run_is_shown_in_the_time_of_its_lab(stated: SmallBook) -> None:
    """It was "started 2021-06-14T13:00:00Z" in New York, and what people stated of it was in UTC, too."""
    good(labbook("correct", "r001", "started=21:05", "--why", "read off the wrong line", at=stated.folder))
    good(labbook("note", "r001", "the string slipped", at=stated.folder))
    shown = good(labbook("show", "r001", at=stated.folder)).out
    says(shown, "started 2021-06-14 21:05:00 EDT")
    says(" ".join(shown.split()), "corrected: started 2021-06-14 09:30:00 EDT to 2021-06-14 21:05:00 EDT")
    assert not re.search(r"\d\dZ\b|_utc", shown)
    found = good(labbook("show", "r001", "--json", at=stated.folder)).json
    assert found["run"]["started_utc"] == "2021-06-15T01:05:00Z"
