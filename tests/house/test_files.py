"""Every file says what it is and leaves nothing undone."""

from __future__ import annotations

import re
from pathlib import Path

PROJECT = Path(__file__).parents[2]
PACKAGES = ("data_schema", "ingest", "labbook", "reports", "simulator", "stats")
SOURCES = sorted(path for package in PACKAGES for path in (PROJECT / package).rglob("*.py"))


def name(path: Path) -> str:
    return str(path.relative_to(PROJECT))


def test_every_module_says_what_it_is() -> None:
    silent = [name(path) for path in SOURCES if path.read_text("utf-8") and not documented(path)]
    assert silent == []


def documented(path: Path) -> bool:
    return re.match(r'(#.*\n|\s)*r?"""', path.read_text(encoding="utf-8")) is not None


def test_nothing_is_left_undone() -> None:
    marks = ("TO" + "DO", "FIX" + "ME", "XX" + "X")
    left = [name(path) for path in SOURCES if any(mark in path.read_text(encoding="utf-8") for mark in marks)]
    assert left == []


def test_every_package_has_its_tests() -> None:
    assert {path.name for path in (PROJECT / "tests").iterdir() if path.is_dir()} >= set(PACKAGES)


def test_tests_are_no_packages() -> None:
    assert list((PROJECT / "tests").rglob("__init__.py")) == []
