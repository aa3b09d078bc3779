"""`labbook export --capsule`: a book and one report of it as one file, from which anybody can make every number anew.

The file is a zipped RO-Crate, as notebooks of other makers read and write (`.eln`): raw copies and samples as the store
has them, the journal, labbook.toml, tables with what their columns mean, the report, and how to check all of it.
Everything but raw copies, samples and the report's pages is made of the book, as `made_files` says: `labbook verify`
makes it again of the raw copies and the journal. The same book gives the same bytes.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path, PurePosixPath

import sqlalchemy as sa

from data_schema import journal
from data_schema.disk import SPECIAL, is_special
from data_schema.errors import BookDamaged, UsageError
from data_schema.journal import Entry
from data_schema.queries.files import signal_files
from data_schema.queries.history import ReportRow, list_reports
from data_schema.queries.study import ConfigRow, config_in_force, people
from ingest.store import Store, raw_path
from labbook.actions.upkeep.report_differences import report_named
from labbook.analysis.preregistration.planned import planned_analysis, planned_sentences
from labbook.book.copies.copying import raw_of
from labbook.book.opening import CONFIGURATION, JOURNAL, Book
from labbook.book.report_numbers import NUMBERS, numbers_path
from labbook.config.parsing import Configuration, own_text, parse_configuration
from labbook.export.archive import BLOCK, Member, member, write_archive
from labbook.export.crate import METADATA, About, crate_bytes
from labbook.export.sharing import ORIGIN, Origin, origin_bytes, parts_left, played_back, shared_book
from labbook.export.table_files import DICTIONARY, PACKAGE, data_dictionary, data_package, table_csv, table_path
from labbook.export.tables import Selection, Step, every_table
from labbook.terminal import plain

ENDING = ".eln"
REPORT = "report"
_FROM_BACKUP = "restore it from a backup"
ANALYSIS, VERIFY, SUMS = "analysis.json", "VERIFY.md", "SHA256SUMS"


@dataclass(frozen=True, slots=True)
class WrittenCapsule:
    """Where a capsule was written, its SHA-256 and size, and what it holds; `remarks` are on what is private in it."""

    file: str
    sha256: str
    n_bytes: int
    files: int
    entries: int
    raw_copies: int
    report: str
    remarks: tuple[str, ...] = ()


def write_capsule(
    book: Book,
    file: Path,
    report: str | None = None,
    step: Step = lambda _what: None,
    *,
    for_sharing: bool = False,
) -> WrittenCapsule:
    """Write a book and a report of it into one file, which appears whole or not at all.

    Parameters: the open book; the file, which must not exist; the report by its number, id or `last` (the newest one
    without); what is called with each step; whether what `[privacy]` names is left out. Nothing is stated in the book.
    Raises `UsageError` where the file exists or is not called `.eln`, where there is no report, or where its pages are
    not there as they were written; `BookDamaged` where a raw copy or the journal is not.
    """
    if file.suffix != ENDING:
        raise UsageError(
            f"{str(file)!r} is no name of a capsule: let it end in {ENDING}, as {file.stem or 'study'}.eln."
        )
    remarks: tuple[str, ...] = ()
    with book.reading() as connection:
        made_of = _report_of(connection, report)
        entries = _entries(book, connection)
        row = config_in_force(connection)
        if row is None or row.sha256 != book.configuration.sha256:
            raise UsageError(
                f"{CONFIGURATION} was changed since the last statement, and the book has not taken it over yet: make "
                "the report of it with `labbook report`, then the capsule."
            )
        configuration = configuration_of(row)
        sources: dict[str, bytes | Path] = {**_stored_files(book, connection, entries, step)}
        of_report = _report_files(book, made_of)
        if for_sharing:
            shared = shared_book(book.store, entries, people(connection), configuration, made_of, step)
            entries = shared.entries
            with played_back(book.store, entries, len(entries), step) as again:
                row = config_in_force(again)
                assert row is not None, "a report was made of it"  # noqa: S101
                made_now = next(one for one in list_reports(again) if one.seq == made_of.seq)
                step("making tables")
                about, made = made_files(again, book.store, configuration_of(row), entries, made_now, shared.origin)
            shared.refuse_names(made)
            remarks = parts_left({**made, **shared.report}, shared.names)
            sources |= {f"{REPORT}/{name}": data for name, data in shared.report.items()}
        else:
            step("making tables")
            about, made = made_files(connection, book.store, configuration, entries, made_of)
            sources |= of_report
    step("hashing files")
    members = crate_members(about, made, [member(path, source) for path, source in sources.items()])
    step("packing")
    root = re.sub(r"[^\w .+-]", "_", file.stem)[:100].strip(". ") or "capsule"  # the folder in it is called as the file
    write_archive(file, root, members, datetime.fromisoformat(entries[-1].at_utc))
    with file.open("rb") as stream:
        sha256 = hashlib.file_digest(stream, "sha256").hexdigest()
    return WrittenCapsule(
        file=str(file),
        sha256=sha256,
        n_bytes=file.stat().st_size,
        files=len(members),
        entries=len(entries),
        raw_copies=len(raw_of(entries)),
        report=made_of.called,
        remarks=remarks,
    )


def _report_of(connection: sa.Connection, named: str | None) -> ReportRow:
    if not any(not one.elsewhere for one in list_reports(connection)):
        raise UsageError(
            "this book has no report yet, without which a capsule shows nothing: make one with `labbook report`."
        )
    found = report_named(connection, named or "last")
    if found.elsewhere:
        raise UsageError(
            f"report {found.called} was made in a book that was merged into this one: make a capsule there, or a "
            "report of this book with `labbook report`."
        )
    return found


def _entries(book: Book, connection: sa.Connection) -> list[Entry]:
    """Return the journal as the book's file has it, as far as the database goes."""
    seq, head = journal.head(connection)
    entries = list(book.mirror.entries())[:seq]
    if len(entries) < seq or entries[-1].hash != head:
        raise BookDamaged(f"journal.jsonl is not that of the database: {journal.MEND_FILE}.")
    return entries


