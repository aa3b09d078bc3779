"""From a number's provenance id down to the bytes behind it; which numbers moved between two reports, and why.

With `labbook why ID --check` the number is computed anew from raw copies and journal, compared to the last digit.

Numbers of two reports are matched by their paths, for their ids change with their inputs. A number was moved by the
inputs, down to facts and bytes, that only one of the two has; where there is none, by a setting of labbook.toml.

Of the entries between two reports those can have moved a number that touch what it came from. Results name their inputs
by kind and uid (`data_schema.queries.sources.InputRow`). What an entry of the journal touches has the same names, so
that the causes of a moved number are the entries that touch one of its changed inputs.
"""

from __future__ import annotations

import re
import tomllib
from collections import ChainMap, Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from data_schema import journal
from data_schema.engine import reading
from data_schema.errors import BookDamaged, UnknownName, UsageError, nearest, unknown_name
from data_schema.file_cache import without_caches
from data_schema.grouping import grouped
from data_schema.queries import history as queries
from data_schema.queries.files import lost_copies
from data_schema.queries.history import EntryRow, ReportRow, list_reports, statements_about
from data_schema.queries.signals import samples_of_files
from data_schema.queries.sources import Source, describe_input
from data_schema.queries.study import config_in_force
from data_schema.vocabulary import Action, ReasonCode, Verdict
from ingest.store import Store
from labbook.analysis.comparison.deciding import DECISION, OVERALL
from labbook.analysis.comparison.pairing import POOLED
from labbook.analysis.outcomes.run_apexes import UNKNOWN_FLIGHT_S
from labbook.analysis.preregistration.book_state import read_history
from labbook.analysis.results import equals_printed
from labbook.book.altered import altered_since, but_of_readings, differences, inputs_altered
from labbook.book.naming import changes_in_words, words_of
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


LAST = "last"


@dataclass(frozen=True, slots=True)
class MovedNumber:
    """A number of two reports that differs in the second one; `causes` are positions in the list of all causes."""

    was: ReportedNumber
    now: ReportedNumber
    causes: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class ReportsCompared:
    """Two reports: how many numbers both have, which of these moved, which only one has, and the causes between them.

    The headlines that moved stand first.
    """

    before: ReportRow
    after: ReportRow
    common: int
    moved: tuple[MovedNumber, ...]
    only_before: tuple[ReportedNumber, ...]
    only_after: tuple[ReportedNumber, ...]
    causes: tuple[Cause, ...]


def report_named(connection: sa.Connection, name: str) -> ReportRow:
    """Return a report by its number from 1, by the beginning of its uid, or as `last` or `last-1` of those made here.

    Raises `UnknownName` for a name of no report, or of several.
    """
    reports = list_reports(connection)
    back = re.fullmatch(rf"{LAST}(?:-([0-9]+))?", name)
    known = [report for report in reports if not report.elsewhere] if back else reports
    place = len(known) - int(back[1] or 0) if back else int(name) if re.fullmatch("[0-9]{1,9}", name) else 0
    if 1 <= place <= len(known):
        return known[place - 1]
    begun = [report for report in reports if name and not back and report.uid.startswith(name)]
    if len(begun) == 1 and not (name.isdigit() and len(name) < 4):
        return begun[0]
    if not reports:
        raise unknown_name("report", name, [])
    # Numbers that look alike are of other reports: what may be misspelt is an id or a word
    near = None if back or name.isdigit() else nearest(name, [*(report.uid for report in reports), LAST])
    count = "there is 1" if len(known) == 1 else f"there are {len(known)}"
    hint = f"{count}." if near is None else f"did you mean {near!r}?"
    raise UnknownName(f"{name!r} is not a known report: {hint} `labbook reports list` lists them.")


