"""Every command that a message or a document names exists, with its options."""

from __future__ import annotations

import ast
import re
import shlex
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path

import pytest

from labbook.cli.declaring import Declared
from labbook.cli.main import COMMANDS, GROUPS, TAKE_FACTORS
from tests.helpers.advice import command

PROJECT = Path(__file__).parents[2]
PACKAGES = ("data_schema", "ingest", "labbook", "reports", "simulator", "stats")
DOCUMENTS = sorted([PROJECT / "README.md", PROJECT / "CONTRIBUTING.md", *(PROJECT / "docs").glob("*.md")])
FREE = "{}"
"""Stands for what a message fills in."""
FACTOR = "--foot"
"""The option of a factor of the demonstration, which examples have."""


def texts(path: Path) -> Iterator[str]:
    """Yield the texts in a file, with what is filled into them left free."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.JoinedStr):
            pieces = (str(piece.value) if isinstance(piece, ast.Constant) else FREE for piece in node.values)
            yield "".join(pieces)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value


def snippets(pattern: str) -> list[str]:
    """Return all snippets in backquotes, in texts of the product, that match a pattern."""
    sources = [path for package in PACKAGES for path in sorted((PROJECT / package).rglob("*.py"))]
    found = {snippet for path in sources for text in texts(path) for snippet in re.findall(r"`([^`]*)`", text)}
    return sorted(snippet for snippet in found if re.match(pattern, snippet))


def in_documents() -> list[str]:
    """Return the commands of the documents: lines of their own, and snippets in backquotes."""
    whole = "\n".join(path.read_text(encoding="utf-8") for path in DOCUMENTS)
    lines = re.findall(r"^ {4}(labbook .*?)(?:\s+#.*)?$", whole, re.MULTILINE)
    quoted = re.findall(r"(?<!`)`(labbook [a-z-][^`]*)`", whole)
    return sorted({*lines, *quoted})


def options_of(found: object) -> set[str]:
    return {"--help", "--debug", *(name for parameter in found.params for name in parameter.opts)}  # type: ignore[attr-defined]


@pytest.mark.parametrize("snippet", [*snippets(r"labbook [a-z]"), *in_documents()])
def test_a_command_that_is_named_exists_with_its_options(snippet: str) -> None:
    words = shlex.split(" ".join(snippet.split()).replace("...", "WORD"))[1:]
    path = words[:2] if words[0] in GROUPS and len(words) > 1 and not words[1].startswith(("-", FREE)) else words[:1]
    path = [word for word in path if not word.startswith("-")]
    found = command(*path)
    if found is None and words[0] in GROUPS:
        found = command(words[0])
    assert found is not None, snippet
    if words[0] not in TAKE_FACTORS:
        named = {word.partition("=")[0] for word in words if word.startswith("--")}
        assert named <= options_of(found)


@pytest.mark.parametrize("snippet", snippets("--[a-z]"))
def test_an_option_that_is_named_is_one_of_some_command(snippet: str) -> None:
    known = {name for each in COMMANDS for name in options_of(command(each))}
    for group in GROUPS:
        known |= {name for each in command(group).commands.values() for name in options_of(each)}
    known |= {f"--{one.name.replace('_', '-')}" for one in fields(Declared)} | {FACTOR}
    named = set(re.findall(r"(?<!\S)--[a-z][a-z-]*", snippet))
    assert named
    assert named <= known
