"""What is missing, waits or is void is told where a person would miss it: by `today`, `show` and reports."""

from __future__ import annotations

from pathlib import Path

from tests.cli.shell import good, labbook
from tests.helpers.attention import told
from tests.helpers.books import SmallBook
from tests.helpers.hopping_log import apex_s, hopping_log
from tests.helpers.wording import says

DAY = ("today", "--day", "2021-06-14")


def test_runs_without_numbers_are_named_with_the_reason(stated: SmallBook, tmp_path: Path) -> None:
    no_height = "t [ms],pot\n" + "".join(f"{3 * i},{420 + i % 7}\n" for i in range(300))
    lost = [(apex_s(number) - 0.03, apex_s(number) + 0.03) for number in (1, 2, 3)]
    logs = {"r001": no_height.encode(), "r002": no_height.replace("pot", "wire").encode()}
    for run, content in {**logs, "r003": hopping_log(3, lost_s=lost), "r004": hopping_log(3)}.items():
        (tmp_path / f"{run}.csv").write_bytes(content)
        good(labbook("ingest", tmp_path / f"{run}.csv", at=stated.folder))
    good(labbook("ingest", stated.instruments / "charger", at=stated.folder))
    good(labbook("correct", "r004", "jumps_made=0", "--why", "a misprint", at=stated.folder))
    named = {code: sorted(one["run"] or "" for one in several) for code, several in told(stated.folder, *DAY).items()}
    assert named["log_without_height"] == ["r001", "r002"]
    assert named["no_jump_counts"] == ["r003"]
    assert named["jumps_unusual"] == ["r004"]
    assert named["log_missing"] == ["r005", "r006"]


def test_the_last_line_says_when_the_last_backup_was_made(stated: SmallBook, tmp_path: Path) -> None:
    before = good(labbook(*DAY, at=stated.folder)).out.splitlines()[-1]
    says(before, "labbook backup DEST")
    good(labbook("backup", tmp_path / "stick", at=stated.folder))
    good(labbook("note", "r001", "squeaks", at=stated.folder))
    line = good(labbook(*DAY, at=stated.folder)).out.splitlines()[-1]
    assert line.startswith("last backup: ")
    says(line, tmp_path / "stick", "1 entry")
    assert good(labbook("db", "status", at=stated.folder)).out.splitlines()[-1] == line
    assert good(labbook(*DAY, "--json", at=stated.folder)).json["last_backup"]["where"] == str(tmp_path / "stick")


def test_void_runs_are_named_with_their_reason_beside_those_done(stated: SmallBook) -> None:
    good(labbook("void", "r002", "--why", "the string was off", at=stated.folder))
    first = good(labbook(*DAY, at=stated.folder)).out.splitlines()[0]
    says(first, "7 runs", "1 void", "r002", "the string was off")
    assert good(labbook(*DAY, "--json", at=stated.folder)).json["void"] == {"r002": "the string was off"}
    good(labbook("void", "r002", "--undo", "--why", "it was r003", at=stated.folder))
    says(good(labbook(*DAY, at=stated.folder)).out, "2021-06-14: 8 runs")
    assert good(labbook(*DAY, "--json", at=stated.folder)).json["void"] == {}


def test_a_run_without_log_or_charge_shows_what_it_lacks_and_how_to_add_it(stated: SmallBook, tmp_path: Path) -> None:
    shown = {run: good(labbook("show", run, at=stated.folder)).out for run in ("r001", "r007")}
    says(shown["r001"], "no log", "`labbook ingest FILE --run r001`")
    says(shown["r001"], "no charge", "`labbook charge r001 MAH`")
    assert "no log" not in shown["r007"]  # an idle run has none
    says(labbook("jumps", "list", "r001", at=stated.folder).err, "no log", "`labbook ingest FILE --run r001`")
    (tmp_path / "pot.csv").write_bytes(hopping_log(3))
    good(labbook("ingest", tmp_path / "pot.csv", "--run", "r001", at=stated.folder))
    good(labbook("charge", "r001", "128", at=stated.folder))
    assert "  no " not in good(labbook("show", "r001", at=stated.folder)).out
    good(labbook("void", "r002", "--why", "the string was off", at=stated.folder))
    assert "  no " not in good(labbook("show", "r002", at=stated.folder)).out


def test_a_report_of_files_without_runs_says_that_they_wait(fresh: SmallBook) -> None:
    good(labbook("ingest", fresh.instruments / "logs", at=fresh.folder))
    said = good(labbook("report", at=fresh.folder)).out
    says(said, "r001.csv", "8 more", "labbook runs inbox")
    assert "labbook runs inbox" in said


def test_importing_runs_says_which_files_and_charges_waited_for_them(fresh: SmallBook) -> None:
    good(labbook("ingest", fresh.instruments / "logs", fresh.instruments / "charger", at=fresh.folder))
    told = good(labbook("runs", "import", fresh.instruments / "runs.csv", "--dry-run", at=fresh.folder)).out
    assert "r001.csv" in told
    done = good(labbook("runs", "import", fresh.instruments / "runs.csv", "--json", at=fresh.folder)).json
    assert done["taken_in"].keys() == {f"r{n:03}" for n in range(1, 17)}
    assert done["taken_in"]["r001"] == ["r001.csv", "2021-06-14.csv#1"]
    again = good(labbook("runs", "import", fresh.instruments / "runs.csv", "--json", at=fresh.folder)).json
    assert again["taken_in"] == {}
