"""The command `labbook`: its commands, and how errors become sentences and exit codes.

The commands' files leave out `from __future__ import annotations`: Typer would compile every annotation of every
command from text whenever labbook starts, which takes a tenth of the start.
"""

from __future__ import annotations

import contextlib
import errno
import functools
import gc
import json
import os
import re
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any, NoReturn

import typer.main
from typer.core import TyperGroup

from data_schema.errors import LabbookError, disk_full, without_passwords
from labbook.cli.common import as_command
from labbook.terminal import printable_json, say

GARBAGE_AFTER = 1_000_000
"""New objects between two passes of the garbage collector. With Python's own 700 a tenth of a command's time goes into
looking again and again at all that was imported."""

RIG, JUDGE, REPORT, SIMULATE, BOOK = "Day at the rig", "Look and judge", "Report", "Simulate", "The book"

COMMANDS = {
    "ingest": (RIG, "ingest"),
    "watch": (RIG, "watch"),
    "today": (RIG, "attention"),
    "attention": (RIG, "attention"),
    "note": (RIG, "statements"),
    "charge": (RIG, "statements"),
    "check": (RIG, "statements"),
    "correct": (RIG, "statements"),
    "void": (RIG, "statements"),
    "assign": (RIG, "statements"),
    "channels": (RIG, "views"),
    "formats": (RIG, "views"),
    "calibrate-sensor": (RIG, "calibrate"),
    "show": (JUDGE, "views"),
    "plot": (JUDGE, "views"),
    "journal": (JUDGE, "views"),
    "web": (JUDGE, "web"),
    "review": (JUDGE, "web"),
    "report": (REPORT, "reports"),
    "compare": (REPORT, "views"),
    "calibrate": (REPORT, "calibrate"),
    "plan": (REPORT, "plan"),
    "power": (REPORT, "plan"),
    "analysis": (REPORT, "views"),
    "why": (REPORT, "views"),
    "export": (REPORT, "export"),
    "verify": (REPORT, "export"),
    "init": (BOOK, "book"),
    "config": (BOOK, "views"),
    "demo": (BOOK, "book"),
    "backup": (BOOK, "book"),
    "restore": (BOOK, "book"),
    "merge": (BOOK, "book"),
    "rebuild": (BOOK, "book"),
}
"""The commands in the order of help: the heading, and the module of `labbook.cli` that has the function of the name."""

TAKE_FACTORS = ("report", "compare", "calibrate")
"""Commands that take the study's own factors as options, which only the book knows."""

GROUPS = {
    "runs": (RIG, "Runs: list them, what differs between two, import a run sheet, see what has no run yet."),
    "files": (RIG, "Files of the instruments: how they were read, reading them again, taking them out of use."),
    "jumps": (JUDGE, "Jumps: what to look at, list, reject, accept, move, add, clear, who agrees."),
    "reports": (REPORT, "Reports that were made: list, show, what moved between two, and by what."),
    "study": (REPORT, "Studies of the thesis, each from what was measured to its verdict."),
    "stats": (REPORT, "Statistics on a table or on the book: tests, savings, equivalence."),
    "sim": (SIMULATE, "Simulate jumps: one scene, from robot to ground."),
    "db": (BOOK, "The database: its state, whether the book is whole, clearing up."),
}
"""Groups of commands, each a module of its name, under which heading they stand, and what they are for."""


@dataclass(frozen=True)
class _Commands(Mapping[str, Any]):
    """Commands by name, each loaded and built when it is asked for: building all is a tenth of a command's time."""

    names: Callable[[], Sequence[str]]
    build: Callable[[str], Any]

    def __getitem__(self, name: str) -> Any:
        if name not in self.names():
            raise KeyError(name)
        return self.build(name)

    def __iter__(self) -> Iterator[str]:
        return iter(self.names())

    def __len__(self) -> int:
        return len(self.names())


@functools.cache
def application() -> TyperGroup:
    """Put the commands together."""
    return TyperGroup(
        name="labbook",
        commands=_Commands(lambda: (*COMMANDS, *GROUPS), _build),  # type: ignore[arg-type]
        help="The lab notebook of a robotics lab that counts: raw instrument files in, a traceable report out.",
        params=list(typer.main.get_install_completion_arguments()),
        no_args_is_help=True,
        rich_markup_mode="markdown",
        context_settings={"help_option_names": ["-h", "--help"]},
        epilog="Every command takes --debug, which shows where an error arose. `labbook --version` tells the version.",
    )


