"""What the README and the documents name exists: links, files, Python names and targets of make."""

from __future__ import annotations

import importlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

PROJECT = Path(__file__).parents[2]
DOCUMENTS = sorted([PROJECT / "README.md", PROJECT / "CONTRIBUTING.md", *(PROJECT / "docs").glob("*.md")])
MADE_LATER = {"docs/performance.md"}
"""Written by `make bench`."""
PACKAGES = ("data_schema", "ingest", "labbook", "reports", "simulator", "stats")
PLUGIN = "hopper_format.py"
"""The plug-in that docs/your-own-data.md has people write."""


def ids(path: Path) -> str:
    return str(path.relative_to(PROJECT))


@pytest.mark.parametrize("document", DOCUMENTS, ids=ids)
def test_links_lead_somewhere(document: Path) -> None:
    links = re.findall(r"\]\((?!https?:|#)([^)#\s]+)", document.read_text(encoding="utf-8"))
    missing = [
        link
        for link in links
        if not (document.parent / link).exists() and ids((document.parent / link).resolve()) not in MADE_LATER
    ]
    assert missing == []


def places() -> Iterator[str]:
    """Every file and folder of the project, with and without the folders that it lies in."""
    for folder in (*PACKAGES, "benchmarks", "docs", "scripts", "tests"):
        for path in [PROJECT / folder, *(PROJECT / folder).rglob("*")]:
            parts = path.relative_to(PROJECT).parts
            yield from ("/".join(parts[start:]) for start in range(len(parts)))


def test_files_and_folders_that_documents_name_exist() -> None:
    there = set(places())
    missing = [
        (ids(document), path)
        for document in DOCUMENTS
        for path in re.findall(r"`([\w.]+(?:/[\w.-]+)+/?|\w+\.py)`", document.read_text(encoding="utf-8"))
        if (path.endswith(".py") or path.split("/")[0] in there) and path.rstrip("/") not in there
    ]
    assert [(document, path) for document, path in missing if "NAME" not in path and path != PLUGIN] == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=ids)
def test_names_of_python_that_documents_use_exist(document: Path) -> None:
    for name in re.findall(rf"`((?:{'|'.join(PACKAGES)})\.[\w.]+)[`(]", document.read_text(encoding="utf-8")):
        package, first, *rest = name.split(".")
        if name in ("labbook.toml", "labbook.db", "labbook.formats"):
            continue  # files of a book, and the entry point of plug-ins
        found: Any = importlib.import_module(package)
        for word in (first, *rest):
            if not hasattr(found, word):
                importlib.import_module(f"{found.__name__}.{word}")
            found = getattr(found, word)


@pytest.mark.parametrize("document", DOCUMENTS, ids=ids)
def test_make_targets_exist(document: Path) -> None:
    targets = set(re.findall(r"^([a-z]+):", (PROJECT / "Makefile").read_text(), re.MULTILINE))
    said = re.findall(r"`(?:[A-Z_]+=\S+ )?make ([a-z]+)", document.read_text(encoding="utf-8"))
    assert set(said) <= targets
