"""Entries between two reports that can have moved a number, each in few words, with what of the book they touch.

Results name their inputs by kind and uid (`data_schema.queries.sources.InputRow`). What an entry of the journal touches
has the same names, so that the causes of a moved number are the entries that touch one of its changed inputs.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import sqlalchemy as sa

from data_schema.queries import history as queries
from data_schema.queries.history import EntryRow
from data_schema.queries.reports import ReportRow
from data_schema.queries.signals import samples_of_files
from data_schema.vocabulary import Action, ReasonCode, RunState, Verdict
from labbook.analysis.outcomes.run_apexes import UNKNOWN_FLIGHT_S
from labbook.analysis.preregistration.book_state import Change, read_history
from labbook.book.naming import changes_in_words

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


def causes_between(
    connection: sa.Connection, reports: tuple[ReportRow, ReportRow]
) -> list[tuple[Cause, frozenset[Thing]]]:
    """List what can have moved a number between two reports, with what it touches, in the order of the journal.

    The entries of one command about one file are one cause.
    """
    earlier, later = sorted(reports, key=lambda report: report.seq)
    known = _Known(connection)
    found: dict[tuple[Any, ...], tuple[Cause, frozenset[Thing]]] = {}
    for entry in queries.entries_between(connection, earlier.seq, later.seq):
        cause = known.cause_of(entry)
        if cause is not None:
            kind, what = cause
            key = (entry.command, known.file_of(entry)) if kind is CauseKind.FILE else (entry.seq,)
            first, things_touched = found.get(
                key, (Cause(kind, what, entry.person, entry.at_utc, entry.reason), frozenset[Thing]())
            )
            found[key] = first, things_touched | set(known.things_touched(entry))
    raised = [
        (Cause(CauseKind.VERSION, f"{name} {was} to {later.versions[name]}"), frozenset([(VERSION, name)]))
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
        self.moves: dict[int, list[Change]] = {}
        for entry, change in self.history.changes:
            if change.column == "run_uid":
                self.moves.setdefault(entry.seq, []).append(change)
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
        new = entry.new
        match entry.action, entry.kind:
            case Action.DECIDE, _:
                where = f"jump at {new['anchor_s']:.2f} s of {self._run(new['target_uid'])}"
                because = "" if new["reason_code"] == ReasonCode.OTHER else f", {new['reason_code']}"
                return CauseKind.VERDICT, f"{where} {_VERDICT_WORDS[Verdict(new['verdict'])]}{because}"
            case Action.DECLARE, "run":
                return CauseKind.RUN, f"{self._run(entry.uid)} stated"
            case Action.DECLARE, "charge":
                return CauseKind.CHARGE, f"{new['charge_mah']:g} mAh typed for {self._run(new.get('run'))}"
            case Action.DECLARE, "config":
                return CauseKind.CONFIGURATION, f"labbook.toml: {self._settings(entry.seq)}"
            case Action.VOID, "run":
                return CauseKind.VOID, f"{self._run(entry.uid)} declared void"
            case Action.CORRECT, "run" if entry.old == {"state": RunState.VOID}:
                return CauseKind.VOID, f"{self._run(entry.uid)} counts again"
            case Action.CORRECT, kind if kind != "run_file" and "run" not in new:
                changed = changes_in_words(self.connection, entry.old, new)
                return CauseKind.CORRECTION, f"{self._called(kind, entry.uid)}: {changed}"
        name = self.history.file_names.get(self.file_of(entry) or "")
        called = f"part {new['part']} of {name}" if "part" in new else name or "a typed charge"
        called = f"charge of {name}" if name and entry.kind == "charge" else called
        if entry.action in (Action.ASSIGN, Action.CORRECT):
            left = dict.fromkeys(self._run(change.was) for change in self.moves.get(entry.seq, ()) if change.was)
            moved = f" from {' and '.join(left)}" if left else ""
            return CauseKind.FILE, f"{called} assigned{moved} to {self._run(new['run'])}"
        return (CauseKind.FILE, f"{called} {_DONE[entry.action]}") if entry.action in _DONE else None

    def things_touched(self, entry: EntryRow) -> Iterator[Thing]:
        """Yield those inputs of results that an entry touches."""
        yield entry.kind, entry.uid
        if entry.kind == "run" and "position_in_day" in entry.new:
            yield "position", entry.uid
        if entry.kind == "robot":
            yield "robot_body", entry.uid
        elif entry.kind == "run" and entry.action is Action.CORRECT and _GROUPING & entry.new.keys():
            yield REGROUPED, entry.uid
        elif entry.kind == "config":
            yield SETTINGS
        elif entry.action is Action.DECIDE:
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
_VERDICT_WORDS = {
    Verdict.ACCEPT: "accepted",
    Verdict.REJECT: "rejected",
    Verdict.CLEAR: "left to the protocol again",
}
_DONE = {
    Action.INGEST: "ingested",
    Action.READ: "read anew",
    Action.WITHDRAW: "withdrawn",
    Action.RESTORE: "taken into use again",
}


def _flat(table: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Give the settings of a table of TOML by their full names."""
    for name, value in table.items():
        if isinstance(value, dict):
            yield from _flat(value, f"{above}{name}.")
        else:
            yield f"{above}{name}", value
