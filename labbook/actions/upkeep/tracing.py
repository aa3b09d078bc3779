"""From a number's provenance id down to the bytes it was computed from.

With `labbook why ID --check` the number is computed anew from raw copies and journal, compared to the last digit.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import TYPE_CHECKING

import sqlalchemy as sa

from data_schema import journal
from data_schema.engine import reading
from data_schema.errors import BookDamaged, UnknownName, UsageError
from data_schema.file_cache import without_caches
from data_schema.queries.files import lost_copies
from data_schema.queries.history import ReportRow, list_reports, statements_about
from data_schema.queries.sources import Source, describe_input
from data_schema.queries.study import config_in_force
from data_schema.vocabulary import Action
from ingest.store import Store
from labbook.analysis.results import equals_printed
from labbook.book.altered import altered_since, but_of_readings, differences, inputs_altered
from labbook.book.naming import changes_in_words
from labbook.book.opening import Book
from labbook.book.replaying import replayed
from labbook.book.report_numbers import ReportedNumber, ReportedResult, ReportNumbers, numbers_of_report, read_numbers
from labbook.config.parsing import parse_configuration

if TYPE_CHECKING:
    from labbook.analysis.study import Analysis


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
    last = None if found else book.mirror.last()
    if last is not None and last.seq > journal.head(connection)[0]:
        raise BookDamaged(
            f"the database does not have all entries of journal.jsonl, and no number's id begins with {beginning!r} in "
            "the reports that it has: the next command that writes applies the others, or `labbook db check` says why "
            "they cannot be."
        )
    if not found:
        without = f"; the numbers.json of {lost} of the {len(reports)} reports is not there to look in" if lost else ""
        raise UnknownName(f"no number's id begins with {beginning!r}{without}: copy the whole id from the report.")
    if len(found) > 1:
        ids = ", ".join([*sorted(found)[:2], *["..."] * (len(found) > 2)])
        raise UnknownName(f"several numbers' ids begin with {beginning!r} ({ids}): copy the whole id from the report.")
    return next(iter(found.values()))


def trace(connection: sa.Connection, found: ReportOfNumber) -> NumberTrace:
    """Follow a number down to facts and files."""
    until = found.shown_in[-1].as_of
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
    """Trace a result whose last report is of entry number `until`: a corrected fact is shown with both values."""
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
    corrections = [
        one
        for one in statements_about(connection, uid)
        if not one.makes and (one.action is Action.SET or one.kind == "run")
    ]
    said = ""
    for when, some in {
        "corrected before this report": [one for one in corrections if one.seq <= until],
        "corrected after the last report with this number": [one for one in corrections if one.seq > until],
    }.items():
        old = dict(ChainMap(*(dict(one.old) for one in some)))
        new = dict(ChainMap(*(dict(one.new) for one in reversed(some))))
        differing = {name: value for name, value in new.items() if value != old.get(name)}
        if words := changes_in_words(connection, old, differing):
            by = ", ".join(filter(None, [some[-1].person, some[-1].reason]))
            said += f"; {when}: {words} ({by})"
    return said


def _lines(found: Trace, depth: int) -> Iterator[str]:
    indent = "  " * depth
    yield f"{indent}{found.kind} version {found.version}: {found.about}{', as above' if found.again else ''}"
    yield from (f"{indent}  {source.kind}: {source.text}" for source in found.inputs)
    for below in found.below:
        yield from _lines(below, depth + 1)


_MOST_NAMED = 5


@dataclass(frozen=True, slots=True)
class Recomputed:
    """A number as a report has it, and as it came out anew as of that report, None where nothing comes out.

    `differs` names the fields (value, standard error, ends of the interval, ...) that are not the same double.
    `altered` are the rows that bear on its inputs and are not what raw copies and journal give.
    `other_versions`: versions of readers or algorithms made the report that this labbook does not have.
    """

    report: ReportRow
    printed: ReportedNumber
    anew: ReportedNumber | None
    differs: tuple[str, ...]
    altered: tuple[str, ...]
    other_versions: bool

    @property
    def stands(self) -> bool | None:
        """Whether the number is as printed, from the inputs that the book has; None where that cannot be decided."""
        if self.anew is None or self.differs:
            return None if self.other_versions else False
        return not self.altered

    @property
    def sentence(self) -> str:
        """Say whether the number stands."""
        uid, of = self.printed.id, f"as of report {self.report.called}"
        if self.stands is None:
            return (
                f"{uid} does not come out the same {of}, which other versions of readers or algorithms made: make the "
                "report again, and `labbook reports diff last-1 last` says what moved."
            )
        if self.anew is None:
            return f"{uid} does not stand: raw copies and journal do not give it {of}; `labbook db check` says more."
        if self.differs:
            values = "; ".join(
                f"{name} is {getattr(self.printed, name)!r} and should be {getattr(self.anew, name)!r}"
                for name in self.differs
            )
            return f"{uid} does not stand: {values}; `labbook db check` names what was altered."
        same = f"{uid} recomputed from raw copies and journal {of}: the same to the last digit"
        if self.altered:
            return (
                f"{same}; but rows behind it were altered since: {'; '.join(self.altered[:_MOST_NAMED])}: `labbook "
                "db check` says more, `labbook rebuild` mends it."
            )
        return f"{same}."


def recompute(book: Book, asked: Sequence[ReportOfNumber], step: Callable[[str], None]) -> list[Recomputed]:
    """Compute numbers anew, each as of the newest report that shows it; the journal is replayed once."""
    shown_in = {one.shown_in[-1].seq: one.shown_in[-1] for one in asked}
    made: dict[int, tuple[Mapping[str, ReportedNumber], Mapping[str, int]]] = {}
    with (
        book.reading() as connection,
        replayed(book.store, book.mirror, 0, step, use_cache=False, lost=lost_copies(connection)) as (engine, replay),
    ):
        for seq, report in sorted(shown_in.items(), key=lambda one: one[1].as_of):
            replay.apply_to(engine, report.as_of)
            with reading(engine) as fresh, without_caches():
                again = made_again(fresh, replay.store, report.selection or None, report.made_utc)
            made[seq] = numbers_of_report(again).numbers, again.versions
        rows, _removed = altered_since(connection, engine, replay)
        with reading(engine) as fresh:
            readers = differences(fresh, journal.stored(fresh), replay.without_rows).other_versions
            rows = but_of_readings(rows) if readers else rows
            bearing_on = inputs_altered(connection, fresh, rows)
            return [
                Recomputed(
                    report=report,
                    printed=one.number,
                    anew=(anew := number_anew(numbers, one.number)),
                    differs=differing_fields(one.number, anew),
                    altered=tuple(
                        row.sentence.removesuffix(".")
                        for row, inputs in zip(rows, bearing_on, strict=True)
                        if inputs is None or inputs & {leaf.input_uid for leaf in one.numbers.leaves_of(one.number)}
                    ),
                    other_versions=readers or versions != report.versions,
                )
                for one in asked
                for report in one.shown_in[-1:]
                for numbers, versions in [made[report.seq]]
            ]


def made_again(fresh: sa.Connection, store: Store, where: str | None, made_at: str) -> Analysis:
    """Make a report again of a book as it stood when it was made, as the journal played back gives it."""
    from labbook.analysis.study import analyse  # which only a check needs

    row = config_in_force(fresh)
    assert row is not None, "a configuration is declared before any report is made"  # noqa: S101
    configuration = parse_configuration(row.text, "the book's configuration")
    return analyse(fresh, store, configuration, where=where, made_at=made_at)


def number_anew(numbers: Mapping[str, ReportedNumber], number: ReportedNumber) -> ReportedNumber | None:
    """Return a number as it is now; where its inputs were altered its id is another, and its path the same."""
    return numbers.get(number.id) or next((one for one in numbers.values() if one.path == number.path), None)


def differing_fields(printed: ReportedNumber, anew: ReportedNumber | None) -> tuple[str, ...]:
    """Name the fields of a number (value, standard error, ends of the interval, ...) that came out otherwise anew."""
    names = [field.name for field in fields(ReportedNumber) if field.name not in ("id", "result")]
    return tuple(name for name in names if anew and repr(getattr(printed, name)) != repr(getattr(anew, name)))
