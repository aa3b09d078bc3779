"""docs/formats.md says what the readers do, and docs/statistics.md shows what its tables hold."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

import pytest

from benchmarks.statistics_document import FOLDER, PAGE, TABLES, page
from ingest.formats.registry import FORMATS

PROJECT = Path(__file__).parents[2]
SAMPLES = PROJECT.parent / "shared" / "samples"
ROWS_ANEW = "write its rows anew: python scripts/formats_document.py"


def writer() -> ModuleType:
    spec = importlib.util.spec_from_file_location("formats_document", PROJECT / "scripts" / "formats_document.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_format_stands_in_the_document() -> None:
    text = (PROJECT / "docs" / "formats.md").read_text(encoding="utf-8")
    assert [each.name for each in FORMATS if f"`{each.name}`" not in text] == [], ROWS_ANEW
    assert writer().with_rows_anew(text) == text, ROWS_ANEW


@pytest.mark.skipif(not SAMPLES.is_dir(), reason="the sample files lie beside the project: ../shared/samples")
def test_the_document_is_what_the_samples_give() -> None:
    assert (PROJECT / "docs" / "formats.md").read_text(encoding="utf-8") == writer().document(SAMPLES), (
        "write it anew: python scripts/formats_document.py ../shared/samples"
    )


def test_the_page_of_statistics_shows_what_its_tables_hold() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert page(text) == text
    assert text.count("<!-- from ") == len(TABLES)
    assert sorted(path.stem for path in FOLDER.iterdir()) == sorted(TABLES)