@functools.cache
def _build(name: str) -> Any:
    """Build a command, or a group whose commands are loaded when one of them is asked for."""
    if name in GROUPS:
        heading, purpose = GROUPS[name]
        below = functools.cache(lambda: _group(name))
        return TyperGroup(
            name=name,
            commands=_Commands(lambda: tuple(below()), lambda one: below()[one]),  # type: ignore[arg-type]
            help=purpose,
            no_args_is_help=True,
            rich_markup_mode="markdown",
            rich_help_panel=heading,
        )
    heading, module = COMMANDS[name]
    settings = {"allow_extra_args": True, "ignore_unknown_options": True} if name in TAKE_FACTORS else None
    alone = typer.Typer(add_completion=False, rich_markup_mode="markdown")
    function = getattr(import_module(f"labbook.cli.{module}"), name.replace("-", "_"))
    alone.command(name, rich_help_panel=heading, context_settings=settings)(as_command(function))
    return typer.main.get_command(alone)


def _group(name: str) -> Mapping[str, Any]:
    app = import_module(f"labbook.cli.{name}").app
    app.rich_markup_mode = "markdown"
    for one in app.registered_commands:
        one.callback = as_command(one.callback)
    return typer.main.get_group(app).commands


def run(words: Sequence[str] | None = None) -> NoReturn:
    """Run the command line: what a user caused becomes its sentence and exit code, `--debug` shows where it arose."""
    gc.set_threshold(GARBAGE_AFTER)
    given = sys.argv[1:] if words is None else words
    debug = "--debug" in given
    arguments = [argument for argument in given if argument != "--debug"]
    try:
        if "--version" in arguments and {*arguments} <= {"--version", "--json"}:
            from importlib.metadata import version as version_of  # which is that of the installed package

            version = version_of("robot-labbook")
            typer.echo(json.dumps({"version": version}) if "--json" in arguments else f"labbook {version}")
            sys.exit(0)
        code = application()(arguments, prog_name="labbook", standalone_mode=False)
    except (LabbookError, OSError, typer.TyperException, typer.Abort) as error:
        if debug:
            raise
        sentence, code = explain_error(error)
        with contextlib.suppress(OSError):  # the disk that takes the message may be full, too
            if sentence and "--json" in arguments:
                typer.echo(printable_json(json.dumps({"error": sentence, "exit_code": code}, ensure_ascii=False)))
            if sentence:
                say(f"labbook: {sentence}", err=True)
        _leave_unwritten()
    sys.exit(code or 0)


def _leave_unwritten() -> None:
    """Drop what standard output and error did not take: Python would try again at the end, and change the exit code."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _formatted(error: typer.TyperException) -> str:
    """Return what the library says, but for a number that it cannot read: how it is written."""
    for fault in getattr(error.__cause__, "errors", tuple)():
        given, option = str(fault["input"]), getattr(error, "param", None)
        if fault["type"] not in ("float_parsing", "int_parsing"):
            continue
        if option is not None and option.multiple and "," in given:
            one_by_one = " ".join(f"{option.opts[0]} {part.strip()}" for part in given.split(",") if part.strip())
            error.message = f"{given!r} is no number: give several one by one, {one_by_one}, and decimals with a point"
        elif fault["type"] == "float_parsing" and re.fullmatch(r"[+-]?\d*,\d+", given):
            error.message = f"{given!r} has a decimal comma, write {given.replace(',', '.')}"
        elif fault["type"] == "float_parsing":
            error.message = f"{given!r} is no number"
        elif fault["type"] == "int_parsing":
            error.message = f"{given!r} is no whole number"
    return error.format_message()


def explain_error(error: Exception) -> tuple[str, int]:
    """Return the sentence that tells a user what went wrong and what to do, and the exit code."""
    match error:
        case LabbookError():
            return str(error), error.exit_code
        case OSError(errno=errno.ENOSPC | errno.EDQUOT):
            return disk_full(error.filename or ""), 3
        case OSError():
            where = f" {error.filename}" if error.filename else ""
            failed = error.errno == errno.EIO
            check = "the disk" if failed else "the path, its permissions and the disk"
            return f"{error.strerror or error}{where}: check {check}.", 3 if failed else 2
        case typer.TyperException():
            command = getattr(getattr(error, "ctx", None), "command_path", "labbook")
            message = without_passwords(" ".join(_formatted(error).split()).rstrip("."))
            if not message:
                return "", 2  # a group without a command has shown its help instead
            end = "" if message.endswith("?") else "."
            return f"{message[0].lower()}{message[1:]}{end} See `{command} --help` for its use, with an example.", 2
        case _:
            return "no answer was given, so nothing was done: answer, or give it as an option.", 2
