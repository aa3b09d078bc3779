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
from ingest.read import read_file
from ingest.store import Store, signal_sha256
from labbook.analysis.detecting import detect_part
from labbook.book import Book, open_book
from labbook.importing import PreparedImport, declarations, read_and_store
from labbook.ingesting import IngestRequest, ingest_file

REPEATS = 7


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
    whole = times["the whole ingest"].minimum
    stages = sum(found.minimum for name, found in times.items() if name != "the whole ingest")
    rows = tuple(
        (name, milliseconds(found.minimum), milliseconds(found.median), f"{100 * found.minimum / whole:.0f} %")
        for name, found in times.items()
    )
    shows = (
        f"Done one after the other the stages take {stages / whole:.2f} times the whole: the raw copy, the samples and "
        "the jumps of one file are made side by side. Reading and checking is the largest stage; what the database and "
        "the journal take is independent of the file's length."
    )
    return Section(
        "Where the time of an ingest goes",
        "The same log as above; each stage alone, one after the other, with the functions that the ingest calls.",
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

    def fresh() -> tuple[Book, PreparedImport]:
        opened = open_book(new_book(folder / "fresh"))
        return opened, read_and_store(opened.store, data, sha256, opened.configuration, {})

    def clear_book(opened: Book) -> None:
        opened.close()
        shutil.rmtree(opened.folder)

    return {
        "read the bytes": Work(lambda _: path.read_bytes()),
        "SHA-256 of the bytes": Work(lambda _: hashlib.sha256(data).hexdigest()),
        "read and check the table": Work(lambda _: read_file(data, declared)),
        "compress, write and sync the raw copy": Work(
            lambda store: store.put_raw(data, sha256), new_store, clear_store
        ),
        "SHA-256 of the samples": Work(lambda _: [signal_sha256(part) for part in read.parts]),
        "hash, write and sync the samples": Work(
            lambda store: [store.put_signal(part) for part in read.parts], new_store, clear_store
        ),
        "find the jumps": Work(lambda _: [detect_part(part, book.configuration) for part in read.parts]),
        "the whole ingest": Work(
            lambda opened: ingest_file(opened, path, IngestRequest()),
            lambda: open_book(new_book(folder / "fresh")),
            clear_book,
        ),
    }


BENCHMARK = Benchmark("ingest_stages", measure)
