"""Two runs beside each other: what they do not have alike, and both body heights in one figure."""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import sqlalchemy as sa

from data_schema.outcomes import Outcome
from data_schema.queries.history import RunFileRow
from data_schema.vocabulary import Undefined
from labbook.actions.runs.jump_review import review
from labbook.actions.runs.run_plot import drawn_log, write_picture
from labbook.actions.runs.run_view import RunView
from labbook.book.opening import Book
from labbook.config.local_time import local_text
from labbook.terminal import columns, listed
from reports.display import number_text, with_unit
from reports.figures.log import draw_logs_overlaid
from reports.numbers import Number

Value: TypeAlias = str | float | bool | Sequence[Any] | Mapping[str, Any] | Number | Undefined | None
"""What a run has of a thing; None where it has none."""

UTC = "UTC"
"""The unit of instants, which people see in local time."""
SAME_RATE = 1e-3
"""Rates that differ by less than this part are alike: they are found from times that jitter."""


@dataclass(frozen=True, slots=True)
class Difference:
    """A thing that two runs do not have alike, in `unit`; `of` says of which file or charge, "" of the run itself."""

    of: str
    what: str
    unit: str
    first: Value
    second: Value


@dataclass(frozen=True, slots=True)
class RunsCompared:
    """What two runs, by their names, do not have alike; empty where they have all alike.

    `files` also has how they were read, `numbers` what was computed of the runs.
    """

    first: str
    second: str
    facts: tuple[Difference, ...]
    files: tuple[Difference, ...]
    channels: tuple[Difference, ...]
    charges: tuple[Difference, ...]
    numbers: tuple[Difference, ...]
    verdicts: tuple[Difference, ...]

    @property
    def by_subject(self) -> dict[str, tuple[Difference, ...]]:
        """The differences by the name of their field."""
        return {one.name: getattr(self, one.name) for one in fields(self) if one.name not in ("first", "second")}


class Thing(NamedTuple):
    """What is compared, as `Difference` names it."""

    of: str
    what: str
    unit: str = ""


Things: TypeAlias = Iterator[tuple[Thing, Value]]


def compare_runs(first: RunView, second: RunView) -> RunsCompared:
    """Set all that the book has on two runs side by side, and leave what differs."""

    def differing(of: Callable[[RunView], Things]) -> tuple[Difference, ...]:
        return _differences(dict(of(first)), dict(of(second)))

    return RunsCompared(
        first=first.run.name,
        second=second.run.name,
        facts=differing(_facts),
        files=differing(_files),
        channels=differing(_channels),
        charges=differing(_charges),
        numbers=differing(_numbers),
        verdicts=differing(_verdicts),
    )


def _differences(first: Mapping[Thing, Value], second: Mapping[Thing, Value]) -> tuple[Difference, ...]:
    """Return what differs; of a file, charge or calibration that only one of them has, its name alone."""
    common = {thing.of for thing in first} & {thing.of for thing in second}
    names = {thing.of: thing for thing in reversed([*first, *second])}
    return tuple(
        Difference(*thing, first.get(thing), second.get(thing))
        for thing in {**first, **second}
        if (thing.of in common or thing == names[thing.of])
        and not _alike(first.get(thing), second.get(thing), thing.unit)
    )


def _alike(first: Value, second: Value, unit: str) -> bool:
    if isinstance(first, Number) and isinstance(second, Number):
        return replace(first, provenance="") == replace(second, provenance="")
    if unit == "Hz" and isinstance(first, float) and isinstance(second, float):
        return math.isclose(first, second, rel_tol=SAME_RATE)
    return first == second


_UNITS = {"s": "s", "mah": "mAh", "v": "V", "hz": "Hz", "utc": UTC}
"""Units by the ending of a field's name."""
_OF_RUN = (
    *("kind", "state", "day", "position_in_day", "planned", "robot", "battery"),
    *("started_utc", "duration_s", "starts", "jumps_made"),
)
_OF_CHARGE = (
    *("charge_mah", "resolution_mah", "recharge_s", "end_voltage_v"),
    *("mode", "stated_pack", "ended_utc", "added"),
)


def _fields(of: str, item: object, names: Sequence[str]) -> Things:
    """Give fields of a thing; what stands for its unit at the end of a field's name is that."""
    for name in names:
        what, _mark, ending = name.rpartition("_")
        thing = Thing(of, what, _UNITS[ending]) if what and ending in _UNITS else Thing(of, name)
        yield thing._replace(what=thing.what.replace("_", " ")), getattr(item, name)


def _facts(view: RunView) -> Things:
    yield from _fields("", view.run, _OF_RUN)
    yield from ((Thing("", name), label) for name, label in view.run.levels.items())
    yield Thing("", "notes"), tuple(note.text for note in view.notes)


