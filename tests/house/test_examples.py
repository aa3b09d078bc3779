"""The examples in docstrings and in README.md give what they say."""

from __future__ import annotations

import doctest
import importlib
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[2]
PACKAGES = ("data_schema", "ingest", "labbook", "reports", "simulator", "stats")
WITH_EXAMPLES = [
    ".".join(path.relative_to(PROJECT).with_suffix("").parts)
    for package in PACKAGES
    for path in sorted((PROJECT / package).rglob("*.py"))
    if ">>> " in path.read_text(encoding="utf-8")
]


@pytest.mark.parametrize("module", WITH_EXAMPLES)
def test_examples_of_docstrings_give_what_they_say(module: str) -> None:
    found = doctest.testmod(importlib.import_module(module))
    assert found.attempted > 0
    assert found.failed == 0


def test_examples_of_the_readme_give_what_they_say() -> None:
    found = doctest.testfile(str(PROJECT / "README.md"), module_relative=False)
    assert found.attempted > 0
    assert found.failed == 0