def configuration_of(row: ConfigRow) -> Configuration:
    """Return a configuration as the journal has it."""
    return parse_configuration(row.text, "the book's configuration")


def _stored_files(book: Book, connection: sa.Connection, entries: Sequence[Entry], step: Step) -> dict[str, Path]:
    """Return where raw copies and samples lie, by their paths in a capsule; every raw copy is read and compared."""
    found: dict[str, Path] = {}
    for sha256 in raw_of(entries):
        step(f"reading raw copy {sha256[:12]}")
        path = raw_path(sha256)
        raw_content(book.store.root / path, sha256)
        found[path] = book.store.root / path
    for stored in signal_files(connection):
        found[stored.store_path] = book.store.root / stored.store_path
        if not found[stored.store_path].is_file():
            raise BookDamaged(f"the samples {stored.store_path} of {stored.name} are missing: run `labbook rebuild`.")
    return found


def raw_content(path: Path, sha256: str, most: int | None = None, remedy: str = _FROM_BACKUP) -> int:
    """Read a raw copy through, and return how many bytes it holds.

    Parameters: where it lies, the SHA-256 of what it holds, how many bytes that are at most, if that is known, and what
    an error advises.
    Raises `BookDamaged` where it cannot be read, holds something else, or holds more.
    """
    import pyarrow as pa

    n_bytes, digest = 0, hashlib.sha256()
    if is_special(path):
        raise BookDamaged(f"the raw copy {path.name} {SPECIAL}: {remedy}.")
    try:
        with pa.input_stream(str(path), compression="zstd") as stream:
            while block := stream.read(BLOCK):
                n_bytes += len(block)
                digest.update(block)
                if most is not None and n_bytes > most:
                    raise BookDamaged(
                        f"the raw copy {path.name} holds more than the {most} bytes of its file: {remedy}."
                    )
    except (OSError, pa.ArrowInvalid) as error:
        raise BookDamaged(f"the raw copy {path.name} cannot be read ({error}): {remedy}.") from error
    if digest.hexdigest() != sha256:
        raise BookDamaged(f"the raw copy {path.name} was changed after it was kept: {remedy}.")
    return n_bytes


def _report_files(book: Book, made_of: ReportRow) -> dict[str, Path]:
    """Return where the files of a report lie, by their paths in a capsule, each compared with its hash."""
    folder = book.folder / made_of.folder
    found: dict[str, Path] = {}
    for name, sha256 in made_of.files.items():
        path = numbers_path(book.store.root, sha256) if name == NUMBERS else folder / name
        try:
            is_as_written = member(name, path).sha256 == sha256
        except OSError:
            is_as_written = False
        if not is_as_written:
            raise UsageError(
                f"{path} is not as it was written for report {made_of.called}: make the report again with `labbook "
                "report`, or name another with --report."
            )
        found[f"{REPORT}/{name}"] = path
    return found


