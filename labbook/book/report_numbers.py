"""The numbers that a report shows, with the results behind them down to facts and bytes: its `numbers.json`.

The hash of the file stands in the journal's entry of the report. It is all that remains of the results; with the
journal and the raw copies they can be computed again. The file lies beside the page, which may go anywhere and is
written over by the next report there; so the book has it, too, among its files under `numbers/`, named after its hash.
"""

from __future__ import annotations

import hashlib
import io
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

import msgspec
import sqlalchemy as sa

from data_schema.disk import write_whole
from data_schema.errors import BookDamaged, UnknownName
from data_schema.journal import Entry
from data_schema.queries.facts import read_fact
from data_schema.queries.files import links_of_file, signals_of_file
from data_schema.queries.history import ReportRow, list_reports
from data_schema.queries.sources import InputRow
from data_schema.vocabulary import Action, RunKind, Undefined
from labbook.analysis.results import numbers_of
from reports.numbers import Number, Result

if TYPE_CHECKING:
    from labbook.analysis.study import Analysis
    from labbook.book.write_session import WriteSession

NUMBERS = "numbers.json"
_FOLDER = "numbers"
"""Of the book's store: a file for each report, which a backup has, too."""


@dataclass(frozen=True, slots=True)
class ReportedNumber:
    """A number of a report, unrounded and in its `unit`; `undefined` says why there is no value.

    `path` is what it is of, by which it is found in another report: kind and scope of its result, and its name there.
    `about` says the same in words, but for the name and the report's selection.
    """

    id: str
    path: str
    name: str
    about: str
    result: str
    value: float | None
    unit: str
    se: float | None
    shared_se: float | None
    ci_low: float | None
    ci_high: float | None
    ci_level: float | None
    df: float | None
    n: int | None
    undefined: str | None


@dataclass(frozen=True, slots=True)
class ReportedResult:
    """A result behind a number: what it is, what it is about, by which version it was computed, and its inputs.

    `content` is a hash that results of the same kind, scope, numbers and other content share.
    """

    kind: str
    scope: dict[str, Any]
    version: int
    content: str
    inputs: tuple[InputRow, ...]


@dataclass(frozen=True, slots=True)
class ReportNumbers:
    """All numbers of a report by their ids, and every result that they depend on, by its name as an input of others."""

    numbers: dict[str, ReportedNumber]
    results: dict[str, ReportedResult]

    def result_of(self, number: ReportedNumber) -> ReportedResult:
        """Return the result that a number is of."""
        return self.results[number.result]

    def leaves_of(self, number: ReportedNumber) -> frozenset[InputRow]:
        """Return the facts and files at the bottom of a number."""
        found: set[InputRow] = set()
        met = step = {number.result}
        while step:
            inputs = [row for uid in step for row in self.results[uid].inputs]
            found.update(row for row in inputs if row.input_kind != "result")
            step = {row.input_uid for row in inputs if row.input_kind == "result"} - met
            met = met | step
        return frozenset(found)


def numbers_of_report(made: Analysis) -> ReportNumbers:
    """Return what a report shows, and what is behind it."""
    by_uid = {one.origin.uid: one for one in made.computed.made.values()}  # in the order in which they were computed
    shown = set(made.shown)
    needed = step = {
        uid for uid, one in by_uid.items() if any(number.provenance in shown for _name, number in numbers_of(one))
    }
    while step:
        inputs = {row.input_uid for uid in step for row in by_uid[uid].origin.inputs if row.input_kind == "result"}
        step = inputs - needed
        needed = needed | step
    numbers: dict[str, ReportedNumber] = {}
    results: dict[str, ReportedResult] = {}
    for uid, one in by_uid.items():
        if uid in needed:
            said = fields_of_numbers(one)
            numbers |= {key: ReportedNumber(id=key, result=uid, **of) for key, of in said.items() if key in shown}
            results[uid] = _result(one, said)
    return ReportNumbers(numbers, results)


def numbers_bytes(numbers: ReportNumbers) -> bytes:
    """Write them as JSON, a line each, piece by piece: of 100 000 runs they are 80 MB, which are in memory once."""
    encode, file = msgspec.json.encode, io.BytesIO()
    for head, some in ((b'{"numbers": {\n', numbers.numbers), (b'\n}, "results": {\n', numbers.results)):
        file.write(head)
        for place, (key, value) in enumerate(some.items()):
            file.write(b",\n" if place else b"")
            file.write(encode(key) + b": " + encode(value))
    file.write(b"\n}}\n")
    return file.getvalue()


def numbers_path(store: Path, sha256: str) -> Path:
    """Return where the store of a book has the numbers of a report, by the hash of the file."""
    return store / _FOLDER / f"{sha256}.json"


