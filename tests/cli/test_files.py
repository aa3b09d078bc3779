"""`labbook files` and `labbook runs dismiss` from the command line."""

from __future__ import annotations

from pathlib import Path

from tests.cli.shell import good, labbook, refused
from tests.helpers.books import small_book


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
    assert "no file would be read otherwise" in good(labbook("files", "reread", "--all", at=at)).out
    good(labbook("files", "withdraw", "r001.csv", "--why", "another robot", at=at))
    again = good(labbook("ingest", small.log("r001"), at=at)).out
    assert "another robot" in again
    assert "labbook files restore r001.csv" in again
    refused(labbook("files", "reread", "r001.csv", at=at), 2, "was withdrawn")
    refused(labbook("files", "withdraw", "r001.csv", "--why", "again", at=at), 2, "withdrawn already")
    good(labbook("files", "restore", "r001.csv", at=at))
    good(labbook("jumps", "list", "r001", at=at))
    refused(labbook("files", "show", "r999.csv", at=at), 2, "r999.csv")
    refused(labbook("files", "reread", at=at), 2, "--all")


def test_two_files_of_one_name_are_told_apart_by_uid(tmp_path: Path) -> None:
    small = small_book(tmp_path)
    other = tmp_path / "r001.csv"
    other.write_bytes(small.log("r001").read_bytes().rsplit(b"\n", 2)[0] + b"\n")
    good(labbook("ingest", other, at=small.folder))
    refused(labbook("files", "show", "r001.csv", at=small.folder), 2, "2 imported files are called 'r001.csv'")
    uids = [
        item["reading"]["file_uid"]
        for item in good(labbook("files", "list", "--json", at=small.folder)).json
        if item["reading"]["name"] == "r001.csv"
    ]
    assert len(uids) == 2
    good(labbook("files", "show", uids[1], at=small.folder))
