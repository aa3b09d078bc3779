"""Many small files: how many a second."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

from benchmarks.inputs import new_book, small_logs
from benchmarks.section import Benchmark, Section, Table
from benchmarks.timing import Work, in_turns
from data_schema.disk import sync
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.book.opening import opened

FILES, SAMPLES = 200, 300
REPEATS = 3


def measure(say: Callable[[str], None]) -> Section:
    """Ingest the same small files into new books, and copy them with a sync each."""
    with tempfile.TemporaryDirectory(prefix="labbook-bench-") as name:
        folder = Path(name)
        paths = []
        for number, data in enumerate(small_logs(FILES, SAMPLES)):
            paths.append(folder / f"log_{number:03d}.csv")
            paths[-1].write_bytes(data)
        say(f"{REPEATS} rounds of {FILES} files")
        times = in_turns({"ingested": _ingest(paths, folder), "copied and synced": _copy(paths, folder)}, REPEATS)
        size = sum(path.stat().st_size for path in paths) / FILES
    rows = tuple(
        (name, f"{FILES / found.minimum:.0f}", f"{found.minimum / FILES * 1e3:.2f}") for name, found in times.items()
    )
    ratio = times["ingested"].minimum / times["copied and synced"].minimum
    return Section(
        "Many small files",
        f"{FILES} logs of {SAMPLES} samples ({size / 1e3:.0f} kB) ingested one by one into a new book: each is one "
        "transaction with its raw copy, its samples and the journal synced before the commit. The peer copies each "
        "file and syncs it and its folder, once.",
        (),
        (
            Table(
                ("", "files a second", "ms a file (min)"),
                rows,
                f"An ingested file costs {ratio:.0f} times a synced copy. The syncs are the price of losing nothing at "
                "a power cut, and most of the time where a disk takes long to sync; where it does not, as here, the "
                "time is recognising the file and its columns, and the rows.",
            ),
        ),
    )


def _ingest(paths: list[Path], folder: Path) -> Work:
    def run(book_folder: Path) -> None:
        with opened(book_folder) as book:
            for path in paths:
                ingest_file(book, path, IngestRequest())

    return Work(run, lambda: new_book(folder / "book"), shutil.rmtree)


def _copy(paths: list[Path], folder: Path) -> Work:
    target = folder / "copies"

    def run(_: object) -> None:
        for path in paths:
            with (target / path.name).open("wb") as handle:
                handle.write(path.read_bytes())
                handle.flush()
                os.fsync(handle.fileno())
            sync(target)

    return Work(run, target.mkdir, lambda _: shutil.rmtree(target))


BENCHMARK = Benchmark("small_files", measure)