def made_files(
    connection: sa.Connection,
    store: Store,
    configuration: Configuration,
    entries: Sequence[Entry],
    made_of: ReportRow,
    origin: Origin | None = None,
) -> tuple[About, dict[str, bytes]]:
    """Make all of a capsule that is not as the store or the report has it, but for the crate and the list of hashes.

    Parameters: the book after the last of `entries`, with its store and configuration, the report, and where the
    journal comes from, if something was left out of it. Returns what the crate says of itself, and the files by path;
    the same for the same book.
    """
    selection = Selection(connection, store, configuration)
    tables = every_table(selection)
    files = {table_path(table.name): table_csv(table) for table in tables}
    package = data_package(configuration.study.name, configuration.sharing.license, tables, files)
    files |= {DICTIONARY: data_dictionary(tables), PACKAGE: package}
    planned = planned_analysis(connection, configuration)
    analysis = {**plain(planned), "sentences": planned_sentences(planned)}
    files[ANALYSIS] = (json.dumps(analysis, indent=1, ensure_ascii=False) + "\n").encode()
    files[JOURNAL] = "".join(f"{entry.line}\n" for entry in entries).encode()
    files[CONFIGURATION] = own_text(configuration).encode()
    simulation = configuration.simulation
    if simulation is not None and simulation.scene_toml is not None:
        place = PurePosixPath(simulation.scene)
        if not place.is_absolute() and ".." not in place.parts:
            files[str(place)] = simulation.scene_toml.encode()
    files |= {} if origin is None else {ORIGIN: origin_bytes(origin)}
    days = sorted(run.day for run in selection.data.selected if run.day)
    about = About(
        name=configuration.study.name,
        description=_description(configuration, made_of, len(selection.data.selected), days, entries, origin),
        people={initials: name for name, initials in people(connection).items()},
        license=configuration.sharing.license,
        entries=len(entries),
        head=entries[-1].hash,
        at_utc=entries[-1].at_utc,
        version=importlib.metadata.version("robot-labbook"),
    )
    files[VERIFY] = _verify_text(about, made_of, origin).encode()
    return about, files


def _description(
    configuration: Configuration,
    made_of: ReportRow,
    runs: int,
    days: Sequence[str],
    entries: Sequence[Entry],
    origin: Origin | None,
) -> str:
    shared = "" if origin is None else f" It was {origin.sentence}."
    when = f" of {days[0]}" + (f" to {days[-1]}" if days[-1] != days[0] else "") if days else ""
    return (
        f"The lab notebook of the study {configuration.study.name!r}: {runs} runs{when}, the files of the instruments, "
        f"the journal of {len(entries)} statements, tables of what was measured, and report {made_of.called}.{shared}"
    )


def crate_members(about: About, made: Mapping[str, bytes], stored: Iterable[Member]) -> list[Member]:
    """Return the files of a capsule in their order: the crate, how to check it, the list of hashes, all others."""
    files = {one.path: one for one in stored} | {path: member(path, data) for path, data in made.items()}
    others = [files[path] for path in sorted(files) if path != VERIFY]
    listed = "".join(f"{one.sha256}  {one.path}\n" for one in [files[VERIFY], *others])
    first = [files[VERIFY], member(SUMS, listed.encode())]
    return [member(METADATA, crate_bytes(about, [*first, *others])), *first, *others]


def _verify_text(about: About, made_of: ReportRow, origin: Origin | None) -> str:
    shared = "" if origin is None else _SHARED.format(origin.sentence)
    return f"""\
# {about.name}

This folder is a lab notebook with report {made_of.called}, and everything that its numbers
rest on. Written by labbook {about.version}; {about.entries} statements, the last one at {about.at_utc}.

| where | what |
|---|---|
| `report/` | the report: its page, figures and tables; `numbers.json`: all numbers, and what each rests on |
| `tables/` | what was measured, as CSV; `data_dictionary.csv` says what each column means |
| `datapackage.json` | the same for programs, as a Frictionless data package |
| `analysis.json` | what was decided about the analysis before the first measurement, and what departs from it |
| `raw/` | the files of the instruments, byte for byte, compressed by zstd |
| `signals/` | the samples read from them, as Parquet |
| `journal.jsonl` | every statement of a person: each line has the hash of the line before |
| `labbook.toml` | the configuration of the study |
| `ro-crate-metadata.json` | all of this as RO-Crate, which other notebooks read |
{shared}
## Check it with labbook

    pip install robot-labbook
    labbook verify FILE.eln

needs no network and no database. It compares all files with their hashes, follows the chain of the journal, reads the
raw files anew, plays the journal back, computes every number of the report and every table anew, and says whether all
are the same to the last digit.

## Check it by hand

    sha256sum --check SHA256SUMS

compares each file with its hash. A raw file is named after the SHA-256 of what it holds:

    zstd -dc raw/ab/HASH.zst | sha256sum

The hash of a journal's line is the SHA-256 of its JSON without `hash`, with sorted keys and no blanks; `prev_hash` is
that of the line before. The last line's is `{about.head}`.

Who wrote the journal, and when, a hash cannot prove: compare the last line's hash with one that was published, or sent
to somebody, at the time.
"""


_SHARED = """
It was {}. Initials stand for names, and `(left out)` for the rest; files of the instruments are as they came. The
report was made again of this journal, with the same values; its numbers' ids are others where labbook.toml is. Who has
the book can make this file again, to the same bytes, with `labbook export --capsule FILE --for-sharing`.
"""
