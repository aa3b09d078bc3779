"""Ingest of one 12-minute log, against the sum of its parts and against pandas into SQLite."""

from __future__ import annotations

import hashlib
import io
import sqlite3
import tempfile
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pandas as pd
import pyarrow as pa
import pyarrow.csv
import pyarrow.parquet

from benchmarks.inputs import big_log, ingest_anew
from benchmarks.section import Benchmark, Budget, Section, Table, milliseconds, times_table
from benchmarks.timing import Work, in_turns, together
from ingest.store import RAW_COMPRESSION_LEVEL

REPEATS = 9
OF_PARTS, OF_PANDAS = 1.6, 2.0
PARTS = ("read with pyarrow.csv", "SHA-256", "zstd of the bytes", "Parquet of the columns")


def measure(say: Callable[[str], None]) -> Section:
    """Time the ingest, each of its parts, and pandas, in turns."""
    data = big_log()
    with tempfile.TemporaryDirectory(prefix="labbook-bench-") as name:
        folder = Path(name)
        path = folder / "log.csv"
        path.write_bytes(data)
        say(f"{REPEATS} rounds of ingest, its parts and pandas, {len(data) / 1e6:.1f} MB")
        times = in_turns({**_parts(data), "labbook": ingest_anew(path), "pandas": _pandas(path)}, REPEATS)
    parts = [times[part] for part in PARTS]
    whole = together(parts)
    least = sum(part.minimum for part in parts)
    of_parts = times["labbook"].minimum / least
    of_pandas = times["pandas"].minimum / times["labbook"].minimum
    rows = {**{part: times[part] for part in PARTS}, "sum of the parts": whole, "labbook ingest": times["labbook"],
            "pandas read_csv + to_sql": times["pandas"]}  # fmt: skip
    return Section(
        "Ingest of a 12-minute log",
        f"A log of 12 minutes at 300 Hz, time and 8 channels, half of them noisy to the sixth decimal and half held "
        f"({len(data) / 1e6:.1f} MB), through `ingest_file` into a new book: read, checked, hashed, "
        "copied, its samples stored, its jumps found, rows and journal committed, every file synced to the disk. The "
        "parts are done one after the other and in memory: `pyarrow.csv.read_csv` with its defaults, one SHA-256, "
        f"zstd level {RAW_COMPRESSION_LEVEL} of the bytes (the level of the store), Parquet with zstd and pyarrow's "
        "defaults. pandas reads with `read_csv` and writes a SQLite table with `to_sql`; it keeps neither the bytes "
        "nor a hash.",
        (
            Budget("ingest over the sum of its parts (sum of minima)", OF_PARTS, "×", of_parts),
            Budget("pandas `read_csv` + `to_sql` over ingest (minima)", OF_PANDAS, "×", of_pandas, at_least=True),
        ),
        (
            times_table(
                rows,
                "sum of the parts",
                f"The medians give {times['labbook'].median / whole.median:.2f} times the parts and pandas "
                f"{times['pandas'].median / times['labbook'].median:.1f} times the ingest. Of processor time "
                f"ingest takes {times['labbook'].cpu_minimum / whole.cpu_minimum:.2f} times the parts: it works on two "
                "threads, so its wall time suffers more than that of the parts where other programs keep the cores "
                "busy. The last column is a ratio of minima; the sum's minimum is that of a whole round, a little "
                "above the sum of minima that the budget uses.",
            ),
            _levels(data, say),
        ),
    )


def _parts(data: bytes) -> dict[str, Work]:
    table = pyarrow.csv.read_csv(pa.BufferReader(data))
    codec = pa.Codec("zstd", compression_level=RAW_COMPRESSION_LEVEL)
    works: tuple[Callable[[object], object], ...] = (
        lambda _: pyarrow.csv.read_csv(pa.BufferReader(data)),
        lambda _: hashlib.sha256(data).hexdigest(),
        lambda _: codec.compress(data),
        lambda _: pyarrow.parquet.write_table(table, io.BytesIO(), compression="zstd"),
    )
    return {name: Work(work) for name, work in zip(PARTS, works, strict=True)}


def _pandas(path: Path) -> Work:
    target = path.with_name("pandas.db")

    def run(_: object) -> None:
        with closing(sqlite3.connect(target)) as connection:
            pd.read_csv(path).to_sql("log", connection, index=False)

    return Work(run, clear=lambda _: target.unlink())


def _levels(data: bytes, say: Callable[[str], None]) -> Table:
    """Show why the raw copy is compressed at the level it is."""
    say("zstd levels")
    codecs = {f"level {level}": pa.Codec("zstd", compression_level=level) for level in (1, 3, 9)}
    works = {name: Work(codec.compress, lambda: data) for name, codec in codecs.items()}
    times = in_turns(works, 5)
    sizes = {name: len(codec.compress(data)) / len(data) for name, codec in codecs.items()}
    first = f"level {RAW_COMPRESSION_LEVEL}"
    return Table(
        ("zstd", "min, ms", "size over the text's"),
        tuple((name, milliseconds(times[name].minimum), f"{sizes[name]:.3f}") for name in codecs),
        f"The raw copy takes {first}: level 3 costs {times['level 3'].minimum / times[first].minimum:.1f} times as "
        f"much for a copy {abs(1 - sizes['level 3'] / sizes[first]) * 100:.0f} % "
        f"{'smaller' if sizes['level 3'] < sizes[first] else 'larger'}.",
    )


BENCHMARK = Benchmark("ingest_log", measure)
