"""`labbook verify`: whether a capsule is whole, found out of its own bytes alone, in a temporary folder.

The files are compared with the crate, the journal is followed line by line, and then played back from the raw copies
into a book of its own, with no cache read that could hide an alteration. Of that book the report is made again as of
its entry, and everything that the capsule's book gave: tables, their descriptions, the crate itself. Whatever is not
the same is named, with by how much.

Where files are not those that the crate states, nothing is computed from them.
"""

from __future__ import annotations

import csv
import io
import re
import tempfile
from collections.abc import Container, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from datetime import datetime
from itertools import pairwise, zip_longest
from pathlib import Path

import msgspec
import sqlalchemy as sa

from data_schema import journal
from data_schema.engine import reading
from data_schema.errors import BookDamaged, BookError, InputRefused, LabbookError, UsageError
from data_schema.file_cache import without_caches
from data_schema.journal import Entry
from data_schema.journal_file import JournalFile
from data_schema.queries.files import signal_files
from data_schema.queries.history import list_reports, report_as_of
from data_schema.queries.study import config_in_force, the_study
from data_schema.vocabulary import Action
from ingest.model import DEFAULT_LIMITS
from ingest.store import Store, raw_path
from labbook.actions.upkeep.tracing import differing_fields, made_again, number_anew
from labbook.book.altered import differences, shortened_pair
from labbook.book.opening import JOURNAL
from labbook.book.replaying import Replay, replayed
from labbook.book.report_numbers import NUMBERS, ReportedNumber, ReportNumbers, numbers_bytes, numbers_of_report
from labbook.config.parsing import parse_configuration
from labbook.export.archive import ASK_AGAIN, Archive, Member, first_difference, member, write_archive
from labbook.export.capsule import (
    REPORT,
    SUMS,
    VERIFY,
    configuration_of,
    crate_members,
    made_files,
    raw_content,
)
from labbook.export.crate import METADATA, StatedFile, stated_files
from labbook.export.sharing import ORIGIN, read_origin
from labbook.export.tables import Step
from reports.page.writing import files_beside_figures
from reports.results import StudyResults
from reports.tables.word import WORD

PAGE = "report.html"
MOST_METADATA = 64 * 2**20
"""Bytes of the crate's description, which is in memory as a whole: that of 100 000 files."""
MOST_NAMED = 20
"""So many differences of a kind are named, and then how many more there are."""
MOST_LIMITS = 10
"""Times what labbook lets a file ask for: a journal states the bounds under which its files were read."""
ROUNDING = 1e-9
"""Relative differences up to this are those of another processor or library, and said to be."""
_SHA256 = re.compile(r"[0-9a-f]{64}")
_OF_REPORT = f"{REPORT}/"


@dataclass(slots=True)
class Verified:
    """What was found of a capsule: what differs, nothing where it is whole, and what was compared.

    `report` is "" and counts are 0 where it did not come that far. `remarks` are no differences.
    """

    file: str
    files: int = 0
    entries: int = 0
    raw_copies: int = 0
    report: str = ""
    numbers: int = 0
    tables: int = 0
    differences: list[str] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)

    @property
    def whole(self) -> bool:
        """Whether nothing differs."""
        return not self.differences

    @property
    def sentence(self) -> str:
        """Say in one sentence what was found."""
        if not self.whole:
            several = len(self.differences) > 1
            return (
                f"{self.file} is not as it was written: {len(self.differences)} thing{'s' * several} "
                f"differ{'' if several else 's'}."
            )
        return (
            f"{self.file} is whole: its {self.files} files and {self.entries} journal entries fit each other, and all "
            f"{self.numbers} numbers of report {self.report} and {self.tables} tables, computed anew from "
            f"{self.raw_copies} raw files, are the same to the last digit."
        )

    def add(self, sentences: Sequence[str], what: str) -> None:
        """Add differences of a kind, of many the first and how many more there are."""
        self.differences += sentences[:MOST_NAMED]
        if len(sentences) > MOST_NAMED:
            self.differences.append(f"and {len(sentences) - MOST_NAMED} more {what}.")


