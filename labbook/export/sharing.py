"""A book without what its `[privacy]` leaves out, for a capsule that everybody may read.

Initials stand for names, and two words for the texts of notes and for paths; all else of every entry stays, with its
time, its uid and its place. A journal that says less has other hashes, so it is chained anew, and `origin.json` states
what was left out, and number and hash of the last entry of the book's own journal. The report is made again of that
journal, because its pages name people and numbers rest on the configuration's text; its entry gets their hashes. So
nothing in such a capsule refers to what is not in it, and it is checked as any other. That its journal is the book's
with no more left out than stated, only who has the book can show: the same command gives the same bytes.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
import re
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Any

import msgspec
import sqlalchemy as sa

from data_schema import journal
from data_schema.engine import reading
from data_schema.errors import InputRefused, UsageError
from data_schema.journal import Entry
from data_schema.journal_file import JournalFile
from data_schema.queries.history import ReportRow
from data_schema.vocabulary import Action
from ingest.store import Store
from labbook.actions.upkeep.tracing import made_again
from labbook.analysis.study import Analysis
from labbook.book.opening import JOURNAL
from labbook.book.replaying import replayed
from labbook.book.report_numbers import NUMBERS, numbers_bytes, numbers_of_report
from labbook.config.parsing import Configuration, parse_configuration
from labbook.export.tables import ExportTable, Step
from reports.page.writing import report_files
from reports.tables.word import WORD

ORIGIN = "origin.json"
LEFT_OUT = "(left out)"
_PATH = re.compile(r"(?<![\w.:/~])(?:~?/[\w.+ -]*\w(?:/[\w.+ -]*\w)+|~/[\w.+-]+|[A-Za-z]:[\\\\/][^\"'\n]+)/?")
"""A path from the root, from a home or with a drive: two parts at least, so that m/s and kg/s are none."""
_NOTES = {"notes": "text", "verdicts": "note"}
"""The column of a table that has the text of a note."""
_NO_URL = "postgresql+psycopg://left-out/left-out"


@dataclass(frozen=True, slots=True)
class Origin:
    """What was left out of a book's journal, and number and hash of its last entry as the book has it."""

    left_out: tuple[str, ...]
    entries: int
    head: str

    @property
    def sentence(self) -> str:
        """Say what such a journal is."""
        return (
            f"made for sharing, without {', '.join(self.left_out)}: its journal is the book's with these left out, "
            f"chained anew; the book's own ends at entry {self.entries} with the hash {self.head}"
        )


def origin_bytes(origin: Origin) -> bytes:
    """Write where a journal comes from."""
    return (json.dumps(msgspec.to_builtins(origin), indent=1) + "\n").encode()


def read_origin(data: bytes) -> Origin:
    """Read it back; raises `InputRefused` where it is none."""
    try:
        return msgspec.json.decode(data, type=Origin)
    except (msgspec.DecodeError, msgspec.ValidationError, UnicodeDecodeError) as error:
        raise InputRefused(f"{ORIGIN} in the archive cannot be read ({error}).") from error


@functools.cache
def _whole(name: str) -> re.Pattern[str]:
    """Return what finds a name, and not a part of another word."""
    return re.compile(rf"(?<!\w){re.escape(name)}(?!\w)")


@dataclass(frozen=True)
class Private:
    """What is left out of texts and entries: names by the initials that stand for them, notes, paths."""

    names: Mapping[str, str]
    notes: bool
    paths: bool

    def text(self, text: str) -> str:
        """Return a text without it."""
        for name, initials in self.names.items():
            text = _whole(name).sub(lambda _found, initials=initials: initials, text)  # type: ignore[misc]
        return _PATH.sub(LEFT_OUT, text) if self.paths else text

    def value(self, value: Any) -> Any:
        """Return a value of JSON without it, in all the texts in it."""
        if isinstance(value, str):
            return self.text(value)
        if isinstance(value, list | tuple):
            return [self.value(item) for item in value]
        if isinstance(value, Mapping):
            return {self.text(key): self.value(item) for key, item in value.items()}
        return value

    def table(self, table: ExportTable) -> ExportTable:
        """Return a table without it."""
        notes = _NOTES.get(table.name) if self.notes else None
        place = list(table.columns).index(notes) if notes else -1
        rows = [
            [LEFT_OUT if at == place and cell is not None else self.value(cell) for at, cell in enumerate(row)]
            for row in table.rows
        ]
        return replace(table, rows=rows)

    def toml(self, text: str) -> str:
        """Return the text of a labbook.toml without it."""
        url = parse_configuration(text, "the book's configuration").database.url
        if self.paths and url is not None:
            text = text.replace(url, _NO_URL)
        text = self.text(text)
        people = parse_configuration(text, "labbook.toml for sharing").people
        left = [name for name in people if name in self.names and self.names[name] != name]
        if left:
            raise UsageError(
                f"the name {left[0]!r} cannot be left out of labbook.toml, where it is written with backslashes: write "
                "its letters as they are, and give any statement, which takes that over."
            )
        return text

    def entry(self, entry: Entry) -> Entry:
        """Return an entry without it."""
        new, old = self.value(entry.new), self.value(entry.old)
        if entry.entity_kind == "config":
            text = self.toml((entry.new or {})["text"])
            new |= {"text": text, "sha256": hashlib.sha256(text.encode()).hexdigest()}
        reason = None if entry.reason is None else self.text(entry.reason)
        if self.notes:
            key = "text" if entry.entity_kind == "note" else "note"
            for values in (new, old):
                if values and values.get(key):
                    values[key] = LEFT_OUT
            if reason and entry.entity_kind == "decision":  # a verdict's is its note
                reason = LEFT_OUT
        if self.paths and entry.action is Action.REPORT:
            new |= {"folder": PurePosixPath((entry.new or {})["folder"]).name}
        return replace(entry, person=self.text(entry.person), new=new, old=old, reason=reason)


