"""To which run a file belongs: by flag, by its name, by the charger sheet, by hand; and what waits until then."""

from __future__ import annotations

import json
import re
import shutil
import unicodedata
from pathlib import Path
from typing import Any

import pytest

from tests.cli.shell import contents, good, labbook, refused, rows, unchanged
from tests.helpers.attention import told
from tests.helpers.books import SmallBook
from tests.helpers.wording import says

LINKS = "SELECT run.name FROM run_file JOIN run ON run_file.run = run.id ORDER BY run.name"
CHARGES = "SELECT charge.row_number, run.name FROM charge LEFT JOIN run ON charge.run = run.id ORDER BY row_number"


def sheet(book: SmallBook, name: str, *rows: str) -> Path:
    path = book.folder.parent / name
    path.write_text("\n".join(["run,mAh,end_voltage,pack", *rows, ""]))
    return path


@pytest.fixture
def charges(stated: SmallBook) -> Path:
    """A charger sheet of which one row names a run, one a run that is not stated, one none."""
    return sheet(stated, "charges.csv", "r001,150,16.8,A", "r900,151,16.8,B", ",152,16.8,C")


@pytest.fixture
def nameless(stated: SmallBook) -> Path:
    """A log of run r001 whose name says nothing."""
    return Path(shutil.copy(stated.log("r001"), stated.folder.parent / "LOG0007.csv"))


def waiting(book: SmallBook) -> list[Any]:
    found: list[Any] = good(labbook("runs", "inbox", "--json", at=book.folder)).json
    return found


def found_jumps(book: SmallBook, run: str) -> int:
    return len(good(labbook("jumps", "list", run, "--json", at=book.folder)).json["jumps"])


def test_file_name_names_the_run_and_the_rig_hears_at_once_how_it_was(stated: SmallBook) -> None:
    for sheet in sorted((stated.instruments / "charger").iterdir()):
        good(labbook("ingest", sheet, at=stated.folder))
    answer = good(labbook("ingest", stated.log("r003"), at=stated.folder))
    says(answer.out, "  run r003:", "3 jumps", "J a jump")
    assert rows(stated.folder, LINKS) == [("r003",)]


def test_charger_sheet_names_its_runs_row_by_row(stated: SmallBook, charges: Path) -> None:
    (item,) = good(labbook("ingest", charges, "--json", at=stated.folder)).json
    assert item["runs"] == ["r001"]
    assert rows(stated.folder, CHARGES) == [(1, "r001"), (2, None), (3, None)]
    assert [(entry["what"], entry["name"], entry["stated_run"]) for entry in waiting(stated)] == [
        ("charge", "charges.csv#2", "r900"),
        ("charge", "charges.csv#3", None),
    ]
    good(labbook("assign", "charges.csv#3", "r002", at=stated.folder))
    assert rows(stated.folder, CHARGES) == [(1, "r001"), (2, None), (3, "r002")]
    assert [entry["name"] for entry in waiting(stated)] == ["charges.csv#2"]
    refused(labbook("assign", "charges.csv#9", "r002", at=stated.folder), 2, "no charge 9", "`labbook runs inbox`")


def test_unknown_run_waits_in_the_inbox_and_is_used_once_assigned(stated: SmallBook, nameless: Path) -> None:
    answer = good(labbook("ingest", nameless, at=stated.folder))
    says(answer.out, "labbook runs inbox")
    assert "LOG0007.csv" in good(labbook("runs", "inbox", at=stated.folder)).out
    assert [one["file"] for one in told(stated.folder, "today")["inbox"]] == ["LOG0007.csv"]
    with unchanged(stated.folder):
        refused(labbook("jumps", "list", "r001", at=stated.folder), 2, "run r001 has no log")
        assert "LOG0007" not in good(labbook("show", "r001", at=stated.folder)).out
    says(good(labbook("assign", "LOG0007.csv", "r001", at=stated.folder)).out, "LOG0007.csv", "r001")
    says(good(labbook("runs", "inbox", at=stated.folder)).out, "inbox is empty")
    assert found_jumps(stated, "r001") == 3
    assert "LOG0007.csv" in good(labbook("show", "r001", at=stated.folder)).out