@dataclass(frozen=True, slots=True)
class _Unpacked:
    """A capsule, unpacked into a folder: its files by path, and what was found so far; `step` is told what is done."""

    archive: Archive
    folder: Path
    found: Verified
    step: Step
    members: dict[str, Member] = field(default_factory=dict)

    def bytes_of(self, path: str) -> bytes:
        """Return what a file holds."""
        return (self.folder / path).read_bytes()

    def below(self, folder: str) -> list[str]:
        """Return the files in a folder."""
        return [path for path in self.members if path.startswith(f"{folder}/")]


def verify(file: Path, step: Step = lambda _what: None) -> Verified:
    """Check a capsule, and return what differs; nothing is written but in a temporary folder.

    Parameters: the file; what is called with each step.
    Raises `InputRefused` for what is no capsule, or one that could do harm: names that lead out of its folder, links,
    encrypted files, more bytes than it states. Raises `UsageError` where the file is not there.
    """
    if not file.is_file():
        raise UsageError(f"there is no file {str(file)!r}: name a capsule, which `labbook export --capsule` writes.")
    found = Verified(str(file))
    with tempfile.TemporaryDirectory(prefix="labbook-verify-") as name, Archive(file) as archive:
        capsule = _Unpacked(archive, Path(name) / "files", found, step)
        capsule.folder.mkdir()
        step("unpacking")
        _unpack(capsule)
        if not found.differences:
            _check_book(capsule)
    return found


def _unpack(capsule: _Unpacked) -> None:
    """Unpack the files that the crate states, and compare each with it."""
    archive = capsule.archive
    if METADATA not in archive.paths:
        raise InputRefused(
            f"{str(archive.file)!r} has no {METADATA} in its folder: name a file of `labbook export --capsule`."
        )
    metadata = archive.read(METADATA, MOST_METADATA)
    stated = stated_files(metadata)
    archive.refuse_more_than(len(metadata) + sum(one.n_bytes for one in stated.values()), capsule.folder)
    capsule.found.files = len(archive.paths)
    differing: list[str] = [f"{path} is missing from the archive." for path in stated if path not in archive.paths]
    for path in archive.paths:
        capsule.step(f"unpacking {path}")
        about = StatedFile(len(metadata), "") if path == METADATA else stated.get(path)
        if about is None:
            differing.append(f"{path} is in the archive, and the crate does not state it.")
            continue
        try:
            one = capsule.members[path] = archive.extract(path, about.n_bytes, capsule.folder)
        except InputRefused as error:
            differing.append(str(error))
            continue
        if about.sha256 and one.n_bytes != about.n_bytes:
            differing.append(f"{path} has {one.n_bytes} bytes, and the crate states {about.n_bytes}.")
        elif about.sha256 not in ("", one.sha256):
            differing.append(f"{path} was altered: its SHA-256 is {one.sha256}, and the crate states {about.sha256}.")
    capsule.found.add(differing, "files that differ")


def _check_book(capsule: _Unpacked) -> None:
    """Check the journal and the raw copies, then play the journal back and make everything again."""
    archive, folder, found = capsule.archive, capsule.folder, capsule.found
    capsule.step("following the journal")
    mirror = JournalFile(folder / JOURNAL)
    try:
        entries = list(mirror.entries())
        left_out = mirror.left_out()
    except BookError as error:
        found.differences.append(_of_capsule(error, folder))
        return
    except RecursionError:
        found.differences.append(f"{JOURNAL} holds a line that no labbook wrote: {ASK_AGAIN}.")
        return
    if left_out.n_bytes or not entries:
        found.differences.append(f"{JOURNAL} ends in {left_out.n_bytes} bytes that are no whole command: {ASK_AGAIN}.")
        return
    found.entries = len(entries)
    _check_raw(capsule, entries)
    if found.differences:
        return
    again, stated = folder.with_name("again.eln"), datetime.fromisoformat(entries[-1].at_utc)
    write_archive(again, archive.root, [capsule.members[path] for path in archive.paths], stated)
    place = first_difference(archive.file, again)
    again.unlink()
    if place is not None:
        found.differences.append(
            f"the archive around the files was altered, or packed anew by another program: byte {place} is not as "
            "labbook writes it."
        )
    try:
        with replayed(Store(folder), mirror, 0, capsule.step, use_cache=False) as (engine, replay):
            _check_made(capsule, engine, replay, entries)
    except LabbookError as error:
        found.differences.append(f"the journal cannot be played back: {_of_capsule(error, folder)}")
    except OSError:
        raise  # the disk is full, or may not be written to
    except Exception as error:  # whatever a journal leads to whose hashes fit, and that says what no labbook would
        found.differences.append(f"the journal cannot be played back ({type(error).__name__}: {error}): {ASK_AGAIN}.")


