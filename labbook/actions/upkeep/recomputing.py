"""`labbook why ID --check`: a number computed anew from raw copies and journal, compared to the last digit."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields

import sqlalchemy as sa

from data_schema import journal
from data_schema.engine import reading
from data_schema.file_cache import without_caches
from data_schema.queries.reports import ReportRow
from data_schema.queries.sources import describe_input
from data_schema.queries.study import config_in_force
from ingest.store import Store
from labbook.actions.upkeep.tracing import ReportOfNumber
from labbook.book.differing import differences
from labbook.book.opening import Book
from labbook.book.replaying import replayed
from labbook.book.report_numbers import ReportedNumber, numbers_of_report
from labbook.config.parsing import parse_configuration
from labbook.presenting.report.content import MadeReport, make_report


@dataclass(frozen=True, slots=True)
class Recomputed:
    """A number as a report has it, and as it came out anew as of that report, None where nothing comes out.

    `differs` names the fields (value, standard error, ends of the interval, ...) that are not the same double.
    `altered` says of which of its inputs the database has something else than raw copies and journal give.
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
                f"{same}; but the database has otherwise than these: {'; '.join(self.altered)}: `labbook db check` "
                "names what was altered, `labbook rebuild` mends it."
            )
        return f"{same}."


def recompute(book: Book, asked: Sequence[ReportOfNumber], step: Callable[[str], None]) -> list[Recomputed]:
    """Compute numbers anew, each as of the newest report that shows it; the journal is replayed once."""
    shown_in = {one.shown_in[-1].seq: one.shown_in[-1] for one in asked}
    made: dict[int, tuple[Mapping[str, ReportedNumber], Mapping[str, int]]] = {}
    with (
        book.reading() as connection,
        replayed(book.store, book.mirror, 0, step, use_cache=False) as (engine, replay),
    ):
        until, _hash = journal.head(connection)
        for seq, report in sorted(shown_in.items()):
            replay.apply_to(engine, seq - 1)
            with reading(engine) as fresh, without_caches():
                again = _made_again(fresh, replay.store, report)
            made[seq] = numbers_of_report(again).numbers, again.versions
        replay.apply_to(engine, until)
        with reading(engine) as fresh:
            readers = differences(fresh, journal.stored(fresh), replay.without_rows).other_versions
            return [
                Recomputed(
                    report=report,
                    printed=one.number,
                    anew=(anew := _found(numbers, one.number)),
                    differs=_differing(one.number, anew),
                    altered=tuple(_altered(connection, fresh, one)),
                    other_versions=readers or versions != report.versions,
                )
                for one in asked
                for report in one.shown_in[-1:]
                for numbers, versions in [made[report.seq]]
            ]


def _made_again(fresh: sa.Connection, store: Store, report: ReportRow) -> MadeReport:
    row = config_in_force(fresh)
    assert row is not None, "a configuration is declared before any report is made"  # noqa: S101
    configuration = parse_configuration(row.text, "the book's configuration")
    return make_report(fresh, store, configuration, where=report.selection or None, made_at=report.made_utc)


def _found(numbers: Mapping[str, ReportedNumber], number: ReportedNumber) -> ReportedNumber | None:
    """Return a number as it is now; where its inputs were altered its id is another, and its path the same."""
    return numbers.get(number.id) or next((one for one in numbers.values() if one.path == number.path), None)


def _differing(printed: ReportedNumber, anew: ReportedNumber | None) -> tuple[str, ...]:
    names = [field.name for field in fields(ReportedNumber) if field.name not in ("id", "result")]
    return tuple(name for name in names if anew and repr(getattr(printed, name)) != repr(getattr(anew, name)))


def _altered(book: sa.Connection, fresh: sa.Connection, found: ReportOfNumber) -> list[str]:
    """Say which inputs of a number the database has otherwise than raw copies and journal give."""
    leaves = [(item, describe_input(fresh, item)) for item in found.numbers.leaves_of(found.number)]
    return sorted(f"{source.kind} {source.text}" for item, source in leaves if describe_input(book, item) != source)
