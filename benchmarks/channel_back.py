"""Reading one channel of a 12-minute log back, and what raw copy and samples take on disk."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from benchmarks.inputs import big_log, new_book
from benchmarks.section import Benchmark, Budget, Section, Table, milliseconds, times_table
from benchmarks.timing import Times, Work, in_turns
from ingest.model import Declarations
from ingest.read import read_file
from ingest.store import Store, raw_path, write_samples
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.analysis.outcomes.detection import BODY_HEIGHT
from labbook.book.opening import opened

REPEATS = 25
READ_BACK_MS = 15.0
SHARE_OF_TEXT = 0.65
STORED, USUAL, SPLIT = (
    "as stored: each column in its own way",
    "dictionary for all (pyarrow's default)",
    "bytes split for all",
)
ONE, ALL, BARE = "labbook: one channel", "labbook: all 8", "pyarrow: one channel"


def measure(say: Callable[[str], None]) -> Section:
    """Ingest once, read one channel many times, weigh what lies on disk."""
    data = big_log()
    with tempfile.TemporaryDirectory(prefix="labbook-bench-") as name:
        folder = Path(name)
        (folder / "log.csv").write_bytes(data)
        with opened(new_book(folder / "book")) as book:
            prepared = ingest_file(book, folder / "log.csv", IngestRequest()).prepared
            assert prepared is not None, "a log was refused that the benchmark wrote"
            (part,) = prepared.parts
            say(f"{REPEATS} rounds of reading one channel back")
            times = in_turns(_readers(book.store, part.store_path), REPEATS)
            raw, samples = (
                (book.store.root / path).stat().st_size for path in (raw_path(prepared.sha256), part.store_path)
            )
            tables = (
                times_table(times, ONE, _reading_shows(times)),
                _weights(len(data), raw, samples),
                _encodings(data, say),
            )
    return Section(
        "Reading back, and what it takes on disk",
        "The same log, after its ingest: `Store.samples` for one channel, against `pyarrow.parquet.read_table` of the "
        "same two columns; the sizes of the files in the store.",
        (
            Budget("one channel read back (min)", READ_BACK_MS, "ms", times[ONE].minimum * 1e3),
            Budget("raw copy and samples over the raw text", SHARE_OF_TEXT, "×", (raw + samples) / len(data)),
        ),
        tables,
    )


def _readers(store: Store, path: str) -> dict[str, Work]:
    columns = pq.read_schema(store.root / path).names
    pair = [column for column in columns if column.startswith((BODY_HEIGHT, "time"))]
    names = [column.rsplit(" [", 1)[0] for column in columns]
    return {
        ONE: Work(lambda _: store.samples(path, [BODY_HEIGHT])),
        ALL: Work(lambda _: store.samples(path, names)),
        BARE: Work(lambda _: pq.read_table(store.root / path, columns=pair)),
    }


def _reading_shows(times: dict[str, Times]) -> str:
    one, whole, bare = (times[name].minimum for name in (ONE, ALL, BARE))
    return (
        "Time is read with every channel. The store opens the file, looks the channel up by its name and hands out "
        f"arrays, in {one / bare:.2f} times what pyarrow's own reader takes; all channels take {whole / one:.1f} times "
        "as long as one."
    )


def _weights(text: int, raw: int, samples: int) -> Table:
    rows = (("raw text", text), ("raw copy", raw), ("samples", samples), ("raw copy and samples", raw + samples))
    return Table(
        ("", "MB", "over the raw text"),
        tuple((name, f"{size / 1e6:.2f}", f"{size / text:.3f}") for name, size in rows),
        f"A book that keeps every byte and every sample is {100 * (1 - (raw + samples) / text):.0f} % smaller than the "
        "text alone.",
    )


def _encodings(data: bytes, say: Callable[[str], None]) -> Table:
    """Show why each column is encoded in its own way."""
    say("Parquet encodings")
    (part,) = read_file(data, Declarations()).parts
    table = pa.table({"time": part.time_s, **{channel.name: channel.values for channel in part.channels}})
    ways: dict[str, Callable[[pa.BufferOutputStream], object]] = {
        STORED: lambda target: write_samples(part, target),
        USUAL: lambda target: pq.write_table(table, target, compression="zstd"),
        SPLIT: lambda target: pq.write_table(
            table, target, compression="zstd", use_dictionary=False, use_byte_stream_split=True
        ),
        "plain for all": lambda target: pq.write_table(table, target, compression="zstd", use_dictionary=False),
    }
    works = {name: Work(way, pa.BufferOutputStream) for name, way in ways.items()}
    times = in_turns(works, 5)
    sizes = {}
    for name, way in ways.items():
        target = pa.BufferOutputStream()
        way(target)
        sizes[name] = target.getvalue().size
    space = [sizes[STORED] / sizes[other] for other in (USUAL, SPLIT)]
    time = [times[STORED].minimum / times[other].minimum for other in (USUAL, SPLIT)]
    return Table(
        ("Parquet with zstd", "MB", "min, ms"),
        tuple((name, f"{size / 1e6:.2f}", milliseconds(times[name].minimum)) for name, size in sizes.items()),
        "Logged numbers have few decimals, so most values come again and a dictionary is shortest; time rises "
        "steadily, and its bytes split into streams almost vanish. Each column is looked at: what the store writes "
        f"takes {space[0]:.2f} times the space of pyarrow's default in {time[0]:.2f} times its time, and "
        f"{space[1]:.2f} times the space of splitting all in {time[1]:.2f} times its time.",
    )


BENCHMARK = Benchmark("channel_back", measure)