def numbers_files(entries: Iterable[Entry]) -> dict[str, str]:
    """Return the hash of the numbers of each report that was made in this book, by the report as a message names it."""
    found: dict[str, str] = {}
    reports = (entry for entry in entries if entry.action is Action.REPORT)
    for number, entry in enumerate(reports, start=1):
        if entry.origin is None:
            new = entry.new or {}
            found[f"{number} of {new['made_at']} ({new['where'] or 'all runs'})"] = new["files"][NUMBERS]
    return found


def bring_numbers(source: Path, target: Path, entries: Iterable[Entry]) -> list[str]:
    """Copy the numbers of the reports among these entries from one store to another; returns which could not be had."""
    problems = []
    for called, sha256 in numbers_files(entries).items():
        there = numbers_path(target, sha256)
        if _hash_of(there) == sha256:
            continue
        path = numbers_path(source, sha256)
        try:
            data = path.read_bytes()
        except OSError as error:
            problems.append(f"the numbers of report {called} are not in {path} ({error.strerror}).")
            continue
        if hashlib.sha256(data).hexdigest() == sha256:
            write_whole(there, data)
        else:
            problems.append(f"{path}, the numbers of report {called}, is not as labbook wrote it.")
    return problems


def _hash_of(path: Path) -> str | None:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return None


def read_numbers(store: Path, report: ReportRow) -> ReportNumbers:
    """Read the numbers of a report from the store of its book.

    Raises `UnknownName` where they are not there, and `BookDamaged` where they are not as they were written.
    """
    return msgspec.json.decode(_numbers_data(store, report), type=ReportNumbers)


def _numbers_data(store: Path, report: ReportRow) -> bytes:
    if report.elsewhere:
        raise UnknownName(
            f"report {report.called} was made in a book that was merged into this one: ask there, or make it of this "
            "book with `labbook report`."
        )
    path = numbers_path(store, report.files[NUMBERS])
    try:
        data = path.read_bytes()
    except OSError as error:
        raise UnknownName(
            f"the numbers of report {report.called} are not in {path} ({error.strerror}): put the file back, from a "
            f"backup or as the {NUMBERS} beside its page."
        ) from error
    if hashlib.sha256(data).hexdigest() != report.files[NUMBERS]:
        raise BookDamaged(
            f"{path} is not as labbook wrote it for report {report.called}: put the file back, from a backup or as the "
            f"{NUMBERS} beside its page."
        )
    return data


def readable_numbers(
    store: Path, reports: Iterable[ReportRow], names: Iterable[str]
) -> Iterator[tuple[ReportRow, ReportNumbers]]:
    """Give those of these reports whose numbers are there as they were written, and that hold one of the names."""
    sought = [name.encode() for name in names]
    for report in reports:
        try:
            data = _numbers_data(store, report)
        except (UnknownName, BookDamaged):
            continue
        if any(name in data for name in sought):
            yield report, msgspec.json.decode(data, type=ReportNumbers)


def outdated_reports(session: WriteSession) -> list[str]:
    """Name the reports with numbers that depend on what was stated: of each selection the newest one."""
    connection = session.connection
    things = {thing for entry in session.entries for thing in _things_touched(connection, entry)}
    return newest_depending_on(session.store.root, connection, things)


def newest_depending_on(store: Path, connection: sa.Connection, things: Iterable[tuple[str, str]]) -> list[str]:
    """Name the newest report of each selection, where a number of it depends on one of these, by kind and uid."""
    newest = {report.selection: report for report in list_reports(connection) if not report.elsewhere}
    return [report.called for report in reports_depending_on(store, list(newest.values()), things)]


_NUMBERS_DEPEND_ON = {
    "run": frozenset(
        (
            "name",
            "kind",
            "state",
            "duration_s",
            "jumps_made",
            "condition",
            "robot",
            "day",
            "battery",
            "position_in_day",
        )
    ),
    "charge": frozenset(("run", "stated_run", "state", "charge_mah", "resolution_mah", "mode")),
    "study": frozenset(("reference_voltage_v",)),
    "robot": frozenset(("name", "rest_length_m", "body_mass_kg", "foot_mass_kg", "link_1_m", "link_2_m")),
}
"""Columns whose correction can move a number; of what is not named here, every column."""


