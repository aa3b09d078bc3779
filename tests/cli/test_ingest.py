"""The contract of `labbook ingest`: copies, duplicates, refusals, batches, what programs get."""

from __future__ import annotations

import hashlib
import shutil
from pathlib import Path

import pyarrow as pa
import pytest

from tests.cli.shell import contents, good, labbook, no_file_above, rows, unchanged
from tests.helpers.books import SmallBook
from tests.helpers.wording import says
from tests.ingest.synthetic import SHEET, bertec_acquire, icharger_rows, robot_log, twenty_faults

KEYS = {
    "status", "format", "runs", "rows_read", "rows_kept", "rows_rejected", "channels", "findings", "sha256",
    "file", "first_import", "raw_restored", "changes", "said", "rig", "missing_body_height",
    "replaced",
}  # fmt: skip
CHANNEL_KEYS = {"name", "unit", "rate_hz", "n"}
FINDING_KEYS = {"severity", "rule", "line", "column", "count", "message", "more_lines", "value"}
FILES = {
    "log.csv": robot_log(),
    "plate.txt": bertec_acquire(),
    "charges.csv": SHEET.encode(),
    "charger.txt": ("\n".join(icharger_rows()) + "\n").encode(),
}


def sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def raw_copy(book: SmallBook, data: bytes) -> Path:
    return book.folder / "raw" / sha256(data)[:2] / f"{sha256(data)}.zst"