def test_moving_a_file_or_a_charge_needs_a_reason_and_keeps_the_old_run(
    stated: SmallBook, nameless: Path, charges: Path
) -> None:
    good(labbook("ingest", nameless, "--run", "r002", at=stated.folder))
    good(labbook("ingest", charges, at=stated.folder))
    with unchanged(stated.folder):
        refused(labbook("assign", "LOG0007.csv", "r001", at=stated.folder), 2, "belongs to run r002", "--why")
        refused(labbook("assign", "LOG0007.csv", "r001", "--why", " ", at=stated.folder), 2, "--why is empty")
        refused(labbook("assign", "charges.csv#1", "r002", at=stated.folder), 2, "belongs to run r001", "--why")
    moved = good(labbook("assign", "LOG0007.csv", "r001", "--why", "wrong card", at=stated.folder))
    says(moved.out, "LOG0007.csv", "r001")
    good(labbook("assign", "charges.csv#1", "r002", "--why", "read a line too low", at=stated.folder))
    assert rows(stated.folder, LINKS) == [("r001",)]
    assert rows(stated.folder, CHARGES)[0] == (1, "r002")
    said = rows(stated.folder, "SELECT reason, old_json IS NOT NULL FROM journal WHERE action = 'set' AND reason <> ''")
    assert said == [("wrong card", 1), ("read a line too low", 1)]


def test_file_taken_off_its_run_is_in_the_inbox_and_can_be_assigned_again(whole: SmallBook) -> None:
    off = ("assign", "r001.csv", "none", "--why", "wrong card")
    assert good(labbook(*off, "--json", at=whole.folder)).json["run"] is None
    refused(labbook("jumps", "list", "r001", at=whole.folder), 2, "run r001 has no log")
    assert [item["name"] for item in waiting(whole)] == ["r001.csv"]
    with unchanged(whole.folder):
        assert "imported before" in good(labbook("ingest", whole.log("r001"), at=whole.folder)).out
    before = contents(whole.folder).rows
    good(labbook("rebuild", at=whole.folder))
    assert contents(whole.folder).rows == before
    assert rows(whole.folder, "SELECT reason FROM journal WHERE action = 'set' AND entity_kind = 'file'") == [
        ("wrong card",)
    ]
    good(labbook("assign", "r001.csv", "r001", at=whole.folder))
    assert found_jumps(whole, "r001") == 3


def test_charge_follows_the_file_that_holds_nothing_else(stated: SmallBook) -> None:
    good(labbook("ingest", sheet(stated, "one.csv", ",150,16.8,A"), "--run", "r001", at=stated.folder))
    assert rows(stated.folder, CHARGES) == [(1, "r001")]
    good(labbook("assign", "one.csv", "r002", "--why", "wrong run", at=stated.folder))
    assert (rows(stated.folder, CHARGES), rows(stated.folder, LINKS)) == ([(1, "r002")], [("r002",)])
    good(labbook("assign", "one.csv", "none", "--why", "another book", at=stated.folder))
    assert (rows(stated.folder, CHARGES), rows(stated.folder, LINKS)) == ([(1, None)], [])
    assert [item["name"] for item in waiting(stated)] == ["one.csv#1"]
    before = contents(stated.folder).rows
    good(labbook("rebuild", at=stated.folder))
    assert contents(stated.folder).rows == before


def test_what_contradicts_a_charge_waits_with_the_reason_and_the_cure(whole: SmallBook) -> None:
    """The report said "state the runs with `labbook runs import`" of rows whose runs are there."""
    lines = ["r002,333,16.8,B", "r002,333,16.8,B", "r001,112,16.8,A", "r099,120,16.8,A", ",120,16.8,A"]
    path = sheet(whole, "dup.csv", *lines)
    for words in (["--dry-run"], []):
        out = good(labbook("ingest", path, *words, at=whole.folder)).out
        says(out, "run_repeated", "one charge of a run counts")
        says(out, "charge_contradicts", "Run r002", "105 mAh")
        says(out, "charge_known", "2 rows", "1 of them of no run")
    _head, *listed = good(labbook("runs", "inbox", at=whole.folder)).out.splitlines()
    reasons = ("run r002 has a charge of 105 mAh", "the book has no run r099", "it names no run")
    assert [reason for line, reason in zip(listed, reasons, strict=False) if reason in line] == list(reasons)
    told = good(labbook("report", at=whole.folder)).out
    says(told, "look again", "dup.csv#1", "dup.csv#4", "labbook runs inbox")


