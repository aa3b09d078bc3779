"""Large files: 100 MB against the libraries underneath, the peak of memory of 1 GB, and C3D against ezc3d."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv

from benchmarks.inputs import full_log, ingest_anew, new_book
from benchmarks.processes import LABBOOK, run_process
from benchmarks.section import Benchmark, Budget, Section, Table
from benchmarks.timing import Work, in_turns
from ingest.model import Declarations
from ingest.read import read_file
from labbook.demo.logger import DECIMALS
from labbook.demo.writers import string_pot_log

REPEATS = 5
OF_LIBRARIES, MOST_MB, OF_EZC3D = 2.5, 1000.0, 0.8
C3D_FRAMES = 60_000


def measure(say: Callable[[str], None]) -> Section:
    """Time 100 MB and a C3D file in turns with what reads them underneath; take in 1 GB in a process of its own."""
    with tempfile.TemporaryDirectory(prefix="labbook-bench-") as name:
        folder = Path(name)
        say(f"{REPEATS} rounds of 100 MB")
        path = folder / "log.csv"
        n_bytes = write_log(path, 100_000_000)
        times = in_turns({**_libraries(path), "labbook ingest": ingest_anew(path)}, REPEATS)
        least = sum(times[part].cpu_minimum for part in ("pyarrow.csv", "SHA-256"))
        say("1 GB in a process of its own")
        large_bytes = write_log(path, 1_000_000_000)
        peak_mb = _peak_mb(path)
        say(f"{REPEATS} rounds of C3D")
        c3d = in_turns(_c3d(folder / "trial.c3d"), REPEATS)
    ratio = c3d["ezc3d"].cpu_minimum / c3d["labbook reads C3D"].cpu_minimum
    rows = tuple((name, f"{found.cpu_minimum:.2f}", f"{found.minimum:.2f}") for name, found in {**times, **c3d}.items())
    return Section(
        "Large files",
        f"The 12-minute log over and over, its clock counted on: {n_bytes / 1e6:.0f} MB ingested into a new book, "
        "against `pyarrow.csv.read_csv` with its defaults and one SHA-256 of the bytes, by processor time; and "
        f"{large_bytes / 1e6:.0f} MB ingested in a process of its own, by its high-water mark of resident memory. "
        f"The C3D file holds one force platform, {C3D_FRAMES} frames: read and checked, against `ezc3d.c3d` of "
        "the file alone.",
        (
            Budget("100 MB over pyarrow.csv + SHA-256 (processor time)", OF_LIBRARIES, "×",
                   times["labbook ingest"].cpu_minimum / least),
            Budget("peak memory of ingesting 1 GB", MOST_MB, "MB", peak_mb),
            Budget("ezc3d over reading C3D (processor time)", OF_EZC3D, "×", ratio, at_least=True),
        ),
        (Table(("", "processor time, s", "wall time, s"), rows, "The least of the repeats."),),
    )  # fmt: skip


def write_log(path: Path, n_bytes: int) -> int:
    """Write a log of at least `n_bytes`, a 12-minute log again and again; returns its size."""
    log = full_log()
    span_ms = int(log.time_ms[-1] - log.time_ms[0]) + 3
    turns = 0
    with path.open("wb") as target:
        while target.tell() < n_bytes:
            text = string_pot_log(log.time_ms + turns * span_ms, log.channels, DECIMALS)
            target.write(text if turns == 0 else text[text.index(b"\n") + 1 :])
            turns += 1
        return target.tell()


def _libraries(path: Path) -> dict[str, Work]:
    data = path.read_bytes()
    return {
        "pyarrow.csv": Work(lambda _: pyarrow.csv.read_csv(pa.BufferReader(data))),
        "SHA-256": Work(lambda _: hashlib.sha256(data).hexdigest()),
    }


def _peak_mb(path: Path) -> float | None:
    book = new_book(path.parent / "alone")
    return run_process([LABBOOK, "ingest", path, "--book", book]).peak_mb


def _c3d(path: Path) -> dict[str, Work]:
    import ezc3d

    _write_c3d(path)
    data = path.read_bytes()
    return {
        "ezc3d": Work(lambda _: ezc3d.c3d(str(path))["data"]["analogs"]),
        "labbook reads C3D": Work(lambda _: read_file(data, Declarations())),
    }


def _write_c3d(path: Path) -> None:
    """Write one platform of type 2 that is pressed now and then."""
    import ezc3d

    load_n = 40.0 * (np.arange(C3D_FRAMES) % 1000 < 400)
    noise = np.random.default_rng(1).normal(0.0, 0.5, (6, C3D_FRAMES))
    trial = ezc3d.c3d()
    trial["data"]["analogs"] = (noise + np.outer((0.0, 0.0, -1.0, -20.0, 30.0, 0.0), load_n))[np.newaxis]
    trial["data"]["points"] = np.ones((4, 1, C3D_FRAMES))
    trial["parameters"]["POINT"]["LABELS"]["value"] = ["FOOT"]
    trial["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
    trial["parameters"]["POINT"]["RATE"]["value"] = [1000.0]
    trial["parameters"]["ANALOG"]["RATE"]["value"] = [1000.0]
    trial["parameters"]["ANALOG"]["LABELS"]["value"] = ["Fx1", "Fy1", "Fz1", "Mx1", "My1", "Mz1"]
    trial["parameters"]["ANALOG"]["UNITS"]["value"] = ["N", "N", "N", "Nmm", "Nmm", "Nmm"]
    corners = np.array([[300.0, 300.0, -300.0, -300.0], [200.0, -200.0, -200.0, 200.0], [0.0] * 4])
    for name, value in (
        ("USED", [1]),
        ("TYPE", [2]),
        ("CORNERS", corners[:, :, np.newaxis]),
        ("ORIGIN", np.array([[0.0], [0.0], [-20.0]])),
        ("CHANNEL", np.arange(1.0, 7.0)[:, np.newaxis]),
        ("ZERO", [1, 0]),
    ):
        trial.add_parameter("FORCE_PLATFORM", name, value)
    trial.write(str(path))


BENCHMARK = Benchmark("large_files", measure)