def _of_capsule(error: LabbookError, folder: Path) -> str:
    """Return what an error says, with what to do for who has a capsule and no book."""
    return str(error).replace(f"{folder}/", "").replace(journal.MEND_FILE, ASK_AGAIN)


def _check_raw(capsule: _Unpacked, entries: Sequence[Entry]) -> None:
    """Compare each raw copy with its name and with how many bytes were imported; none may be missing or too many."""
    readings = [entry for entry in entries if entry.reads]
    n_bytes = {str((entry.new or {}).get("sha256")): (entry.new or {}).get("n_bytes") for entry in readings}
    differing = [sentence for entry in readings for sentence in _beyond_limits(entry)]
    for sha256, most in n_bytes.items():
        path = raw_path(sha256)
        if not _SHA256.fullmatch(sha256) or path not in capsule.members:
            differing.append(f"{path[:200]}, which the journal names, is not in the archive.")
            continue
        capsule.step(f"reading raw file {sha256[:12]}")
        try:
            held = raw_content(capsule.folder / path, sha256, most if isinstance(most, int) else None, ASK_AGAIN)
        except BookDamaged as error:
            differing.append(str(error))
            continue
        if held != most:
            differing.append(f"{path} holds {held} bytes, and the journal says {most}.")
    of_journal = {raw_path(sha256) for sha256 in n_bytes}
    others = [path for path in capsule.below("raw") if path not in of_journal]
    differing += [f"{path} is of no entry of the journal." for path in others]
    capsule.found.raw_copies = len(n_bytes)
    capsule.found.add(differing, "raw files that differ")


def _beyond_limits(entry: Entry) -> list[str]:
    """Name the bounds on what a file may ask for that an entry raises further than is believed of a stranger."""
    new = entry.new or {}
    settings = new.get("settings")
    declared = settings.get("declared") if isinstance(settings, Mapping) else None
    limits = declared.get("limits") if isinstance(declared, Mapping) else None
    if not isinstance(limits, Mapping):
        return [f"entry {entry.seq} of the journal does not say how its file was read: {ASK_AGAIN}."]
    asked = {name: (limits.get(name, most), MOST_LIMITS * most) for name, most in asdict(DEFAULT_LIMITS).items()}
    return [
        f"entry {entry.seq} of the journal lets a file ask for {name} = {given!r}, beyond {most}: it is not read."
        for name, (given, most) in asked.items()
        if not isinstance(given, int) or given > most
    ]