def kept(book: SmallBook, data: bytes) -> bytes:
    """The raw copy of a file's bytes, as they come out of the store."""
    with pa.input_stream(str(raw_copy(book, data)), compression="zstd") as stream:
        copy: bytes = stream.read()
    return copy


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder as an instrument leaves it: files of four kinds, one of them in a folder below, and a hidden one."""
    folder = tmp_path / "from the rig"
    (folder / "charger").mkdir(parents=True)
    for name, data in FILES.items():
        (folder / ("charger" if name.startswith("charge") else ".") / name).write_bytes(data)
    (folder / ".DS_Store").write_bytes(b"\0\1\2")
    return folder


def test_folder_is_copied_byte_for_byte_and_summed_up_in_one_line(fresh: SmallBook, folder: Path) -> None:
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    answer = good(labbook("ingest", folder, at=fresh.folder))
    says(answer.out.splitlines()[0], "4 files", "4 imported", "0 refused")
    for data in FILES.values():
        assert kept(fresh, data) == data
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
    assert rows(fresh.folder, "SELECT sha256, n_bytes FROM file ORDER BY sha256") == sorted(
        (sha256(data), len(data)) for data in FILES.values()
    )


def test_json_has_the_promised_keys_and_the_truth(fresh: SmallBook, folder: Path) -> None:
    found = good(labbook("ingest", folder, "--json", at=fresh.folder)).json
    by_name = {Path(item["file"]).name: item for item in found}
    assert set(by_name) == set(FILES)
    for name, item in by_name.items():
        assert set(item) == KEYS
        assert item["status"] == "imported"
        assert item["sha256"] == sha256(FILES[name])
        assert item["rows_read"] == item["rows_kept"] + item["rows_rejected"]
        assert all(set(channel) == CHANNEL_KEYS for channel in item["channels"])
        assert all(set(finding) == FINDING_KEYS for finding in item["findings"])
    assert {name: item["format"] for name, item in by_name.items()} == {
        "log.csv": "delimited_log",
        "plate.txt": "bertec_text",
        "charges.csv": "charger_sheet",
        "charger.txt": "icharger_log",
    }
    height = by_name["log.csv"]["channels"][0]
    assert (height["name"], height["unit"], height["n"]) == ("body_height", "m", 600)
    assert height["rate_hz"] == pytest.approx(300.0, rel=0.01)
    assert (by_name["charges.csv"]["rows_kept"], by_name["charges.csv"]["channels"]) == (3, [])


def test_dry_run_says_the_same_and_writes_nothing(fresh: SmallBook, folder: Path) -> None:
    with unchanged(fresh.folder):
        tried = good(labbook("ingest", folder, "--dry-run", at=fresh.folder))
        tried_json = good(labbook("ingest", folder, "--dry-run", "--json", at=fresh.folder)).json
    says(tried.out, "4 would")
    assert good(labbook("ingest", folder, "--json", at=fresh.folder)).json == tried_json


def test_same_bytes_again_are_one_calm_line_and_change_nothing(fresh: SmallBook, folder: Path) -> None:
    copy = folder / "copy of log (2).csv"
    shutil.copy(folder / "log.csv", copy)
    first_time = good(labbook("ingest", folder / "log.csv", folder, "--json", at=fresh.folder)).json
    assert sorted(item["status"] for item in first_time) == ["duplicate"] + ["imported"] * 4
    (folder / "log.csv").touch()
    with unchanged(fresh.folder):
        for path in (folder / "log.csv", copy):
            summary, line = good(labbook("ingest", path, at=fresh.folder)).out.splitlines()
            says(line, "log.csv", "20")
            says(summary, "1 file", "0 imported", "0 refused")
        found = good(labbook("ingest", folder, "--json", at=fresh.folder)).json
    assert [item["status"] for item in found] == ["duplicate"] * 5
    first = next(item["first_import"] for item in found if item["file"].endswith("(2).csv"))
    assert (first["original_name"], first["person"]) == ("log.csv", "Ada Nwosu")
    assert set(found[0]) == KEYS


def test_one_refused_file_leaves_the_others_imported_and_ends_with_2(fresh: SmallBook, folder: Path) -> None:
    (folder / "photo.jpg").write_bytes(b"\xff\xd8\xff\xe0" + bytes(range(256)) * 4)
    (folder / "empty.csv").touch()
    answer = labbook("ingest", folder, at=fresh.folder)
    assert answer.code == 2
    assert answer.err == ""
    says(answer.out.splitlines()[0], "6 files", "4 imported", "0", "2 refused")
    assert "photo.jpg: refused" in answer.out
    assert "file_empty" in answer.out
    assert rows(fresh.folder, "SELECT count(*) FROM file") == [(4,)]
    with unchanged(fresh.folder):
        again = labbook("ingest", folder, at=fresh.folder)
    assert again.code == 2
    says(again.out.splitlines()[0], "6 files", "0 imported", "4", "2 refused")


def test_a_folder_with_the_book_in_it_gives_the_instruments_files_only(fresh: SmallBook, folder: Path) -> None:
    shutil.copytree(folder, fresh.folder / "data")
    found = good(labbook("ingest", ".", "--json", at=fresh.folder)).json
    assert {Path(item["file"]).name for item in found} == set(FILES)


def test_twenty_faults_are_all_found_at_once_and_leave_one_row_with_them(fresh: SmallBook, tmp_path: Path) -> None:
    data, expected = twenty_faults()
    path = tmp_path / "faults.csv"
    path.write_bytes(data)
    assert len(expected) >= 20
    before = contents(fresh.folder).files
    answer = labbook("ingest", path, "--json", at=fresh.folder)
    assert answer.code == 2
    (item,) = answer.json
    assert item["status"] == "refused"
    assert expected <= {finding["rule"] for finding in item["findings"]}
    assert all(len(finding["more_lines"]) <= 20 for finding in item["findings"])
    places = [(finding["rule"], finding["column"]) for finding in item["findings"]]
    assert len(places) == len(set(places))  # one a rule and column
    assert rows(fresh.folder, "SELECT count(*) FROM file") == [(0,)]
    assert rows(fresh.folder, "SELECT count(*) FROM signal") == [(0,)]
    after = contents(fresh.folder).files
    assert {name for name in after if after[name] != before.get(name)} == {"journal.jsonl"}
    assert rows(fresh.folder, "SELECT status, original_name, sha256, file FROM ingest") == [
        ("refused", "faults.csv", sha256(data), None)
    ]
    assert expected <= {rule for (rule,) in rows(fresh.folder, "SELECT rule FROM finding")}
    with unchanged(fresh.folder):
        again = labbook("ingest", path.rename(path.with_name("renamed.csv")), at=fresh.folder)
    assert again.code == 2
    says(again.out, *expected)


def test_file_that_the_disk_refuses_does_not_end_the_batch(fresh: SmallBook, folder: Path, tmp_path: Path) -> None:
    large = tmp_path / "large.txt"
    large.write_bytes(bertec_acquire(40_000))
    with no_file_above(fresh.database.stat().st_size + 50_000):
        answer = labbook("ingest", folder / "log.csv", large, at=fresh.folder)
    assert answer.code == 2
    says(answer.out, "log.csv", "delimited_log", "600 rows")
    assert answer.err == ""
    assert "not_readable" in answer.out
    says(answer.out, "2 files", "1 imported", "0", "1 refused")
    assert rows(fresh.folder, "SELECT original_name FROM ingest") == [("log.csv",)]
    again = good(labbook("ingest", folder / "log.csv", large, at=fresh.folder))
    says(again.out, "2 files", "1 imported", "0 refused")


def test_same_bytes_again_put_a_lost_raw_copy_back(fresh: SmallBook, folder: Path) -> None:
    good(labbook("ingest", folder / "log.csv", at=fresh.folder))
    raw_copy(fresh, FILES["log.csv"]).unlink()
    again = good(labbook("ingest", folder / "log.csv", at=fresh.folder))
    assert "raw copy restored" in again.out
    assert kept(fresh, FILES["log.csv"]) == FILES["log.csv"]


def test_run_is_named_before_import_and_not_silently_ignored_after(stated: SmallBook, folder: Path) -> None:
    tried = good(labbook("ingest", stated.log("r001"), "--dry-run", "--json", at=stated.folder)).json
    assert tried[0]["runs"] == ["r001"]
    good(labbook("ingest", folder / "log.csv", at=stated.folder))
    again = good(labbook("ingest", folder / "log.csv", "--run", "r002", at=stated.folder))
    says(again.out, "--run r002", "labbook assign log.csv r002")


def test_no_message_about_a_file_says_where_it_lay(fresh: SmallBook, tmp_path: Path) -> None:
    """What is sent to a colleague or the maker of a logger would tell names of people and projects."""
    private = tmp_path / "private"
    shutil.copytree(fresh.instruments, private / "rig")
    for day in ("monday", "tuesday"):
        (private / day).mkdir()
        (private / day / "odd.csv").write_text(f"{day};1\n")
    (private / "flasks.csv").write_text("radius;1\n")
    (private / "scene.toml").write_text("x = [")
    (private / "latin.csv").write_bytes(b"f\xfcr;1\n")
    commands = """
        ingest PRIVATE/rig
        ingest PRIVATE/rig/logs/r001.csv --explain
        ingest PRIVATE/rig/logs/r001.csv --dry-run
        ingest PRIVATE/rig/logs/r001.csv
        ingest PRIVATE/monday/odd.csv
        ingest PRIVATE/rig/charger --run r001 --json
        ingest PRIVATE/rig/logs/r001.csv --explain --json
        files show PRIVATE/rig/logs/r001.csv
        runs import PRIVATE/flasks.csv
        runs import PRIVATE/latin.csv --encoding utf-8
        stats compare PRIVATE/rig/runs.csv --value duration_s --by foot
        stats compare PRIVATE/rig/runs.csv --value x --by foot --json
        study compaction PRIVATE/flasks.csv --grain 3.4
        study field PRIVATE/latin.csv
        study characterisation PRIVATE/flasks.csv
        sim run --scene PRIVATE/scene.toml
    """
    for line in commands.split("\n")[1:-1]:
        answer = labbook(*line.replace("PRIVATE", str(private)).split(), at=fresh.folder)
        assert "private" not in answer.out + answer.err, line
    both = labbook("ingest", private / "monday", private / "tuesday", "--json", at=fresh.folder).json
    assert [item["file"] for item in both] == ["monday/odd.csv", "tuesday/odd.csv"]
    below = labbook("ingest", private, "--explain", "--json", at=fresh.folder).json
    assert "rig/logs/r001.csv" in {item["file"] for item in below}