def test_the_uid_that_the_inbox_shows_names_its_item(stated: SmallBook) -> None:
    for folder in ("first", "second"):
        (stated.folder.parent / folder).mkdir()
    for name, mah in (("first/one.csv", 112), ("second/one.csv", 113)):
        good(labbook("ingest", sheet(stated, name, f"q1,{mah},16.8,A"), at=stated.folder))
    first, second = (item["detail"].split(", ")[1] for item in waiting(stated))
    good(labbook("runs", "dismiss", first, "--why", "another pack", at=stated.folder))
    good(labbook("runs", "restore", f"charge:{first}", at=stated.folder))
    good(labbook("assign", second, "r016", at=stated.folder))
    (item,) = waiting(stated)
    assert first in item["detail"]


@pytest.mark.parametrize("corrected", ["the run's charge", "the row that waits"])
def test_a_row_that_contradicts_is_settled_by_the_correction_that_its_sentence_names(
    corrected: str, whole: SmallBook
) -> None:
    told = good(labbook("ingest", sheet(whole, "late.csv", "r002,812,16.7,B"), at=whole.folder)).out
    said = says(told, "charge_contradicts", "charge_mah=812 end_voltage_v=16.7", "settles the row")
    (item,) = waiting(whole)
    row = f"charge:{item['detail'].split(', ')[1]}"
    other = said.split("`labbook correct ")[1].split(" --why")[0].split()
    target = other if corrected == "the run's charge" else [row, "charge_mah=105", "end_voltage_v=16.8"]
    done = good(labbook("correct", *target, "--why", "misread", at=whole.folder)).out
    says(done, "late.csv#1", "waits no more")
    assert waiting(whole) == []
    good(labbook("rebuild", at=whole.folder))
    assert waiting(whole) == []


def test_a_charge_in_ampere_hours_is_the_same_charge_in_milliampere_hours(whole: SmallBook) -> None:
    """0.0561 times 1000 is 56.099999999999994."""
    for name, mah in (("r001", "56.1"), ("r002", "105")):
        good(labbook("correct", name, f"mah={mah}", "--why", "misread", at=whole.folder))
    other = whole.folder.parent / "ah.csv"
    other.write_text("run,charge [Ah]\nr001,0.0561\nr002,0.1051\n")
    told = good(labbook("ingest", other, at=whole.folder)).out
    says(told, "charge_known", "1 row is known")
    says(told, "charge_contradicts", "Run r002", "charge_mah=105.1 ")
    good(labbook("correct", "r002", "mah=105.1", "--why", "misread", at=whole.folder))
    assert waiting(whole) == []


def test_a_pack_charged_in_two_parts_gives_the_joules_of_their_sum(whole: SmallBook, tmp_path: Path) -> None:
    other = SmallBook(tmp_path / "other", whole.instruments)
    shutil.copytree(whole.folder, other.folder)
    query = "SELECT charge_mah FROM charge JOIN run ON charge.run = run.id AND name = 'r001'"
    ((first_mah,),) = rows(whole.folder, query)
    (tmp_path / "second.csv").write_text("run,mAh\nr001,50\n")
    told = good(labbook("ingest", tmp_path / "second.csv", at=whole.folder)).out
    line = says(told, "charge_contradicts", "labbook correct charge:", "labbook runs dismiss")
    words = re.search(r"`labbook (assign charge:\w+ r001 --add)`", line)
    assert words is not None
    refused(labbook("assign", "second.csv#1", "r001", at=whole.folder), 2, "r001", "--add")
    done = good(labbook(*words[1].split(), "--json", at=whole.folder)).json
    summed = good(labbook("correct", "r001", f"mah={first_mah + 50}", "--why", "sum", "--json", at=other.folder)).json
    assert [line.split(": ")[1] for line in summed["rig"]] == [line.split("found, ")[-1] for line in done["rig"]]
    good(labbook("report", "--out", "page", at=whole.folder))
    numbers = json.loads((whole.folder / "page" / "numbers.json").read_text(encoding="utf-8"))["numbers"]
    uid = next(uid for uid, number in numbers.items() if "joules" in number["about"] and number["name"] == "savings")
    why = good(labbook("why", uid, "--check", at=whole.folder)).out
    says(why, "second.csv", "50")
    says(why, "2021-06-14.csv")


