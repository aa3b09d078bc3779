"""The command `labbook`: its commands, and how errors become sentences and exit codes.

The commands' files leave out `from __future__ import annotations`: Typer would compile every annotation of every
command from text whenever labbook starts, which takes a tenth of the start.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import json
import os
import re
import sys
from collections.abc import Collection, Sequence
from typing import NoReturn

import typer

from data_schema.errors import LabbookError, UsageError
from labbook.cli.book import backup, demo, init, merge, rebuild, restore
from labbook.cli.calibrate import calibrate
from labbook.cli.calibrate_sensor import calibrate_sensor
from labbook.cli.ingest import ingest
from labbook.cli.plan import plan
from labbook.cli.power import power
from labbook.cli.report import report
from labbook.cli.start import INTERRUPTED, print_interrupted
from labbook.cli.statements import assign, charge, check, correct, note, void
from labbook.cli.views import analysis, channels, compare, config, formats, plot, show, today, why
from labbook.terminal import printable_json, say

GARBAGE_AFTER = 1_000_000
"""New objects between two passes of the garbage collector. With Python's own 700 a tenth of a command's time goes into
looking again and again at all that was imported."""

RIG, JUDGE, REPORT, SIMULATE, BOOK = "Day at the rig", "Look and judge", "Report", "Simulate", "The book"

COMMANDS = {
    RIG: (ingest, today, note, charge, check, correct, void, assign, channels, formats, calibrate_sensor),
    JUDGE: (show, plot),
    REPORT: (report, compare, calibrate, plan, power, analysis, why),
    BOOK: (init, config, demo, backup, restore, merge, rebuild),
}
"""The commands under the headings of help, in its order; a new one is a function, and its name here."""

TAKE_FACTORS = (report, compare, calibrate)
"""Commands that take the study's own factors as options, which only the book knows."""

GROUPS = {
    "runs": (RIG, "Runs: list them, import a run sheet, see what has no run yet."),
    "files": (RIG, "Files of the instruments: how they were read, reading them again, taking them out of use."),
    "jumps": (JUDGE, "Jumps of a run: list, reject, accept, clear."),
    "reports": (REPORT, "Reports that were made: list, show, what moved between two, and by what."),
    "study": (REPORT, "Studies of the thesis, each from what was measured to its verdict."),
    "stats": (REPORT, "Statistics on a table or on the book: tests, savings, equivalence."),
    "sim": (SIMULATE, "Simulate jumps: one scene, from robot to ground."),
    "db": (BOOK, "The database: its revision, whether the book is whole, upgrading, copying, clearing up."),
}
"""Groups of commands, each a module of its name, under which heading they stand, and what they are for."""


MOVED_COMMAND = "planning one test is `labbook power --test NAME` now: see `labbook power --help`."
MOVED_OPTION = "planning how many runs a study needs is `labbook power` now: see `labbook power --help`."
"""Messages for the former command `stats power` and the former option `plan --power`."""


def application(words: Collection[str]) -> typer.Typer:
    """Put the commands together; where the first word names one or a group, other commands are left out, and a group
    has its own only where it is among the words, for building them all is a tenth of a command's time.
    """
    app = typer.Typer(
        name="labbook",
        help="The lab notebook of a robotics lab that counts: raw instrument files in, a traceable report out.",
        no_args_is_help=True,
        pretty_exceptions_enable=False,
        rich_markup_mode="markdown",
        context_settings={"help_option_names": ["-h", "--help"]},
        epilog="Every command takes --debug, which shows where an error arose. `labbook --version` tells the version.",
    )
    first = next(iter(words), None)
    named = [command for commands in COMMANDS.values() for command in commands if command.__name__ == first]
    for heading, commands in COMMANDS.items():
        for command in () if first in GROUPS else named or commands:
            settings = {"allow_extra_args": True, "ignore_unknown_options": True} if command in TAKE_FACTORS else None
            app.command(rich_help_panel=heading, context_settings=settings)(command)
    for name, (heading, purpose) in GROUPS.items():
        group = importlib.import_module(f"labbook.cli.{name}").app if name in words else typer.Typer()
        app.add_typer(group, name=name, help=purpose, rich_help_panel=heading)
    return app


def run(words: Sequence[str] | None = None) -> NoReturn:
    """Run the command line: what a user caused becomes its sentence and exit code, `--debug` shows where it arose."""
    gc.set_threshold(GARBAGE_AFTER)
    given = sys.argv[1:] if words is None else words
    debug = "--debug" in given
    arguments = [argument for argument in given if argument != "--debug"]
    try:
        if "--version" in arguments and {*arguments} <= {"--version", "--json"}:
            _tell_version(as_json="--json" in arguments)
            sys.exit(0)
        _refuse_moved(arguments)
        code = application([*arguments, *_words_to_complete()])(arguments, prog_name="labbook", standalone_mode=False)
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
    if code == INTERRUPTED:
        print_interrupted()
    sys.exit(code or 0)


def _leave_unwritten() -> None:
    """Drop what standard output and error did not take: Python would try again at the end, and change the exit code."""
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _tell_version(*, as_json: bool) -> None:
    """Print the version, which is that of the installed package."""
    from importlib.metadata import version as version_of

    version = version_of("robot-labbook")
    typer.echo(json.dumps({"version": version}) if as_json else f"labbook {version}")


def _refuse_moved(arguments: Sequence[str]) -> None:
    """Raise `UsageError` for a command that has another name now."""
    if arguments[:2] == ["stats", "power"]:
        raise UsageError(MOVED_COMMAND)
    if arguments[:1] == ["plan"] and "--power" in arguments:
        raise UsageError(MOVED_OPTION)


def _words_to_complete() -> list[str]:
    """Return the words that a shell asks to complete, which it does not give as arguments."""
    return [word for name in ("COMP_WORDS", "_TYPER_COMPLETE_ARGS") for word in os.environ.get(name, "").split()]


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
        case OSError():
            where = f" {error.filename}" if error.filename else ""
            return f"{error.strerror or error}{where}: check the path, its permissions and the disk.", 2
        case typer.TyperException():
            command = getattr(getattr(error, "ctx", None), "command_path", "labbook")
            message = " ".join(_formatted(error).split()).rstrip(".")
            if not message:
                return "", 2  # a group without a command has shown its help instead
            end = "" if message.endswith("?") else "."
            return f"{message[0].lower()}{message[1:]}{end} See `{command} --help` for its use, with an example.", 2
        case _:
            return "no answer was given, so nothing was done: answer, or give it as an option.", 2