def _check_made(capsule: _Unpacked, engine: sa.Engine, replay: Replay, entries: Sequence[Entry]) -> None:
    """Make the report and all else again, as the journal and the raw copies give it."""
    found, step = capsule.found, capsule.step
    stated = _entry_of_report(capsule, entries)
    if stated is None:
        found.differences.append(
            f"the files under {REPORT}/ are those of no report in the journal: a page, table or figure was exchanged."
        )
        return
    of_report = stated.new or {}
    origin = read_origin(capsule.bytes_of(ORIGIN)) if ORIGIN in capsule.members else None
    if origin is not None:
        found.remarks.append(f"It was {origin.sentence}; only who has the book can show that.")
    replay.apply_to(engine, report_as_of(stated.seq, of_report, stated.origin is not None))
    step("computing the report's numbers")
    with reading(engine) as connection, without_caches():
        again = made_again(connection, replay.store, of_report["where"], of_report["made_at"])
        data = numbers_bytes(numbers_of_report(again))
    found.numbers = of_report["numbers"]
    given = capsule.bytes_of(f"{REPORT}/{NUMBERS}")
    if data != given:
        found.add(_numbers_that_differ(given, data), "numbers that differ")
    step("writing the report's pages")
    figures = capsule.below(f"{REPORT}/figures")
    active = [path for path in figures if is_active(capsule.bytes_of(path))]
    found.add([f"{path} holds a script or a link, which no figure of labbook does." for path in active], "such figures")
    found.remarks += _not_proved(entries, len(figures))
    _compare_pages(capsule, again.results, own_page=bool(of_report.get("own_page")))
    replay.apply_to(engine)
    step("making tables")
    with reading(engine) as connection, without_caches():
        found.add(_study_that_differs(connection), "settings of the study that differ")
        row = config_in_force(connection)
        if row is None:
            raise BookDamaged("the journal has no configuration.")
        made_of = next(one for one in list_reports(connection) if one.seq == stated.seq)
        about, made = made_files(connection, replay.store, configuration_of(row), entries, made_of, origin)
        as_stored = [one for path, one in capsule.members.items() if path.startswith(("raw/", "signals/", _OF_REPORT))]
        anew = {one.path: one for one in crate_members(about, made, as_stored)}
        samples = {stored.store_path: stored.sha256 for stored in signal_files(connection)}
        other_readers = differences(connection, journal.stored(connection), replay.without_rows).other_versions
    found.report = made_of.called
    found.tables = sum(path.startswith("tables/") for path in anew)
    _compare_made(capsule, anew)
    step("comparing samples")
    _compare_samples(capsule, samples, replay.store)
    if other_readers or again.versions != of_report["versions"]:
        found.remarks.append(
            "other versions of readers or algorithms made it than this labbook has, so that numbers may differ without "
            f"fault: {VERIFY} in it says which labbook wrote it, `pip install robot-labbook==VERSION` has that one."
        )


_ACTIVE = re.compile(
    rb"<\s*(?:\w+:)?(script|foreignObject|iframe|object|embed|animate\w*|set|handler)\b|[\s\"'/]on[a-z]+\s*=|javascript:"
    rb"|href\s*=\s*[\"']?(?!#|data:image/png;|[\"']|\s)",
    re.IGNORECASE,
)


def is_active(drawing: bytes) -> bool:
    """Tell whether a drawing could run something, or lead somewhere, in a browser."""
    return drawing.lstrip()[:1] == b"<" and _ACTIVE.search(_HARMLESS.sub(b"", drawing)) is not None


_HARMLESS = re.compile(rb"<metadata>.*?</metadata>|<!DOCTYPE[^>]*>|<\?xml[^>]*\?>", re.DOTALL)
"""What SVG of matplotlib begins with, and pages leave out."""


def _study_that_differs(connection: sa.Connection) -> list[str]:
    """Compare what labbook.toml says of the study with what the journal states, from which the numbers come."""
    row, study = config_in_force(connection), the_study(connection)
    if row is None or study is None:
        return []
    given = parse_configuration(row.text, "labbook.toml of the capsule").study
    pairs = {
        name: (getattr(given, name), getattr(study, name))
        for name in ("name", "kind", "reference_voltage_v", "jumps_nominal", "time_zone")
    }
    return [
        f"labbook.toml says {name} = {one!s} of the study, and the journal's statement of it {other!s}."
        for name, (one, other) in pairs.items()
        if one != other
    ]


def _not_proved(entries: Sequence[Entry], n_figures: int) -> list[str]:
    """Say what is compared by hashes alone, and what no hash can show."""
    back = [two.seq for one, two in pairwise(entries) if two.at_utc < one.at_utc]
    return [
        f"{n_figures} figures were compared with the journal's hashes, not drawn again.",
        *([f"the clock of the journal goes back at entry {', '.join(map(str, back[:3]))}."] if back else []),
        "who stated what, and when, no hash can show: compare the journal's last hash with one that was published, "
        f"{entries[-1].hash}.",
    ]