def compare_reports(book: Book, connection: sa.Connection, before: ReportRow, after: ReportRow) -> ReportsCompared:
    """Find which numbers moved from one report to another, and the statements between the two that moved them."""
    both = tuple(read_numbers(book.store.root, report) for report in (before, after))
    old, new = ({number.path: number for number in one.numbers.values()} for one in both)
    pairs = [(old[path], number) for path, number in new.items() if path in old]
    moved = [(was, now) for was, now in pairs if not equals_printed(was.value, now.value, now.se)]
    causes = causes_between(connection, (before, after))
    inputs, found = _Inputs(*both), list[MovedNumber]()
    for was, now in moved:
        things = inputs.differing(was, now)
        places = [place for place, (_, things_touched) in enumerate(causes) if things & things_touched]
        found.append(MovedNumber(was, now, tuple(places)))
    counts = Counter(place for item in found for place in item.causes)
    return ReportsCompared(
        before=before,
        after=after,
        common=len(pairs),
        moved=tuple(sorted(found, key=lambda item: _rank(item.now, both[1].result_of(item.now)))),
        only_before=tuple(number for path, number in old.items() if path not in new),
        only_after=tuple(number for path, number in new.items() if path not in old),
        causes=tuple(replace(cause, moved=counts[place]) for place, (cause, _) in enumerate(causes)),
    )


def _rank(number: ReportedNumber, result: ReportedResult) -> int:
    """Put the headlines first: the savings over all groups, then each group's; all else stays as the report has it."""
    if number.name != "savings" or "variant" in result.scope:
        return 3
    if result.kind == OVERALL.kind:
        return 0
    return 1 if result.kind == DECISION.kind and result.scope.get("family") == POOLED else 3


_Leaf = tuple[str, str, str]
"""An input of a result that is no result: its kind, its uid and its hash, or what stands for these."""


class _Inputs:
    """The inputs at the bottom that the results of two reports depend on.

    A result of the later report with the content of one of the earlier stands for that one: inputs of only the newer of
    the two moved nothing.
    """

    def __init__(self, before: ReportNumbers, after: ReportNumbers) -> None:
        self.reports = before, after
        self.same = {one.content: uid for uid, one in before.results.items()}
        self.leaves_of_runs: dict[str, frozenset[_Leaf]] = {}  # they are asked for again and again
        self.compared: dict[tuple[str, str], frozenset[Thing]] = {}

    def differing(self, was: ReportedNumber, now: ReportedNumber) -> frozenset[Thing]:
        """Return the inputs in which the results of two numbers differ; nothing where they are one."""
        pair = was.result, now.result
        if was.result == now.result:
            return frozenset()
        if pair not in self.compared:
            before, after = self.reports
            self.compared[pair] = frozenset(
                _differing(self._leaves(before, was.result), self._leaves(after, now.result))
            )
        return self.compared[pair]

    def _leaves(self, of: ReportNumbers, uid: str) -> frozenset[_Leaf]:
        result = of.results[uid]
        if result.content in self.same:
            of = self.reports[0]
            result = of.results[self.same[result.content]]
        if result.content in self.leaves_of_runs:
            return self.leaves_of_runs[result.content]
        found = {(VERSION, result.kind, str(result.version))}
        for row in result.inputs:
            if row.input_kind == "result":
                found |= self._leaves(of, row.input_uid)
            elif row.input_kind == "detection":
                name, _, version = row.input_uid.partition(", version ")
                found.add((row.input_kind, name, version))
            else:
                found.add((row.input_kind, row.input_uid, row.input_sha256))
        if "run" in result.scope:
            settings = {name: value for name, value in result.scope.items() if name != "run"}
            found.add((*SETTINGS, f"{result.kind} {settings}"))
            self.leaves_of_runs[result.content] = frozenset(found)
        return frozenset(found)


def _differing(old: frozenset[_Leaf], new: frozenset[_Leaf]) -> set[Thing]:
    """Return, as causes name them, the inputs that only one result has; where all are the same, what groups them."""
    was = {leaf[:2] for leaf in old}
    both = was & {leaf[:2] for leaf in new}
    found: set[Thing] = set()
    for kind, uid, _sha256 in old ^ new:
        if kind == "detection" and (kind, uid) in both:
            found.add((VERSION, uid))
        elif kind in ("detection", "scene"):
            found.add(SETTINGS)
        else:
            found.add((kind, uid))
        if kind == "run" and (kind, uid) not in both:
            found |= {(OF_RUN, uid), (LOST_RUN if (kind, uid) in was else OF_RUN, uid)}
    return found or {SETTINGS} | {(REGROUPED, uid) for kind, uid, _sha256 in old if kind == "run"}


