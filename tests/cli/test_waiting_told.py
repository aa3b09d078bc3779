"""What waits for runs is told where a person would miss it: by the report, and by the sheet that brings the runs."""

from __future__ import annotations

from tests.cli.shell import good, labbook
from tests.helpers.books import SmallBook
from tests.helpers.wording import says


def test_a_report_of_files_without_runs_says_that_they_wait(fresh: SmallBook) -> None:
    assert "look again" not in good(labbook("report", at=fresh.folder)).out
    good(labbook("ingest", fresh.instruments / "logs", at=fresh.folder))
    told = good(labbook("report", at=fresh.folder)).out
    says(told, "r001.csv", "11 more")
    assert "labbook runs inbox" in told


def test_importing_runs_says_which_files_and_charges_waited_for_them(fresh: SmallBook) -> None:
    good(labbook("ingest", fresh.instruments / "logs", fresh.instruments / "charger", at=fresh.folder))
    told = good(labbook("runs", "import", fresh.instruments / "runs.csv", "--dry-run", at=fresh.folder)).out
    assert "r001.csv" in told
    done = good(labbook("runs", "import", fresh.instruments / "runs.csv", "--json", at=fresh.folder)).json
    assert done["taken_in"].keys() == {f"r{n:03}" for n in range(1, 17)}
    assert done["taken_in"]["r001"] == ["r001.csv", "2021-06-14.csv#1"]
    again = good(labbook("runs", "import", fresh.instruments / "runs.csv", "--json", at=fresh.folder)).json
    assert again["taken_in"] == {}


def test_two_tables_of_a_log_are_told_apart_by_the_columns_of_each(fresh: SmallBook) -> None:
    path = fresh.folder / "two.csv"
    rows = [f"{5 * k},{0.3 + k % 7 / 100:.3f},{0.2 + k % 5 / 100:.3f}" for k in range(60)]
    path.write_text("\n".join(["time [ms],height [m],leg [mm]", *rows, "time [ms],leg [mm],height [m]", *rows, ""]))
    good(labbook("ingest", path, at=fresh.folder))
    told = good(labbook("files", "show", "two.csv", at=fresh.folder)).out
    first, second = [line for line in told.splitlines() if "part log" in line]
    assert first.index("'height [m]' is body_height [m]") < first.index("'leg [mm]' is leg")
    assert second.index("'leg [mm]' is leg") < second.index("'height [m]' is body_height [m]")
