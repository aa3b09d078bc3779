"""A script of a number of a report, written into a folder with its table: read by people, run without labbook."""

from __future__ import annotations

import contextlib
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from data_schema.errors import UsageError
from data_schema.journal import head
from data_schema.queries.history import ReportRow
from data_schema.queries.study import config_in_force
from labbook.actions.upkeep.tracing import ReportOfNumber
from labbook.analysis.results import equals_printed
from labbook.book.as_of import book_as_of
from labbook.book.opening import Book
from labbook.book.report_numbers import ReportedNumber, ReportedResult
from labbook.config.parsing import parse_configuration
from labbook.scripts.assembling import assemble, assemble_in_r
from labbook.scripts.facts import Asked, Facts, Script, columns_in, table_bytes
from labbook.scripts.kinds import KINDS

PYTHON, R = "number.py", "number.R"
_WIDTH = 110


@dataclass(frozen=True, slots=True)
class WrittenScript:
    """The files that were written, the number as the report has it, and what the script printed once it was run."""

    files: tuple[Path, ...]
    number: ReportedNumber
    printed: float

    @property
    def same(self) -> bool:
        """Whether the script printed the number of the report, to 1e-9 of it."""
        return equals_printed(self.number.value, self.printed, error_of(self.number))

    @property
    def lines(self) -> list[str]:
        """Say which files there are, and what the script printed."""
        written = f"{self.files[0].parent}: {', '.join(file.name for file in self.files)}"
        verdict = "as the report does to 1e-9."
        if not self.same:
            verdict = (
                f"and the report {self.number.value!r}: `labbook why {self.number.id} --check` says whether an input "
                "was altered."
            )
        return [written, f"{PYTHON} prints {self.printed!r}, {verdict}"]


def error_of(number: ReportedNumber) -> float | None:
    """Return the scale of a number's digits beside itself: its standard error, half its interval, or 1 of a t."""
    if number.se is not None:
        return number.se
    if number.ci_low is not None and number.ci_high is not None:
        return (number.ci_high - number.ci_low) / 2.0
    return 1.0 if number.name.partition("_")[0] == "t" else None


def write_and_run(
    book: Book, found: ReportOfNumber, folder: Path, step: Callable[[str], None], *, in_r: bool = False
) -> WrittenScript:
    """Write a script that computes one number, and its table, and run the script in Python.

    Parameters
    ----------
    book : of the report
    found : the number, with the reports that show it
    folder : where the files go: empty, or not there yet
    step : called with what is being done
    in_r : whether the same is written in R, too

    Raises
    ------
    UsageError
        For a folder with files in it, a number that is undefined, one that has no script, and a script that fails.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise UsageError(f"--script {folder} is not an empty folder: name an empty one, or one that is not there yet.")
    refuse_without_script(found)
    with facts_of(book, found.shown_in[-1], step) as facts:
        files = files_of(script_of(found, facts), found, in_r=in_r)
    folder.mkdir(parents=True, exist_ok=True)
    for name, data in files.items():
        (folder / name).write_bytes(data)
    step("running it")
    printed = printed_by(folder / PYTHON)["value"]
    return WrittenScript(tuple(folder / name for name in files), found.number, printed)


def refuse_without_script(found: ReportOfNumber) -> None:
    """Raise `UsageError` for a number that is undefined, or of a kind that has no script."""
    number, result = found.number, found.numbers.result_of(found.number)
    if number.value is None:
        raise UsageError(f"{number.id} is undefined, because {number.undefined}: ask for a number that has a value.")
    if result.kind not in KINDS:
        raise _refused(number, result)


def script_of(found: ReportOfNumber, facts: Facts) -> Script:
    """Return the script of a number; raises `UsageError` where it has none."""
    refuse_without_script(found)
    number, result = found.number, found.numbers.result_of(found.number)
    script = KINDS[result.kind](Asked(number.name, result.scope), facts)
    if script is None:
        raise _refused(number, result)
    return script


def files_of(script: Script, found: ReportOfNumber, *, in_r: bool = False) -> dict[str, bytes]:
    """Return the table and the script of a number by their names, with `in_r` also that in R."""
    number, heading = found.number, _heading(found, script)
    last_line = f"the report prints {number.value!r}"
    files = {script.table: table_bytes(script.rows), PYTHON: assemble(script, heading, last_line).encode()}
    if in_r:
        files[R] = assemble_in_r(script, heading, last_line).encode()
    return files


def printed_by(script: Path) -> dict[str, float]:
    """Run a Python script and return what it prints, by name: "value" first.

    Raises `UsageError` where it fails.
    """
    done = subprocess.run([sys.executable, script.name], cwd=script.parent, capture_output=True, text=True, check=False)
    if done.returncode:
        raise UsageError(f"{script} fails ({done.stderr.strip().splitlines()[-1]}): tell the authors of labbook.")
    return numbers_printed(done.stdout)


def numbers_printed(text: str) -> dict[str, float]:
    """Return the numbers that a script printed, by name."""
    first, *further = text.splitlines()
    pairs = [line.split(" = ") for line in further]
    return {"value": float(first), **{name: float(value) for name, value in pairs}}


@contextlib.contextmanager
def facts_of(book: Book, report: ReportRow, step: Callable[[str], None]) -> Iterator[Facts]:
    """Have the facts as of a report: those of the book where nothing was stated since, else those of a replay."""
    with book.reading() as connection:
        row = config_in_force(connection)
        if head(connection)[0] == report.seq == report.as_of + 1 and row is not None:
            configuration = parse_configuration(row.text, "the book's configuration")
            yield Facts(connection, book.store, configuration, report.selection)
            return
    with book_as_of(book, str(report.as_of), step) as past:
        yield Facts(past.connection, book.store, past.configuration, report.selection)


def _refused(number: ReportedNumber, result: ReportedResult) -> UsageError:
    return UsageError(
        f"{number.id}, {number.name} of {number.about}, has no script: trace this {result.kind.replace('_', ' ')} with "
        f"`labbook why {number.id}`."
    )


def _heading(found: ReportOfNumber, script: Script) -> str:
    """Return what stands at the head of a script: the number, the report, how to run it, the table's columns."""
    number, report = found.number, found.shown_in[-1]
    unit = "" if number.unit == "1" else f", in {number.unit}"
    sentences = [
        f"{number.name} of {number.about}{unit}.",
        f"Number {number.id} of report {report.called}, computed from what was measured: the table {script.table} "
        "beside this file. It needs nothing of labbook. It prints the number, and below it what belongs to it.",
        f"Columns of {script.table}:",
    ]
    paragraphs = [textwrap.fill(sentence, _WIDTH) for sentence in sentences]
    columns = "\n".join(f"- {name}: {meaning}" for name, meaning in columns_in(script.rows).items())
    return "\n\n".join([*paragraphs, columns]) + "\n"