def _things_touched(connection: sa.Connection, entry: Entry) -> Iterator[tuple[str, str]]:
    """Give what a number can depend on that an entry, which has taken effect, bears on."""
    old, new = entry.old or {}, entry.new or {}
    if entry.entity_kind == "run" and new.keys() == {"position_in_day"}:
        yield "position", entry.entity_uid
        return
    if new and new.keys().isdisjoint(_NUMBERS_DEPEND_ON.get(entry.entity_kind, new.keys())):
        return
    yield entry.entity_kind, entry.entity_uid
    if entry.entity_kind == "decision":
        yield "signal", new.get("signal_sha256", "")
        yield new["target_kind"], new["target_uid"]
    elif entry.entity_kind == "robot":
        yield "robot_body", entry.entity_uid
        yield from ((("idle_runs", entry.entity_uid),) if "name" in new else ())
    elif entry.entity_kind == "file":
        yield from (("signal", sha256) for sha256 in signals_of_file(connection, entry.entity_uid))
    elif entry.entity_kind == "run":
        yield "position", entry.entity_uid
        yield from (("condition", one["condition"]) for one in (old, new) if one.get("condition"))
        yield from (("idle_runs", one["robot"]) for one in (old, new) if one.get("robot"))
        yield from _things_around(connection, entry.entity_uid)
    runs = {one["run"] for one in (old, new) if one.get("run")} | set(old.get("runs", ()))
    if entry.entity_kind == "charge":
        runs |= {read_fact(connection, "charge", entry.entity_uid, ["run"])["run"]} - {None}
    if entry.entity_kind == "file" and entry.action is not Action.SET:
        yield from (("charge", uid) for uid in old.get("charges", ()))
        runs |= {link.run_uid for link in links_of_file(connection, entry.entity_uid)}
    for run_uid in sorted(runs):
        yield from _things_around(connection, run_uid)


def _things_around(connection: sa.Connection, run_uid: str) -> Iterator[tuple[str, str]]:
    """Give a run, and what is summarised of it and of others: it may have joined these only now."""
    yield "run", run_uid
    about = read_fact(connection, "run", run_uid, ["kind", "condition", "robot"])
    if about["condition"] is not None:
        yield "condition", about["condition"]
    if about["kind"] == RunKind.IDLE:
        yield "idle_runs", about["robot"]


def reports_depending_on(
    store: Path, reports: Sequence[ReportRow], things: Iterable[tuple[str, str]]
) -> list[ReportRow]:
    """Return the reports with a number that depends on one of these facts or files, by kind and uid."""
    asked = set(things)
    return [
        report
        for report, numbers in readable_numbers(store, reports, {uid for _kind, uid in asked})
        if any((row.input_kind, row.input_uid) in asked for one in numbers.results.values() for row in one.inputs)
    ]


def fields_of_numbers(result: Result) -> dict[str, dict[str, Any]]:
    """Return the fields of `ReportedNumber`, but for its id and that of the result, of each number by its id.

    Of many runs few numbers are shown, and the others are needed for the hash of their result alone.
    """
    origin = result.origin
    scope = ",".join(f"{key}={value}" for key, value in origin.scope.items())
    words = [
        value if isinstance(value, str) else key if value is True else f"{key} {value}"
        for key, value in origin.scope.items()
        if value and key != "selection"
    ]
    about = ", ".join([origin.kind.replace("_", " "), *words])
    return {
        number.provenance: {
            "path": f"{origin.kind}/{scope}/{name}",
            "name": name,
            "about": about,
            "value": _defined(number.value),
            "unit": number.unit,
            "se": _defined(number.se),
            "shared_se": _defined(number.shared_se),
            "ci_low": _defined(number.ci_low),
            "ci_high": _defined(number.ci_high),
            "ci_level": None if number.ci_low is None else number.ci_level,
            "df": _defined(number.df),
            "n": number.n,
            "undefined": number.value.reason if isinstance(number.value, Undefined) else None,
        }
        for name, number in numbers_of(result)
    }


def _defined(value: float | Undefined | None) -> float | None:
    if value is None or isinstance(value, Undefined):
        return None
    if not math.isfinite(value):
        raise ValueError(f"{value} is no number that can be written: `Undefined` says why one does not exist")
    return float(value)


def _result(result: Result, said: Mapping[str, Mapping[str, Any]]) -> ReportedResult:
    origin = result.origin
    values = [list(of.values()) for of in said.values()]
    own = {"origin", *(of["name"] for of in said.values())}
    others = [getattr(result, one.name) for one in fields(result) if one.name not in own]
    content = hashlib.sha256(repr((values, [one for one in others if not _has_numbers(one)])).encode()).hexdigest()
    return ReportedResult(origin.kind, dict(origin.scope), origin.version, content[:16], origin.inputs)


def _has_numbers(value: object) -> bool:
    """Tell whether a field holds numbers, whose ids differ where inputs do."""
    return isinstance(value, Number) or (isinstance(value, dict) and any(map(_has_numbers, value.values())))