Thing = tuple[str, str]
"""What a result can depend on: its kind and uid."""
SETTINGS: Thing = ("settings", "")
"""Stands for the settings of labbook.toml, which are no row."""
VERSION, OF_RUN, LOST_RUN, REGROUPED = "version", "of run", "lost run", "regrouped"
"""Kinds of what is no row either: the version of an algorithm by its name; that a number depends on a run in one report
only, and in the earlier one only, by the run's uid; that a run may count otherwise among the same runs: in another
condition, on another day or pack. A charge or log too many takes its run's numbers away, and is in none of them.
"""


class CauseKind(StrEnum):
    """What numbers can move by."""

    CORRECTION = "correction"
    VOID = "void"
    VERDICT = "verdict"
    FILE = "file"
    CHARGE = "charge"
    RUN = "run"
    CONFIGURATION = "configuration"
    VERSION = "version"


@dataclass(frozen=True, slots=True)
class Cause:
    """A statement or a new version between two reports: what, by whom, when and why, and how many numbers it moved.

    A number that several moved counts for each. A version has no person and no time.
    """

    kind: CauseKind
    what: str
    person: str | None = None
    at_utc: str | None = None
    reason: str | None = None
    moved: int = 0


def causes_between(connection: sa.Connection, reports: tuple[ReportRow, ReportRow]) -> list[tuple[Cause, set[Thing]]]:
    """List what can have moved a number between two reports, with what it touches, in the order of the journal.

    The entries of one command about one file are one cause.
    """
    earlier, later = sorted(reports, key=lambda report: report.as_of)
    known = _Known(connection)
    found: dict[tuple[Any, ...], tuple[Cause, set[Thing]]] = {}
    for entry in queries.entries_between(connection, earlier.as_of, later.as_of):
        cause = known.cause_of(entry)
        if cause is not None:
            kind, what = cause
            key = (entry.command, known.file_of(entry)) if kind is CauseKind.FILE else (entry.seq,)
            first = Cause(kind, what, entry.person, entry.at_utc, entry.reason), set[Thing]()
            found.setdefault(key, first)[1].update(known.things_touched(entry))
    raised = [
        (Cause(CauseKind.VERSION, f"{name} {was} to {later.versions[name]}"), {(VERSION, name)})
        for name, was in earlier.versions.items()
        if later.versions.get(name, was) != was
    ]
    return [*found.values(), *raised]