def _entry_of_report(capsule: _Unpacked, entries: Sequence[Entry]) -> Entry | None:
    """Return the last entry whose report has just the files that are here."""
    members = capsule.members.items()
    here = {path.removeprefix(_OF_REPORT): one.sha256 for path, one in members if path.startswith(_OF_REPORT)}
    reports = (entry for entry in reversed(entries) if entry.action is Action.REPORT and entry.origin is None)
    return next((entry for entry in reports if (entry.new or {}).get("files") == here), None)


def _compare_made(capsule: _Unpacked, anew: Mapping[str, Member]) -> None:
    """Compare what a capsule made of its book with the same made anew."""
    members = capsule.members
    differing = _other_files(members, anew, "this book gives")
    for path, one in anew.items():
        if path not in members or members[path].sha256 == one.sha256 or path in (METADATA, SUMS):
            continue
        assert isinstance(one.source, bytes), "all that is made is in memory"  # noqa: S101
        given = capsule.bytes_of(path)
        if path.startswith("tables/"):
            differing += _cells_that_differ(path, given, one.source)
        else:
            differing.append(f"{path} is not as the book gives it: {_first_line(given, one.source)}.")
    if not differing and not capsule.found.differences:
        for path in (SUMS, METADATA):
            made, given = anew[path].source, capsule.bytes_of(path)
            if isinstance(made, bytes) and given != made:
                differing.append(f"{path} is not as labbook writes it: {_first_line(given, made)}.")
    capsule.found.add(differing, "things that differ")


def _other_files(given: Iterable[str], anew: Iterable[str], who_gives: str, known: Container[str] = ()) -> list[str]:
    """Name the files that are missing, and those that are too many but for known ones."""
    missing = [f"{path} is missing, which {who_gives}." for path in anew if path not in set(given)]
    others = [path for path in given if path not in set(anew) and path not in known]
    return missing + [f"{path} is nothing that {who_gives}." for path in others]


def _first_line(given: bytes, anew: bytes) -> str:
    """Say which line of a text is the first that differs, and how."""
    lines = zip_longest(*(data.decode(errors="replace").splitlines() for data in (given, anew)), fillvalue="")
    for number, (one, other) in enumerate(lines, start=1):
        if one != other:
            stands, should_be = shortened_pair(one, other)
            return f"line {number} is {stands} and should be {should_be}"
    return "its line ends differ"


def _cells_that_differ(path: str, given: bytes, anew: bytes) -> list[str]:
    """Name the cells of a table that are not as they come out anew, and by how much numbers differ."""
    rows, others = (list(csv.reader(io.StringIO(data.decode(errors="replace"), newline=""))) for data in (given, anew))
    if not rows or rows[:1] != others[:1] or len(rows) != len(others):
        return [f"{path} has {len(rows)} lines, and {len(others)} come out anew, or other columns."]
    return [
        f"{path}: {name} of line {number} ({row[0]}) is {cell or 'empty'} and comes out as {other or 'empty'}"
        f"{_by_how_much(cell, other)}."
        for number, (row, beside) in enumerate(zip(rows[1:], others[1:], strict=True), start=2)
        for name, cell, other in zip_longest(rows[0], row, beside, fillvalue="")
        if cell != other
    ] or [f"{path} is written otherwise than labbook writes it."]


def _numbers_that_differ(given: bytes, anew: bytes) -> list[str]:
    """Name the numbers of a report that do not come out as it has them, and by how much."""
    try:
        printed = msgspec.json.decode(given, type=ReportNumbers)
    except (msgspec.DecodeError, msgspec.ValidationError, UnicodeDecodeError) as error:
        return [f"{REPORT}/{NUMBERS} cannot be read ({error}): {ASK_AGAIN}."]
    now = msgspec.json.decode(anew, type=ReportNumbers)
    found: list[str] = []
    for number in printed.numbers.values():
        again = number_anew(now.numbers, number)
        if again is None:
            found.append(f"{_called(number)} is {number.value!r}, and does not come out of these files.")
            continue
        names = differing_fields(number, again)
        if names:
            found.append(f"{_called(number)}: {'; '.join(_pair(number, again, name) for name in names)}.")
    paths = {number.path for number in printed.numbers.values()}
    found += [
        f"{_called(number)} comes out as {number.value!r}, and the report does not have it."
        for number in now.numbers.values()
        if number.path not in paths
    ]
    return found or [f"{REPORT}/{NUMBERS}: the numbers come out the same, and rest on other inputs than it says."]