def _files(view: RunView) -> Things:
    for name, file in _named(view.files):
        yield from _fields(name, file, ("name", "n_bytes", "reader", "reader_version"))
        for setting, value in _settings(file.settings):
            if setting != "declared.file_name":  # its name, once more
                yield Thing(name, setting.removeprefix("declared.")), value
    for name, signal, gaps in _signals(view):
        yield from _fields(name, signal, ("rate_hz", "n_samples", "start_utc"))
        for kind, count in Counter(gap.kind for gap in gaps).items():
            yield Thing(name, f"gaps ({kind})"), count
            missing = sum(gap.samples_missing for gap in gaps if gap.kind == kind)
            yield Thing(name, f"samples missing ({kind})"), missing


def _named(files: Iterable[RunFileRow]) -> Iterator[tuple[str, RunFileRow]]:
    """Name the files of a run by their roles, by which those of two runs are set side by side: log, log 2."""
    count = Counter[str]()
    for file in files:
        count[file.role] += 1
        yield _numbered(file.role, count[file.role]), file


def _numbered(what: str, number: int) -> str:
    return what if number == 1 else f"{what} {number}"


def _signals(view: RunView) -> Iterator[tuple[str, Any, Any]]:
    """Name each signal by its file, the further ones of a file by their place in it: log, log, part 2."""
    names = {file.sha256: name for name, file in _named(view.files)}
    count = Counter[str]()
    for signal, gaps in view.signals:
        name = names[signal.file_sha256]
        count[name] += 1
        yield name if count[name] == 1 else f"{name}, part {count[name]}", signal, gaps


def _settings(table: Mapping[str, Any], above: str = "") -> Iterator[tuple[str, Any]]:
    """Give each setting that a reading depended on by its full name."""
    for name, value in table.items():
        if isinstance(value, Mapping):
            yield from _settings(value, f"{above}{name}.")
        else:
            yield f"{above}{name}", value


def _channels(view: RunView) -> Things:
    for name, signal, _gaps in _signals(view):
        yield Thing(name, "channels"), len(signal.channels)
        yield from ((Thing(name, channel), True) for channel in signal.channels)
    for channel in view.calibrated:
        name = f"calibration of {channel.name}"
        yield Thing(name, "column"), channel.source_name
        yield from _fields(name, channel.calibration, ("scale", "offset", "errors", "source", "period"))


def _charges(view: RunView) -> Things:
    for number, charge in enumerate(view.charges, start=1):
        yield from _fields(_numbered("charge", number), charge, _OF_CHARGE)


def _numbers(view: RunView) -> Things:
    yield Thing("", str(Outcome.JOULES)), view.joules_per_jump
    yield Thing("", f"mean {Outcome.APEX}"), view.mean_apex_height
    yield Thing("", "jumps found"), view.jumps_found
    yield from (
        (Thing("", str(outcome)), view.from_plate[outcome.key]) for outcome in Outcome if outcome.key in view.from_plate
    )


def _verdicts(view: RunView) -> Things:
    for one in view.reviewed:
        said = f"{one.verdict}ed by {one.person}, {one.reason_code}{', blind' if one.blind else ''}"
        yield Thing("", said), one.jumps
    yield Thing("", "jumps not reviewed"), len(view.not_reviewed)


def difference_rows(found: RunsCompared, time_zone: str) -> list[tuple[str, str, str, str]]:
    """Write for people what differs: of what, what, and both values."""
    return [
        (subject, f"{one.of}: {one.what}" if one.of else one.what, *_texts(one, time_zone))
        for subject, several in found.by_subject.items()
        for one in several
    ]


def difference_lines(found: RunsCompared, time_zone: str) -> list[str]:
    """Write what differs as a table of the terminal."""
    rows = difference_rows(found, time_zone)
    if not rows:
        return [f"{found.first} and {found.second} are alike in all that is compared."]
    return columns(("", "", found.first, found.second), rows)


def _texts(one: Difference, time_zone: str) -> tuple[str, str]:
    """Return both values as text, with as many digits as tell them apart."""
    texts = _text(one.first, one.unit, time_zone), _text(one.second, one.unit, time_zone)
    return texts if texts[0] != texts[1] else (_exactly(one.first), _exactly(one.second))


def _exactly(value: Value) -> str:
    return f"{value.value!r} {value.unit}" if isinstance(value, Number) else repr(value)


def _text(value: Value, unit: str, time_zone: str) -> str:
    match value:
        case None | () | []:
            return "none"
        case bool():
            return "yes" if value else "no"
        case Undefined():
            return f"none: {value.reason}"
        case Number():
            return number_text(value)
        case float() | int():
            return with_unit(f"{value:.6g}" if isinstance(value, float) else str(value), unit)
        case str():
            return local_text(value, time_zone) if unit == UTC else value
        case tuple():
            return listed([str(item) for item in value])
    return json.dumps(value, ensure_ascii=False)


def plot_runs(book: Book, connection: sa.Connection, names: tuple[str, str], out: Path) -> None:
    """Draw the body heights of two runs over each other, to a file in the form of its ending."""
    first, second = (drawn_log(book, connection, review(book, connection, name), None)[0] for name in names)
    figure = draw_logs_overlaid(first, second)
    shows = f"Body heights over time, of {first.title}, and of {second.title}"
    write_picture(figure, out, f"Runs {first.run} and {second.run}", shows)
