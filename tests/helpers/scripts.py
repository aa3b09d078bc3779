"""Stand-alone scripts of a report's numbers, written and run many at a time."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from data_schema.queries.history import list_reports
from labbook.actions.upkeep.tracing import ReportOfNumber
from labbook.analysis.results import equals_printed
from labbook.book.opening import Book
from labbook.book.report_numbers import ReportedNumber, read_numbers
from labbook.scripts.writing import PYTHON, error_of, facts_of, files_of, numbers_printed, script_of

_RUN_ALL = """
import contextlib, io, json, runpy, sys
printed = {}
for script in sys.argv[1:]:
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        runpy.run_path(script, run_name="__main__")
    printed[script] = out.getvalue()
assert not [name for name in sys.modules if name.partition(".")[0] in ("labbook", "stats", "reports", "data_schema")]
json.dump(printed, sys.stdout)
"""
FIELDS = ("value", "se", "shared_se", "ci_low", "ci_high", "df")


def numbers_of_last_report(book: Book) -> dict[str, ReportOfNumber]:
    """The numbers of the newest report by their ids."""
    with book.reading() as connection:
        report = list_reports(connection)[-1]
    numbers = read_numbers(book.store.root, report)
    return {uid: ReportOfNumber(one, numbers, (report,)) for uid, one in numbers.numbers.items()}


def one_of_each(numbers: Mapping[str, ReportOfNumber]) -> dict[str, ReportOfNumber]:
    """One number that has a value of each name of each kind and variant, but for days that are left out."""
    found: dict[tuple[object, ...], str] = {}
    for uid, one in numbers.items():
        result = one.numbers.result_of(one.number)
        variant = "without a day" if "without 2" in str(result.scope.get("variant")) else result.scope.get("variant")
        name = one.number.name.partition(",")[0]
        key = result.kind, name, variant, result.scope.get("quantity"), one.number.se is None
        if one.number.value is not None:
            found.setdefault(key, uid)
    return {uid: numbers[uid] for uid in found.values()}


def write_all(
    book: Book,
    numbers: Mapping[str, ReportOfNumber],
    folder: Path,
    *,
    in_r: bool = False,
) -> Iterator[tuple[ReportedNumber, Path]]:
    """Write the scripts of numbers; give each number with its folder."""
    report = next(iter(numbers.values())).shown_in[-1]
    with facts_of(book, report, lambda _step: None) as facts:
        for uid, one in numbers.items():
            (folder / uid).mkdir(parents=True)
            for name, data in files_of(script_of(one, facts), one, in_r=in_r).items():
                (folder / uid / name).write_bytes(data)
            yield one.number, folder / uid


def run_all(written: Sequence[tuple[ReportedNumber, Path]]) -> Iterator[tuple[ReportedNumber, dict[str, float]]]:
    """Run the scripts in one process of their own, without labbook; give each number with what its script printed."""
    import json

    scripts = [str(folder / PYTHON) for _number, folder in written]
    done = subprocess.run(
        [sys.executable, "-P", "-c", _RUN_ALL, *scripts],
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
        cwd=written[0][1],
    )
    assert done.returncode == 0, done.stderr
    for (number, _folder), text in zip(written, json.loads(done.stdout).values(), strict=True):
        yield number, numbers_printed(text)


def differs(number: ReportedNumber, printed: Mapping[str, float]) -> list[str]:
    """What a script printed otherwise than the report has it, to 1e-9."""
    wanted = {name: getattr(number, name) for name in FIELDS}
    errors = {"value": error_of(number)}
    return [
        f"{number.id} {number.name} of {number.about}: {name} is {printed.get(name)!r}, the report has {value!r}"
        for name, value in wanted.items()
        if value is not None and not equals_printed(value, printed.get(name), errors.get(name))
    ]
