"""docs/references.md lists every source that code and scenes cite with its year."""

from __future__ import annotations

import re
from pathlib import Path

PROJECT = Path(__file__).parents[2]
PACKAGES = ("data_schema", "ingest", "labbook", "reports", "simulator", "stats")
CITED = re.compile(r"\b([A-Z]\w+)(?:,? (?:and|&) (?:[A-Z]\w+|others)| et al\.)?,? \(?((?:18|19|20)\d\d)\b(?!-)")


def cited() -> set[tuple[str, str]]:
    """Names of first authors (or of the last before the year) and years, in the sources and scenes."""
    paths = [path for package in PACKAGES for path in (PROJECT / package).rglob("*") if path.suffix in (".py", ".toml")]
    texts = (" ".join(path.read_text(encoding="utf-8").split()) for path in paths)
    return {found for text in texts for found in CITED.findall(text)}


def test_every_source_with_a_year_is_listed() -> None:
    entries = " ".join((PROJECT / "docs" / "references.md").read_text(encoding="utf-8").split()).split(" - ")
    missing = {
        (author, year)
        for author, year in cited()
        if not any(author in entry and f"({year})" in entry for entry in entries)
    }
    assert missing == set()


def test_the_citation_is_of_this_version() -> None:
    citation = (PROJECT / "CITATION.cff").read_text(encoding="utf-8")
    project = (PROJECT / "pyproject.toml").read_text(encoding="utf-8")
    version = re.search(r'^version = "(.*)"$', project, re.MULTILINE)
    assert version is not None
    assert f"\nversion: {version[1]}\n" in citation
    for key in ("cff-version: 1.2.0", "message: ", "title: ", "authors:"):
        assert f"\n{key}" in f"\n{citation}"
