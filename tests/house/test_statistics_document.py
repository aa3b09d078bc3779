"""docs/statistics.md shows what its tables hold."""

from __future__ import annotations

from benchmarks.statistics_document import FOLDER, PAGE, TABLES, page


def test_the_page_shows_what_its_tables_hold() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert page(text) == text
    assert text.count("<!-- from ") == len(TABLES)
    assert sorted(path.stem for path in FOLDER.iterdir()) == sorted(TABLES)
