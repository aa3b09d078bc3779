"""The real files beside the project through the real command, twice, in a fresh book."""

from __future__ import annotations

import csv
import hashlib
from pathlib import Path

import pytest

from tests.cli.shell import good, labbook, rows, unchanged

PROJECT = Path(__file__).parents[2]
SAMPLES = PROJECT.parent / "shared" / "samples"


@pytest.mark.skipif(not SAMPLES.is_dir(), reason="the sample files lie beside the project: ../shared/samples")
def test_samples_are_imported_or_refused_as_listed_and_the_second_time_change_nothing(tmp_path: Path) -> None:
    expected = {
        row["file"]: row for row in csv.DictReader((PROJECT / "tests/sample_expectations.csv").read_text().splitlines())
    }
    good(labbook("init", "book", "--as", "Ada Nwosu", at=tmp_path))
    book = tmp_path / "book"
    first = labbook("ingest", SAMPLES, "--json", at=book)
    assert (first.code, first.err) == (2, "")
    found = {str(Path(item["file"])): item for item in first.json}
    assert set(found) == set(expected)
    for name, row in expected.items():
        item = found[name]
        found_of_it = (item["status"], item["format"], str(item["rows_kept"]))
        assert found_of_it == (row["status"], row["format"], row["rows_kept"]), name
        assert row["rule"] in {"", *(finding["rule"] for finding in item["findings"])}, name
        assert item["sha256"] == hashlib.sha256((SAMPLES / name).read_bytes()).hexdigest()
        copy = book / "raw" / item["sha256"][:2] / f"{item['sha256']}.zst"
        assert copy.exists() == (item["status"] == "imported")
    assert rows(book, "SELECT count(*) FROM ingest") == [(len(expected),)]

    with unchanged(book):
        second = labbook("ingest", SAMPLES, "--json", at=book)
    assert second.code == 2
    again = {str(Path(item["file"])): item for item in second.json}
    for name, item in again.items():
        before = found[name]
        if before["status"] == "imported":
            assert item["status"] == "duplicate"
            assert item["first_import"]["original_name"] == Path(name).name
        else:
            assert item == before