@dataclass(frozen=True, slots=True)
class SharedBook:
    """The journal of a book for sharing, the files of its report by name, where both come from, and the names."""

    entries: list[Entry]
    report: Mapping[str, bytes]
    origin: Origin
    names: tuple[str, ...]

    def refuse_names(self, files: Mapping[str, bytes]) -> None:
        """Raise `UsageError` where a name is still in one of these files, or in the report's."""
        for path, data in {**files, **self.report}.items():
            text = data.decode(errors="replace")
            for name in self.names:
                if _whole(name).search(text):
                    raise UsageError(
                        f"the name {name!r} would still be in {path}: correct what says it there, or leave people in "
                        "with [privacy] leave_out."
                    )


def parts_left(files: Mapping[str, bytes], names: Iterable[str]) -> tuple[str, ...]:
    """Say in which of these texts a part of a name still stands: in a reason, a comment, a hypothesis, an address.

    Parts of four letters or more are looked for, as words of their own, whatever their case.
    """
    parts = sorted({part for name in names for part in name.split() if len(part) >= _PART_LETTERS})
    texts = {path: data.decode(errors="replace") for path, data in files.items()}
    found = {
        part: [
            path for path, text in texts.items() if re.search(rf"(?<!\w){re.escape(part)}(?!\w)", text, re.IGNORECASE)
        ]
        for part in parts
    }
    more = {part: f" and {len(paths) - 1} more" if len(paths) > 1 else "" for part, paths in found.items()}
    return tuple(
        f"{part!r} still stands in {paths[0]}{more[part]}: correct what says it in the book, or share it as it is."
        for part, paths in found.items()
        if paths
    )


_PART_LETTERS = 4


def private_of(people: Mapping[str, str], configuration: Configuration) -> Private:
    """Return what a configuration leaves out for sharing, of people by name with their initials.

    Raises `UsageError` where it names nothing, or where initials cannot stand for names.
    """
    left_out = configuration.privacy.leave_out
    if not left_out:
        raise UsageError(
            "labbook.toml does not say what is left out for sharing: write [privacy] with "
            'leave_out = ["people", "notes", "paths"], and give any statement, which takes that over.'
        )
    names = people if "people" in left_out else {}
    if len({*names.values()}) < len(names):
        raise UsageError("two people of the journal have the same initials, which cannot stand for their names.")
    longest_first = dict(sorted(names.items(), key=lambda item: -len(item[0])))
    return Private(longest_first, "notes" in left_out, "paths" in left_out)


def shared_book(
    store: Store,
    entries: Sequence[Entry],
    people: Mapping[str, str],
    configuration: Configuration,
    made_of: ReportRow,
    step: Step,
) -> SharedBook:
    """Leave out of a book what its configuration names, and make its report again.

    Parameters: the book's store, its entries, initials by name, its configuration, the report.
    Raises `UsageError` where the configuration names nothing, or where a name cannot be left out.
    """
    private = private_of(people, configuration)
    without = list(_chained(map(private.entry, entries)))
    with played_back(store, without, made_of.as_of, step) as connection:
        made = made_again(connection, store, made_of.selection or None, made_of.made_utc)
    step("writing the report's pages")
    report = _files(made, made_of)
    hashes = {name: hashlib.sha256(data).hexdigest() for name, data in report.items()}

    def with_files(entry: Entry) -> Entry:
        return replace(entry, new={**(entry.new or {}), "files": hashes}) if entry.seq == made_of.seq else entry

    shared = list(_chained(map(with_files, without)))
    left_out = tuple(configuration.privacy.leave_out)
    return SharedBook(shared, report, Origin(left_out, len(entries), entries[-1].hash), tuple(private.names))


@contextlib.contextmanager
def played_back(store: Store, entries: Sequence[Entry], seq: int, step: Step) -> Iterator[sa.Connection]:
    """Read the book that a journal gives, played back to an entry."""
    with tempfile.TemporaryDirectory(prefix="labbook-capsule-") as name:
        mirror = JournalFile(Path(name) / JOURNAL)
        mirror.path.write_text("".join(f"{entry.line}\n" for entry in entries), encoding="utf-8")
        with (
            replayed(store, mirror, seq, step, use_cache=True) as (engine, _replay),
            reading(engine) as connection,
        ):
            yield connection


def _chained(entries: Iterable[Entry]) -> Iterable[Entry]:
    """Chain entries anew, command by command."""
    after = (0, journal.GENESIS)
    for command in journal.commands(entries):
        for entry in journal.chain_entries(command, after):
            after = (entry.seq, entry.hash)
            yield entry


def _files(made: Analysis, made_of: ReportRow) -> dict[str, bytes]:
    """Make the files of a report that it has in the book."""
    known = made_of.files
    numbers = {NUMBERS: numbers_bytes(numbers_of_report(made))}
    if known.keys() == numbers.keys():
        return numbers
    every_figure = any(name.endswith(".pdf") for name in known)
    drawn = report_files(made.results, summary="summary.html" in known, every_figure=every_figure, word=WORD in known)
    return {**drawn, **numbers}
