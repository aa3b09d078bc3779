"""From a number's provenance id down to the bytes it was computed from."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import sqlalchemy as sa

from data_schema.errors import BookDamaged, UnknownName, UsageError
from data_schema.queries.history import EntryRow, corrections_of
from data_schema.queries.reports import ReportRow, list_reports
from data_schema.queries.sources import Source, describe_input
from labbook.analysis.results import equals_printed
from labbook.book.naming import changes_in_words
from labbook.book.opening import Book
from labbook.book.report_numbers import ReportedNumber, ReportedResult, ReportNumbers, read_numbers


@dataclass(frozen=True, slots=True)
class Trace:
    """A result, its direct inputs, and the traces of the results among these.

    A result that was met before is not followed again: `again`, without inputs.
    """

    kind: str
    about: str
    version: int
    inputs: tuple[Source, ...]
    below: tuple[Trace, ...]
    again: bool = False


@dataclass(frozen=True, slots=True)
class NumberTrace:
    """A number, the reports that show it, the oldest first, and where it came from."""

    number: ReportedNumber
    shown_in: tuple[ReportRow, ...]
    trace: Trace


@dataclass(frozen=True, slots=True)
class ReportOfNumber:
    """A number, all numbers of the newest report that shows it, and all reports that do, the oldest first."""

    number: ReportedNumber
    numbers: ReportNumbers
    shown_in: tuple[ReportRow, ...]


def find_number(book: Book, connection: sa.Connection, beginning: str) -> ReportOfNumber:
    """Return the one number whose id begins so; raises `UnknownName` where there is none, or are several.

    Raises `BookDamaged` where it can be in a report whose numbers are not as they were written.
    """
    if not beginning:
        raise UsageError("no id of a number was given: copy the whole id from the report.")
    reports = list_reports(connection)
    found: dict[str, ReportOfNumber] = {}
    damage: BookDamaged | None = None
    lost = 0
    for report in reports:
        if report.elsewhere:
            continue
        try:
            numbers = read_numbers(book.store.root, report)
        except UnknownName:
            lost += 1
            continue
        except BookDamaged as error:
            damage = error
            continue
        for uid in (uid for uid in numbers.numbers if uid.startswith(beginning)):
            number, before = numbers.numbers[uid], found.get(uid)
            if before is not None and not equals_printed(before.number.value, number.value, number.se):
                raise BookDamaged(
                    f"{uid} is {before.number.value!r} in report {before.shown_in[-1].called} and {number.value!r} in "
                    f"report {report.called}, from the same inputs: `labbook db check` says whether one was altered."
                )
            found[uid] = ReportOfNumber(number, numbers, (*(before.shown_in if before else ()), report))
    if not found and damage is not None:
        raise damage
    if not found:
        without = f"; the numbers.json of {lost} of the {len(reports)} reports is not there to look in" if lost else ""
        raise UnknownName(f"no number's id begins with {beginning!r}{without}: copy the whole id from the report.")
    if len(found) > 1:
        ids = ", ".join([*sorted(found)[:2], *["..."] * (len(found) > 2)])
        raise UnknownName(f"several numbers' ids begin with {beginning!r} ({ids}): copy the whole id from the report.")
    return next(iter(found.values()))


def trace(connection: sa.Connection, found: ReportOfNumber) -> NumberTrace:
    """Follow a number down to facts and files."""
    until = found.shown_in[-1].seq
    result = found.numbers.result_of(found.number)
    return NumberTrace(found.number, found.shown_in, _trace(connection, found.numbers, result, until, set()))


def trace_lines(found: NumberTrace) -> list[str]:
    """Write a trace as an indented tree."""
    number = found.number
    value = number.undefined if number.value is None else f"{number.value!r} {number.unit}"
    lines = [f"{number.id}: {number.name} = {value}"]
    lines += [f"shown in report {report.called}" for report in found.shown_in]
    return [*lines, *_lines(found.trace, 0)]


def _trace(
    connection: sa.Connection, numbers: ReportNumbers, result: ReportedResult, until: int, met: set[int]
) -> Trace:
    """Trace a result whose last report is entry number `until`: a corrected fact is shown with both values."""
    again = id(result) in met
    met.add(id(result))
    sources, below = [], []
    for item in () if again else result.inputs:
        if item.input_kind == "result":
            below.append(_trace(connection, numbers, numbers.results[item.input_uid], until, met))
            continue
        source = describe_input(connection, item)
        corrected = "" if item.input_kind == "idle_runs" else _corrections(connection, item.input_uid, until)
        sources.append(replace(source, text=source.text + corrected))
    about = ", ".join(f"{name} {value}" for name, value in result.scope.items() if value not in ("", None))
    return Trace(result.kind, about, result.version, tuple(sources), tuple(below), again)


def _corrections(connection: sa.Connection, uid: str, until: int) -> str:
    """Say what was corrected of a fact up to entry number `until`, the number's last report, and what after it."""
    corrections = corrections_of(connection, uid)
    before = [one for one in corrections if one.seq <= until]
    return _in_words(connection, before, "corrected before this report") + _in_words(
        connection, corrections[len(before) :], "corrected after the last report with this number"
    )


def _in_words(connection: sa.Connection, corrections: Sequence[EntryRow], when: str) -> str:
    old: dict[str, object] = {}
    new: dict[str, object] = {}
    for correction in corrections:
        old = {**correction.old, **old}
        new |= correction.new
    differing = {name: value for name, value in new.items() if value != old.get(name)}
    words = changes_in_words(connection, old, differing)
    if not words:
        return ""
    last = corrections[-1]
    return f"; {when}: {words} ({', '.join([last.person, *([last.reason] if last.reason else [])])})"


def _lines(found: Trace, depth: int) -> Iterator[str]:
    indent = "  " * depth
    yield f"{indent}{found.kind} version {found.version}: {found.about}{', as above' if found.again else ''}"
    yield from (f"{indent}  {source.kind}: {source.text}" for source in found.inputs)
    for below in found.below:
        yield from _lines(below, depth + 1)
