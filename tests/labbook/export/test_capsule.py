"""A capsule holds what a report rests on, as other programs read it, and is there whole or not at all."""

from __future__ import annotations

import csv
import hashlib
import io
import json
import subprocess
import zipfile
from pathlib import Path

import frictionless
import pytest
from rocrate.rocrate import ROCrate

from data_schema.errors import BookDamaged, UsageError
from ingest.store import raw_path
from labbook.book.copies.copying import raw_of
from labbook.export.capsule import write_capsule
from labbook.export.tables import TABLES
from labbook.export.verifying import verify
from tests.cli.shell import good, labbook, no_file_above
from tests.helpers.books import ADA, SmallBook, reported_book, small_book
from tests.helpers.capsules import capsule_of_small_book, entries_of, files_of
from tests.helpers.folders import contents
from tests.helpers.whole_book import whole_book
from tests.helpers.wording import refuses, says


@pytest.fixture
def book(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> SmallBook:
    monkeypatch.setenv("LABBOOK_AS", ADA)
    return reported_book(tmp_path / "small")


@pytest.fixture
def unpacked(tmp_path: Path) -> Path:
    with zipfile.ZipFile(capsule_of_small_book(tmp_path)) as archive:
        archive.extractall(tmp_path / "unpacked")
    return tmp_path / "unpacked" / "study"


def written(book: SmallBook, name: str = "study.eln", report: str | None = None) -> Path:
    file = book.folder.parent / name
    with book.open() as opened:
        write_capsule(opened, file, report)
    return file


def test_it_holds_what_the_book_and_the_report_hold(book: SmallBook) -> None:
    files = files_of(written(book))
    assert files["journal.jsonl"] == book.journal.read_bytes()
    assert files["labbook.toml"] == book.toml.read_bytes()
    raw = [raw_path(sha256) for sha256 in raw_of(entries_of(files))]
    assert {path for path in files if path.startswith("raw/")} == set(raw)
    for path in [*raw, *(path for path in files if path.startswith("signals/"))]:
        assert files[path] == (book.folder / path).read_bytes()
    (numbers,) = (book.folder / "numbers").iterdir()
    assert files["report/numbers.json"] == numbers.read_bytes()
    assert {f"tables/{name}.csv" for name in TABLES} < files.keys()
    assert {"VERIFY.md", "SHA256SUMS", "analysis.json", "data_dictionary.csv", "datapackage.json"} < files.keys()


def test_the_same_book_gives_the_same_bytes(book: SmallBook) -> None:
    first = written(book)
    again = book.folder.parent / "again" / "study.eln"
    again.parent.mkdir()
    with book.open() as opened:
        write_capsule(opened, again)
    assert first.read_bytes() == again.read_bytes()


def test_nothing_of_the_book_is_changed(book: SmallBook) -> None:
    before = contents(book.folder)
    written(book)
    assert contents(book.folder) == before


def test_a_crate_library_reads_it(unpacked: Path) -> None:
    crate = ROCrate(unpacked)
    assert crate.name == "granular bed (synthetic)"
    assert [person["name"] for person in crate.root_dataset["author"]] == [ADA]
    files = {entity.id.removeprefix("./"): entity for entity in crate.get_entities() if entity.type == "File"}
    below = {str(path.relative_to(unpacked)) for path in unpacked.rglob("*") if path.is_file()}
    assert files.keys() == below - {"ro-crate-metadata.json"}
    for path, entity in files.items():
        data = (unpacked / path).read_bytes()
        assert entity["sha256"] == hashlib.sha256(data).hexdigest()
        assert entity["contentSize"] == str(len(data))
        assert entity["encodingFormat"]


def test_it_is_a_crate_as_other_notebooks_expect_it(unpacked: Path) -> None:
    crate = json.loads((unpacked / "ro-crate-metadata.json").read_bytes())
    nodes = {node["@id"]: node for node in crate["@graph"]}
    assert len(nodes) == len(crate["@graph"])
    assert crate["@context"] == "https://w3id.org/ro/crate/1.1/context"
    assert {"version", "sdPublisher", "conformsTo"} <= nodes["ro-crate-metadata.json"].keys()
    assert {"name", "description", "datePublished", "license", "author", "hasPart"} <= nodes["./"].keys()
    reached, step = set[str](), ["./"]
    while step:
        reached |= {*step}
        step = [part["@id"] for one in step for part in nodes[one].get("hasPart", ())]
    assert reached >= {name for name, node in nodes.items() if node["@type"] in ("File", "Dataset")}


def test_the_tables_are_a_data_package(unpacked: Path) -> None:
    report = frictionless.validate(str(unpacked / "datapackage.json"))
    assert report.valid, report.flatten(["rowNumber", "fieldName", "message"])
    package = json.loads((unpacked / "datapackage.json").read_bytes())
    described = list(csv.DictReader(io.StringIO((unpacked / "data_dictionary.csv").read_text(encoding="utf-8"))))
    fields = [(one["path"], field["name"]) for one in package["resources"] for field in one["schema"]["fields"]]
    assert [(f"tables/{row['table']}.csv", row["column"]) for row in described] == fields
    assert all(row["meaning"] for row in described)


def test_the_hashes_can_be_checked_by_hand(unpacked: Path) -> None:
    done = subprocess.run(["sha256sum", "--check", "--quiet", "SHA256SUMS"], cwd=unpacked, check=False)
    assert done.returncode == 0
    previous = "0" * 64
    for line in (unpacked / "journal.jsonl").read_text(encoding="utf-8").splitlines():
        entry = json.loads(line)
        found = entry.pop("hash")
        bare = json.dumps(entry, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
        assert (entry["prev_hash"], found) == (previous, hashlib.sha256(bare.encode()).hexdigest())
        previous = found
    assert previous in (unpacked / "VERIFY.md").read_text(encoding="utf-8")


def test_text_that_a_spreadsheet_would_run_is_escaped(book: SmallBook) -> None:
    good(labbook("jumps", "reject", "r001", "2", "--reason", "other", "--note", "=1+1", at=book.folder))
    rows = list(csv.DictReader(io.StringIO(files_of(written(book))["tables/verdicts.csv"].decode())))
    assert "'=1+1" in rows[0].values()


def test_a_licence_of_labbook_toml_is_that_of_the_crate(book: SmallBook) -> None:
    book.toml.write_text(book.toml.read_text(encoding="utf-8") + '\n[sharing]\nlicense = "CC-BY-4.0"\n')
    with refuses(UsageError, "labbook.toml", "`labbook report`"):
        written(book)
    good(labbook("note", "r001", "shared", at=book.folder))
    crate = json.loads(files_of(written(book))["ro-crate-metadata.json"])
    (root,) = (node for node in crate["@graph"] if node["@id"] == "./")
    assert root["license"] == {"@id": "https://spdx.org/licenses/CC-BY-4.0.html"}


def test_a_report_is_named(tmp_path: Path) -> None:
    book = reported_book(tmp_path, "b_ad_gain=0", None)
    first, last = files_of(written(book, "first.eln", "1")), files_of(written(book, "last.eln"))
    assert first["report/numbers.json"] != last["report/numbers.json"]
    assert first["tables/runs.csv"] == last["tables/runs.csv"]


def test_pages_that_were_changed_are_refused(book: SmallBook) -> None:
    good(labbook("report", "--out", "paper", at=book.folder))
    files = files_of(written(book))
    assert files["report/report.html"] == (book.folder / "paper" / "report.html").read_bytes()
    (book.folder / "paper" / "report.html").write_text("<p>better", encoding="utf-8")
    with refuses(UsageError, "report.html", "`labbook report`", "--report"):
        written(book, "other.eln")
    written(book, "earlier.eln", "1")


def test_a_book_without_a_report_is_told_how_to_make_one(tmp_path: Path) -> None:
    with refuses(UsageError, "no report", "`labbook report`"):
        written(small_book(tmp_path))


@pytest.mark.parametrize("name", ["study.zip", "study"])
def test_a_capsule_is_called_one(book: SmallBook, name: str) -> None:
    with refuses(UsageError, name, ".eln"):
        written(book, name)


def test_a_file_that_exists_is_not_replaced(book: SmallBook) -> None:
    file = book.folder.parent / "study.eln"
    file.write_bytes(b"mine")
    with refuses(UsageError, "study.eln", "exists"):
        written(book)
    assert file.read_bytes() == b"mine"


def test_a_full_disk_leaves_nothing(book: SmallBook) -> None:
    before = contents(book.folder.parent)
    with no_file_above(200_000), pytest.raises(OSError, match="File too large"):
        written(book)
    assert contents(book.folder.parent) == before


def test_a_raw_copy_that_was_changed_is_refused(book: SmallBook) -> None:
    copy = next((book.folder / "raw").rglob("*.zst"))
    copy.chmod(0o644)
    copy.write_bytes(copy.read_bytes()[:-9])
    with refuses(BookDamaged, copy.name):
        written(book)
    assert not (book.folder.parent / "study.eln").exists()


def test_the_command_says_what_was_written(book: SmallBook) -> None:
    answer = good(labbook("export", "--capsule", "../study.eln", "--json", at=book.folder))
    file = book.folder.parent / "study.eln"
    assert answer.json["sha256"] == hashlib.sha256(file.read_bytes()).hexdigest()
    refused = labbook("export", "--capsule", "../study.eln", at=book.folder)
    assert refused.code == 2
    assert says(refused.err, "study.eln", "exists")


def test_a_book_on_postgresql_gives_a_capsule_that_is_whole(tmp_path: Path, postgres_url: str) -> None:
    file = written(whole_book(tmp_path / "book", postgres_url))
    assert not verify(file).differences
    assert postgres_url.encode() in files_of(file)["labbook.toml"]
