"""`labbook files` and `labbook runs dismiss` from the command line."""

from __future__ import annotations

from pathlib import Path

from tests.cli.shell import good, labbook, refused, unchanged
from tests.helpers.books import small_book
from tests.helpers.wording import says


def test_a_file_is_listed_read_again_withdrawn_and_restored(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    at = small.folder
    listed = good(labbook("files", "list", "--json", at=at)).json
    assert {item["reading"]["name"] for item in listed} >= {"r001.csv", "2021-06-14.csv"}
    sha256 = next(item["reading"]["sha256"] for item in listed if item["reading"]["name"] == "r001.csv")
    gain = ("--column", "k_gain=aux")
    tried = good(labbook("files", "reread", sha256[:8], *gain, "--dry-run", "--json", at=at)).json
    assert tried[0]["changes"]
    done = good(labbook("files", "reread", small.log("r001"), *gain, "--why", "tried", "--json", at=at)).json
    assert done[0]["changes"] == tried[0]["changes"]
    shown = good(labbook("files", "show", "r001.csv", "--json", at=at)).json
    assert [item["reading"]["status"] for item in shown["readings"]] == ["superseded", "imported"]
    assert [item["reading"]["why"] for item in shown["readings"]] == [None, "tried"]
    good(labbook("files", "reread", "r001.csv", "--nothing-declared", at=at))
    says(good(labbook("files", "reread", "--all", at=at)).out, "no file would")
    said = good(labbook("files", "withdraw", "r001.csv", "--why", "another robot", "--json", at=at)).json
    assert {"file", "why", "said", "reports"} <= set(said)
    again = good(labbook("ingest", small.log("r001"), at=at)).out
    assert "another robot" in again
    says(again, "files restore r001.csv")
    refused(labbook("files", "reread", "r001.csv", at=at), 2, "was withdrawn")
    with unchanged(at):
        assert "withdrawn already" in good(labbook("files", "withdraw", "r001.csv", "--why", "again", at=at)).out
    assert "in use again" in good(labbook("files", "restore", "r001.csv", "--json", at=at)).json["said"]
    good(labbook("jumps", "list", "r001", at=at))
    refused(labbook("files", "show", "r999.csv", at=at), 2, "r999.csv")
    refused(labbook("files", "reread", at=at), 2, "--all")


def test_several_files_are_read_again_in_one_command(tmp_path: Path) -> None:
    at = small_book(tmp_path).folder
    gain = ("--column", "k_gain=aux")
    with unchanged(at):
        refused(labbook("files", "reread", "r001.csv", "r999.csv", *gain, at=at), 2, "r999.csv")
    done = good(labbook("files", "reread", "r001.csv", "r002.csv", "r001.csv", *gain, "--json", at=at)).json
    assert [item["file"] for item in done] == ["r001.csv", "r002.csv"]
    assert all("aux" in " ".join(item["changes"]) for item in done)
    again = good(labbook("files", "reread", "r001.csv", "r002.csv", "--json", at=at)).json
    assert [item["changes"] for item in again] == [["nothing comes out otherwise"]] * 2


def test_two_files_of_one_name_are_told_apart_by_uid(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    other = tmp_path / "r001.csv"
    other.write_bytes(small.log("r001").read_bytes().rsplit(b"\n", 2)[0] + b"\n")
    good(labbook("ingest", other, at=small.folder))
    refused(labbook("files", "show", "r001.csv", at=small.folder), 2, "2 imported files are called 'r001.csv'")
    listed = [item["reading"] for item in good(labbook("files", "list", "--json", at=small.folder)).json]
    _first, second = (reading["file_uid"] for reading in listed if reading["name"] == "r001.csv")
    good(labbook("files", "show", second, at=small.folder))


def test_an_item_of_the_inbox_is_dismissed_and_comes_back(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    sheet, log = tmp_path / "other.csv", tmp_path / "bench.csv"
    sheet.write_text("run,mAh,minutes\nr001,99,12\n")
    log.write_bytes(small.log("r001").read_bytes().rsplit(b"\n", 2)[0] + b"\n")
    good(labbook("ingest", sheet, log, at=small.folder))
    for item in ("other.csv#1", "bench.csv"):
        assert item in good(labbook("runs", "inbox", at=small.folder)).out
        said = good(labbook("runs", "dismiss", item, "--why", "not ours", "--json", at=small.folder)).json
        assert {"item", "why", "said", "reports"} <= set(said)
        assert item not in good(labbook("runs", "inbox", at=small.folder)).out
        assert set(good(labbook("runs", "restore", item, "--json", at=small.folder)).json) == set(said)
        assert item in good(labbook("runs", "inbox", at=small.folder)).out
    refused(labbook("runs", "dismiss", "2021-06-14.csv#1", "--why", "x", at=small.folder), 2, "belongs to run r001")