@pytest.mark.parametrize(
    ("name", "above", "run"),
    [
        ("LOG0007.csv", "# run r003\n", "r003"),
        ("LOG0007.csv", "Logger 3;Run: r003;25 jumps\n", "r003"),
        ("LOG0007.csv", "# follows run r002, run r003\n", None),  # two names are no evidence
        ("LOG0007.csv", "# run in the morning\n", None),
        ("r003.csv", "# run r003\n", "r003"),
        ("r003.csv", "# run r900\n", None),
        ("r004.csv", "# run r003\n", None),
    ],
)
def test_the_lines_above_a_table_say_whose_it_is_beside_the_files_name(
    stated: SmallBook, tmp_path: Path, name: str, above: str, run: str | None
) -> None:
    path = tmp_path / name
    path.write_text(above + stated.log("r003").read_text())
    contradicts = name != "LOG0007.csv" and run is None
    for words in (("--explain",), ("--dry-run",), ()):
        told = good(labbook("ingest", path, *words, "--json", at=stated.folder)).json[0]
        rules = {finding["rule"]: finding["message"] for finding in told["findings"]}
        assert ("run_contradicts" in rules) is contradicts
    assert told["runs"] == ([] if run is None else [run])
    if contradicts:
        words = re.search(r"`labbook (assign [^`]+)`", rules["run_contradicts"])
        assert words is not None
        assert rows(stated.folder, LINKS) == []
        good(labbook("rebuild", at=stated.folder))
        good(labbook(*words[1].split(), at=stated.folder))
        assert rows(stated.folder, LINKS) == [(name.removesuffix(".csv"),)]


def test_what_a_person_says_stands_over_contradicting_evidence(stated: SmallBook, tmp_path: Path) -> None:
    path = tmp_path / "r004.csv"
    path.write_text("# run r003\n" + stated.log("r003").read_text())
    assert "run_contradicts" not in good(labbook("ingest", path, "--run", "r001", at=stated.folder)).out
    assert rows(stated.folder, LINKS) == [("r001",)]


def test_a_name_with_parted_letters_is_that_of_the_run(fresh: SmallBook) -> None:
    """`Prüfung1.csv` from a Mac, which writes u and a dieresis for ü, belonged to no run."""
    parted = unicodedata.normalize("NFD", "Prüfung1")
    head, first, *_others = (fresh.instruments / "runs.csv").read_text().splitlines()
    named = fresh.instruments / "named.csv"
    named.write_text(f"{head}\n{first.replace('r001', 'Prüfung1')}\n")
    said = good(labbook("runs", "import", named, at=fresh.folder)).out
    says(said, "Prüfung1", "run_names", "a file whose name begins so")
    log = shutil.copy(fresh.log("r001"), fresh.instruments / f"{parted}.csv")
    good(labbook("ingest", log, sheet(fresh, "charges.csv", f"{parted},150,16.8,A"), at=fresh.folder))
    assert (rows(fresh.folder, LINKS), rows(fresh.folder, CHARGES)) == ([("Prüfung1",)], [(1, "Prüfung1")])
    good(labbook("show", parted, at=fresh.folder))


def test_several_files_are_assigned_in_one_command_or_none(stated: SmallBook, tmp_path: Path) -> None:
    names = []
    for run in ("r001", "r002"):
        names.append(f"LOG{run[1:]}.csv")
        shutil.copy(stated.log(run), tmp_path / names[-1])
        good(labbook("ingest", tmp_path / names[-1], at=stated.folder))
    with unchanged(stated.folder):
        refused(labbook("assign", *names, "LOG9.csv", "r005", at=stated.folder), 2, "LOG9.csv")
    done = good(labbook("assign", *names, "r005", "--json", at=stated.folder)).json
    assert (done["files"], len(done["said"])) == (names, 2)
    assert rows(stated.folder, LINKS) == [("r005",), ("r005",)]
    says(done["remarks"][0]["message"], "r005", "starts")


def test_what_a_run_took_is_printed_when_it_is_typed_in_or_assigned(whole: SmallBook) -> None:
    good(labbook("assign", "2021-06-14.csv#3", "none", "--why", "misread", at=whole.folder))
    typed = good(labbook("charge", "r003", "112", at=whole.folder)).out
    says(typed, "run r003:", "J a jump", "n = ")
    uid = re.search(r"charge:(\w+)", typed)
    assert uid is not None
    good(labbook("correct", uid[0], "run=none", "--why", "twice", at=whole.folder))
    says(good(labbook("assign", "2021-06-14.csv#3", "r003", at=whole.folder)).out, "run r003:", "3 of 3", "J a jump")