def _called(number: ReportedNumber) -> str:
    return f"number {number.id} ({number.name} of {number.about})"


def _pair(printed: ReportedNumber, anew: ReportedNumber, name: str) -> str:
    was, now = getattr(printed, name), getattr(anew, name)
    return f"{name.replace('_', ' ')} is {was!r} and comes out as {now!r}{_by_how_much(was, now)}"


def _by_how_much(given: object, anew: object) -> str:
    """Say by how much two numbers differ; "" of what are none."""
    try:
        one, other = float(given), float(anew)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return ""
    part = abs(one - other) / max(abs(one), abs(other)) if one != other else 0.0
    rounding = ", as another processor or library rounds" if part <= ROUNDING else ""
    return f", a difference of {one - other:.3g} ({100 * part:.2g} %){rounding}"


OWN_PAGES = ("report.html", "summary.html")
"""What a lab's own templates make."""


def _compare_pages(capsule: _Unpacked, results: StudyResults, *, own_page: bool) -> None:
    """Compare the report's pages and tables with those made anew, around the figures that the capsule has.

    A page of a lab's own is compared with the journal's hash alone, as figures and tables for Word are.
    """
    found = capsule.found
    given = {path.removeprefix(_OF_REPORT): capsule.bytes_of(path) for path in capsule.below(REPORT)}
    if PAGE not in given:
        return
    page = given[PAGE].decode(errors="replace")
    made_with = [f"labbook {results.software_version}", *(f"{name} {version}" for name, version in results.software)]
    others = [software for software in made_with if software not in page]
    if others:
        found.remarks.append(
            f"the report's pages were not compared, for they were written without {' and '.join(others)}, which made "
            "those that they would be compared with."
        )
        return
    drawn = {name: data for name, data in given.items() if name.startswith("figures/")}
    try:
        anew = files_beside_figures(results, drawn, summary="summary.html" in given)
    except (KeyError, ValueError) as error:
        found.differences.append(f"a figure of the report is missing, or no drawing ({error}).")
        return
    if own_page:
        found.remarks.append("the report's page is of the lab's own: its numbers were compared, its words were not.")
        anew = {name: given.get(name, data) if name in OWN_PAGES else data for name, data in anew.items()}
    differing = [
        f"{_OF_REPORT}{name} is not the page or table that comes out anew: {_first_line(data, anew[name])}."
        for name, data in given.items()
        if name in anew and data != anew[name]
    ]
    here, expected, known = (
        [f"{_OF_REPORT}{name}" for name in names] for names in (given, anew, (*drawn, NUMBERS, WORD))
    )
    differing += _other_files(here, expected, "this report has", known)
    found.add(differing, "pages and tables that differ")


def _compare_samples(capsule: _Unpacked, samples: Mapping[str, str], again: Store) -> None:
    """Compare the files of samples with those that the raw copies gave: their bytes, or else what they hold."""
    members, folder = capsule.members, capsule.folder
    differing = _other_files(capsule.below("signals"), samples, "the raw files give")
    for path, sha256 in samples.items():
        if path not in members or members[path].sha256 == member(path, again.root / path).sha256:
            continue
        try:
            if not _same_shape(folder / path, again.root / path):
                raise BookDamaged("other columns or rows")
            Store(folder).check_samples(path, sha256, "the capsule")
        except BookDamaged:
            differing.append(f"{path} does not hold the samples that its raw file gives.")
    capsule.found.add(differing, "files of samples that differ")


def _same_shape(path: Path, other: Path) -> bool:
    """Tell whether two Parquet files state the same rows and columns, before one from others is read as a whole."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    try:
        one, beside = pq.read_metadata(path), pq.read_metadata(other)
    except (OSError, pa.ArrowException):
        return False
    return bool(one.num_rows == beside.num_rows and one.num_columns == beside.num_columns)
