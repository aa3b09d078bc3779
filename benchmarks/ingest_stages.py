"""Where the time of an ingest goes."""

from __future__ import annotations

import hashlib
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

from benchmarks.inputs import big_log, new_book
from benchmarks.section import Benchmark, Section, Table, milliseconds
from benchmarks.timing import Work, in_turns
from data_schema.vocabulary import Action
from ingest.read import read_file
from ingest.samples import signal_sha256
from ingest.store import Store
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.analysis.outcomes.detection import detect_part
from labbook.book.opening import Book, open_book
from labbook.book.write_session import Statement, new_uid
from labbook.statements.importing import PreparedImport, current_settings, declarations, store_reading

REPEATS = 7
WHOLE = "the whole ingest"
PART_OF = {"of which SHA-256 of the samples"}
"""Stages that are counted in another one."""


def measure(say: Callable[[str], None]) -> Section:
    """Time every stage of one ingest alone, and the whole."""
    say(f"{REPEATS} rounds of each stage")
    data = big_log()
    with tempfile.TemporaryDirectory(prefix="labbook-bench-") as name:
        folder = Path(name)
        path = folder / "log.csv"
        path.write_bytes(data)
        book = open_book(new_book(folder / "settled"))
        try:
            times = in_turns(_stages(book, path, data), REPEATS)
        finally:
            book.close()
    whole = times[WHOLE].minimum
    alone = {name: found.minimum for name, found in times.items() if name != WHOLE and name not in PART_OF}
    largest = max(alone, key=lambda name: alone[name])
    rows = tuple(
        (name, milliseconds(found.minimum), milliseconds(found.median), f"{100 * found.minimum / whole:.0f} %")
        for name, found in times.items()
    )
    shows = (
        f"The largest stage is to {largest}. One after the other the stages take {sum(alone.values()) / whole:.2f} "
        "times the whole, because the raw copy, the samples and the jumps of one file are made side by side on two "
        "threads; reading comes before them, and the rows after."
    )
    return Section(
        "Where the time of an ingest goes",
        "The same log; each stage alone, with the functions that the ingest calls.",
        (),
        (Table(("stage", "min, ms", "median, ms", "share of the whole"), rows, shows),),
    )


def _stages(book: Book, path: Path, data: bytes) -> dict[str, Work]:
    declared = declarations(book.configuration, {})
    read = read_file(data, declared)
    sha256 = hashlib.sha256(data).hexdigest()
    folder = path.parent

    def new_store() -> Store:
        return Store(folder / "store")

    def clear_store(store: Store) -> None:
        shutil.rmtree(store.root)

    def clear_book(opened: Book) -> None:
        opened.close()
        shutil.rmtree(opened.folder)

    settings = current_settings(book.configuration, {})

    def prepared() -> tuple[Book, PreparedImport]:
        opened = open_book(new_book(folder / "fresh"))
        settings = current_settings(opened.configuration, {})
        return opened, store_reading(opened.store, data, sha256, read_file(data, settings.declared), settings)

    return {
        "read the bytes": Work(lambda _: path.read_bytes()),
        "hash the bytes (SHA-256)": Work(lambda _: hashlib.sha256(data).hexdigest()),
        "read and check the table": Work(lambda _: read_file(data, declared)),
        "compress, write and sync the raw copy": Work(
            lambda store: store.put_raw(data, sha256), new_store, clear_store
        ),
        "hash, compress, write and sync the samples": Work(
            lambda store: [store.put_signal(part) for part in read.parts], new_store, clear_store
        ),
        "of which SHA-256 of the samples": Work(lambda _: [signal_sha256(part) for part in read.parts]),
        "find the jumps": Work(
            lambda _: [detect_part(part, settings.detector, settings.rest_length_m) for part in read.parts]
        ),
        "write rows and journal, commit": Work(
            lambda pair: _state(pair[0], path, pair[1]), prepared, lambda pair: clear_book(pair[0])
        ),
        WHOLE: Work(
            lambda opened: ingest_file(opened, path, IngestRequest()),
            lambda: open_book(new_book(folder / "fresh")),
            clear_book,
        ),
    }


def _state(book: Book, path: Path, prepared: PreparedImport) -> None:
    new = {
        "sha256": prepared.sha256,
        "n_bytes": prepared.n_bytes,
        "original_name": path.name,
        "modified_utc": None,
        "options": {},
        "stated_run": None,
        "run": None,
    }
    with book.session(None) as session:
        session.state(Statement(Action.INGEST, "ingest", new_uid(), new=new, prepared=prepared))


BENCHMARK = Benchmark("ingest_stages", measure)
