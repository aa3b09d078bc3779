"""Every command's help: 80 columns, every option explained, an example; groups, completion and version."""

from __future__ import annotations

import functools
import importlib.metadata
import os
import re
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from labbook.cli.main import application
from tests.cli.shell import LABBOOK, good, labbook

ROOT: Any = application()


def paths(command: Any = ROOT, above: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Every command with the words that call it; groups too."""
    yield above, command
    for name, below in getattr(command, "commands", {}).items():
        yield from paths(below, (*above, name))


ALL = list(paths())


@functools.cache
def help_of(words: tuple[str, ...]) -> str:
    """What a command says of itself, asked once for all tests."""
    return good(labbook(*words, "--help", at=Path.cwd())).out


def ids(items: list[tuple[tuple[str, ...], Any]]) -> list[str]:
    return [" ".join(words) or "labbook" for words, _command in items]


@pytest.mark.parametrize(("words", "command"), ALL, ids=ids(ALL))
def test_help_fits_80_columns_and_explains_everything(words: tuple[str, ...], command: Any) -> None:
    shown = help_of(words)
    assert max(map(len, shown.splitlines())) <= 80
    assert "…" not in shown
    if command is not ROOT:
        assert all(parameter.help for parameter in command.params)
    if not hasattr(command, "commands"):
        assert f"Example: labbook {' '.join(words)}" in " ".join(shown.split())
        options = {option for parameter in command.params for option in parameter.opts}
        assert "--json" in options
        example = command.help[command.help.index("Example: ") :]
        assert set(re.findall(r"--[a-z-]+", example)) <= {*options, "--foot"}
    for written in [command.help, *(parameter.help for parameter in command.params if parameter.help)]:
        assert bare(written) in bare(shown)  # neither [simulation] nor COUNT[:log] is taken for markup


def bare(text: str) -> str:
    """Letters and signs alone: without the frames, the breaks of lines and the signs of code."""
    return re.sub(r"[\s`\u2500-\u257f]", "", text)


@pytest.mark.parametrize("words", ["", "runs"])
def test_a_group_without_a_command_shows_its_help(words: str, tmp_path: Path) -> None:
    shown = labbook(*words.split(), at=tmp_path)
    assert shown.code == 2
    assert "Usage: labbook" in shown.out + shown.err
    assert ("Commands" if words else "Day at the rig") in shown.out + shown.err


@pytest.mark.parametrize("asked", ["COMP_WORDS", "_TYPER_COMPLETE_ARGS"])
def test_a_shell_can_complete_the_commands_of_a_group(asked: str) -> None:
    shell = "bash" if asked == "COMP_WORDS" else "zsh"
    asking = {"_LABBOOK_COMPLETE": f"complete_{shell}", asked: "labbook sim ", "COMP_CWORD": "2"}
    done = subprocess.run([LABBOOK], env={**os.environ, **asking}, capture_output=True, text=True, check=False)
    assert "sweep" in done.stdout


def test_the_version_is_that_of_the_package(tmp_path: Path) -> None:
    version = importlib.metadata.version("robot-labbook")
    assert good(labbook("--version", at=tmp_path)).out.strip() == f"labbook {version}"
    assert good(labbook("--version", "--json", at=tmp_path)).json == {"version": version}
