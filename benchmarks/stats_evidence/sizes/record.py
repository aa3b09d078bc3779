"""Simulates every method on every design and writes `stats/recorded.csv`.

python benchmarks/stats_evidence/sizes/record.py [METHOD...]

With names only those methods are simulated anew where rows are lacking; all else is kept. Rows that are there already
are not simulated again: remove a row (or the file) to have it made anew. Stopped and started again it goes on where it
was.
"""

from __future__ import annotations

import csv
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from benchmarks.stats_evidence.sizes.design import Design
from benchmarks.stats_evidence.sizes.method import Method, seed_of, simulated, standard_error
from benchmarks.stats_evidence.sizes.registry import METHODS
from stats.planning.recorded import COLUMNS, FILE, Recorded

Row = dict[str, str]
BETWEEN_WRITES_S = 5.0


def row_of(method: Method, design: Design) -> Row:
    """Return what stands in the record before anything is simulated."""
    return {
        "method": method.name,
        "kind": method.kind,
        "n": " ".join(map(str, design.n)),
        "sd_ratio": f"{design.sd_ratio:g}",
        "days": "" if design.days is None else str(design.days),
        "day_sd": "" if design.day_sd is None else f"{design.day_sd:g}",
        "layout": design.layout,
        "distribution": design.distribution,
        "nominal": f"{method.nominal:g}",
    }


def design_of(row: Recorded) -> Design:
    """Return the design that a row was simulated on."""
    return Design(row.n, row.sd_ratio, row.days, row.day_sd, row.layout, row.distribution)


def key_of(row: Row) -> tuple[str, ...]:
    """Return what tells rows apart."""
    return tuple(row[name] for name in COLUMNS[: COLUMNS.index("nominal") + 1])


def filled(method: Method, design: Design) -> Row:
    """Return a row of the record, simulated."""
    seed = seed_of(method, design)
    value = simulated(method, design, method.runs, seed)
    return row_of(method, design) | {
        "value": repr(value),
        "standard_error": f"{standard_error(value, method.runs):.2g}",
        "runs": str(method.runs),
        "seed": str(seed),
    }


def read(path: Path) -> dict[tuple[str, ...], Row]:
    """Return the rows that are there."""
    if not path.is_file():
        return {}
    with path.open(encoding="utf-8", newline="") as file:
        return {key_of(row): row for row in csv.DictReader(file)}


def write(path: Path, rows: Sequence[Row]) -> None:
    """Write all rows, whole or not at all."""
    beside = path.with_suffix(".part")
    with beside.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    beside.replace(path)


def main(names: list[str], path: Path) -> None:
    """Simulate what is lacking; rows of methods or designs that are no longer there go."""
    unknown = sorted(set(names) - {method.name for method in METHODS})
    if unknown:
        sys.exit(f"there is no method {unknown[0]!r}: there are {', '.join(dict.fromkeys(m.name for m in METHODS))}.")
    there = read(path)
    due = [(method, design) for method in METHODS for design in method.designs]
    keys = [key_of(row_of(method, design)) for method, design in due]
    lacking = [
        pair for pair, key in zip(due, keys, strict=True) if key not in there and (not names or pair[0].name in names)
    ]
    written = time.monotonic()
    for count, (method, design) in enumerate(lacking, 1):
        row = filled(method, design)
        there[key_of(row)] = row
        if time.monotonic() > written + BETWEEN_WRITES_S:
            write(path, [there[key] for key in keys if key in there])
            written = time.monotonic()
        print(f"{count} of {len(lacking)}: {method.name} {design}: {row['value']}", flush=True)
    write(path, [there[key] for key in keys if key in there])


if __name__ == "__main__":
    main(sys.argv[1:], Path(str(FILE)))
