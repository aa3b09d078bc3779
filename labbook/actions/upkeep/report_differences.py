"""The reports of a book by the names that people use, the numbers of one, and which numbers moved between two, and why.

Numbers of two reports are matched by their paths, for their ids change with their inputs. A number was moved by the
inputs, down to facts and bytes, that only one of the two has; where there is none, by a setting of labbook.toml.

Of the entries between two reports those can have moved a number that touch what it came from. Results name their inputs
by kind and uid (`data_schema.queries.sources.InputRow`). What an entry of the journal touches has the same names, so
that the causes of a moved number are the entries that touch one of its changed inputs.
"""

from __future__ import annotations

import re
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from data_schema.errors import UnknownName, nearest, unknown_name
from data_schema.grouping import grouped
from data_schema.queries import history as queries
from data_schema.queries.history import EntryRow, ReportRow, list_reports
from data_schema.queries.signals import samples_of_files
from data_schema.vocabulary import Action, ReasonCode, Verdict
from labbook.analysis.comparison.deciding import DECISION, OVERALL
from labbook.analysis.comparison.pairing import POOLED
from labbook.analysis.outcomes.run_apexes import UNKNOWN_FLIGHT_S
from labbook.analysis.preregistration.book_state import read_history
from labbook.analysis.results import equals_printed
from labbook.book.naming import changes_in_words, words_of
from labbook.book.opening import Book
from labbook.book.report_numbers import ReportedNumber, ReportedResult, ReportNumbers, read_numbers

if TYPE_CHECKING:
    pass


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