class _Known:
    """What the book knows of the things that entries are about."""

    def __init__(self, connection: sa.Connection) -> None:
        self.connection = connection
        self.history = read_history(connection)
        self.file_read = {uid: file_uid for uid, file_uid, _name in queries.files_read(connection)}
        self.texts = {item.seq: str(item.new["text"]) for item in queries.recorded_configurations(connection)}
        of_runs = [both for both in self.history.changes if both[1].column == "run_uid"]
        self.moves = grouped([change for _, change in of_runs], [entry.seq for entry, _ in of_runs])
        self.of_file: dict[str | None, set[Thing]] = {}
        for file_uid, sha256 in samples_of_files(connection):
            self.of_file.setdefault(file_uid, set()).add(("signal", sha256))
        for (file_uid, _part), log in self.history.logs.items():
            self.of_file[file_uid].add((LOST_RUN, log.run_uid))
        for uid, charge in self.history.charges.items():
            self.of_file.setdefault(self.history.file_of[uid], set()).update(
                {("charge", uid), (LOST_RUN, charge.run_uid)}
            )

    def file_of(self, entry: EntryRow) -> str | None:
        """Return the uid of the file that an entry is about, None for a typed charge."""
        if entry.kind == "run_file":
            return next((change.item for change in self.moves.get(entry.seq, ())), None)
        return (
            self.history.file_of.get(entry.uid) if entry.kind == "charge" else self.file_read.get(entry.uid, entry.uid)
        )

    def cause_of(self, entry: EntryRow) -> tuple[CauseKind, str] | None:
        """Return what kind of cause an entry is, and the words for it; None where no number depends on it."""
        new, became = entry.new, words_of(entry).became
        match entry.action, entry.kind:
            case _, "decision":
                where = f"jump at {new['anchor_s']:.2f} s of {self._run(new['target_uid'])}"
                because = "" if new["reason_code"] == ReasonCode.OTHER else f", {new['reason_code']}"
                to = f" at {new['at_s']:.2f} s" if new["verdict"] == Verdict.MOVE else ""
                return CauseKind.VERDICT, f"{where} {became}{to}{because}"
            case Action.SET, "run" if entry.makes:
                return CauseKind.RUN, f"{self._run(entry.uid)} stated"
            case Action.SET, "charge" if entry.makes:
                return CauseKind.CHARGE, f"{new['charge_mah']:g} mAh typed for {self._run(new.get('run'))}"
            case _, "config":
                return CauseKind.CONFIGURATION, f"labbook.toml: {self._settings(entry.seq)}"
            case Action.EXCLUDE, "run":
                return CauseKind.VOID, f"{self._run(entry.uid)} declared void"
            case Action.INCLUDE, "run":
                return CauseKind.VOID, f"{self._run(entry.uid)} counts again"
            case Action.SET, kind if not entry.makes and "run" not in new:
                changed = changes_in_words(self.connection, entry.old, new)
                return CauseKind.CORRECTION, f"{self._called(kind, entry.uid)}: {changed}"
        name = self.history.file_names.get(self.file_of(entry) or "")
        called = f"part {new['part']} of {name}" if "part" in new else name or "a typed charge"
        called = f"charge of {name}" if name and entry.kind == "charge" else called
        if entry.action is Action.SET and not entry.makes:
            left = dict.fromkeys(self._run(change.was) for change in self.moves.get(entry.seq, ()) if change.was)
            moved = f" from {' and '.join(left)}" if left else ""
            return CauseKind.FILE, f"{called} assigned{moved} to {self._run(new['run'])}"
        return (CauseKind.FILE, f"{called} {became}") if became else None

    def things_touched(self, entry: EntryRow) -> Iterator[Thing]:
        """Yield those inputs of results that an entry touches."""
        yield entry.kind, entry.uid
        if entry.kind == "run" and "position_in_day" in entry.new:
            yield "position", entry.uid
        if entry.kind == "robot":
            yield "robot_body", entry.uid
        elif entry.kind == "run" and not entry.makes and _GROUPING & entry.new.keys():
            yield REGROUPED, entry.uid
        elif entry.kind == "config":
            yield SETTINGS
        elif entry.kind == "decision":
            for _seq, verdict in self.history.verdicts.get(entry.new["signal_sha256"], ()):
                if abs(verdict.anchor_s - entry.new["anchor_s"]) <= UNKNOWN_FLIGHT_S / 2.0:
                    yield "decision", verdict.uid  # which it replaced, or took back
        elif entry.kind in ("file", "run_file", "ingest"):
            yield from self.of_file.get(self.file_of(entry), ())
        for change in self.moves.get(entry.seq, ()):
            yield from ((OF_RUN, run_uid) for run_uid in (change.was, change.now))

    def _called(self, kind: str, uid: str) -> str:
        if kind == "run":
            return self._run(uid)
        if kind == "charge":
            charge = self.history.charges.get(uid)
            return f"charge of {self._run(charge.run_uid if charge else None)}"
        return f"{kind} {queries.words_by_uid(self.connection, kind, _NAMED_BY.get(kind, 'name')).get(uid, uid)}"

    def _run(self, uid: str | None) -> str:
        return f"run {self.history.runs[uid].name}" if uid else "no run"

    def _settings(self, seq: int) -> str:
        """Say which settings a configuration has otherwise than the one before."""
        before = max((other for other in self.texts if other < seq), default=seq)
        was, now = (dict(_flat(tomllib.loads(self.texts[at]))) for at in (before, seq))
        changed = [
            f"{name} {was.get(name, 'none')} to {now.get(name, 'none')}"
            for name in {**was, **now}
            if was.get(name) != now.get(name)
        ]
        more = [f"{len(changed) - _MOST_SETTINGS} more"] if len(changed) > _MOST_SETTINGS else []
        return ", ".join([*changed[:_MOST_SETTINGS], *more]) or "no other setting"


_GROUPING = frozenset({"battery", "condition", "day"})
"""Columns of a run by which it is grouped."""
_MOST_SETTINGS = 3
"""So many settings of a configuration are named."""
_NAMED_BY = {"level": "label", "condition": "key", "day": "date_local"}
"""The column that people know a thing by, where it is not its name."""


def _flat(table: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Give the settings of a table of TOML by their full names."""
    for name, value in table.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{above}{name}.")
        else:
            yield f"{above}{name}", value
