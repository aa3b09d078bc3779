"""Simulates every method on every design: `docs/statistics/error_rates.csv`, and of it what reports look up.

python benchmarks/stats_evidence/sizes/record.py [METHOD...]

With names only those methods are simulated where shares are lacking. Shares that are there already are not simulated
again: empty a cell (or remove the file) to have it made anew. Stopped and started again it goes on where it was.
"""

from __future__ import annotations

import csv
import sys
import time
from collections.abc import Iterable, Sequence
from pathlib import Path

from benchmarks.stats_evidence.sizes.design import Design
from benchmarks.stats_evidence.sizes.method import Method, seed_of, simulated
from benchmarks.stats_evidence.sizes.registry import METHODS
from labbook.presenting.report.day_layout import MOSTLY, OWN, PARTLY, SHARED
from labbook.presenting.report.error_rates import NAMES
from stats.planning.recorded import DESIGN, FILE, WITH_LINE, Recorded, read

EVERY_RATE = Path(__file__).resolve().parents[3] / "docs" / "statistics" / "error_rates.csv"
LOOKED_UP = Path(str(FILE))
BETWEEN_WRITES_S = 5.0


def every_rate(path: Path = EVERY_RATE) -> list[Recorded]:
    """Return all that is simulated, in the order of the file; nothing where there is no file."""
    return list(read(path.read_text(encoding="utf-8"))) if path.is_file() else []


def design_of(row: Recorded) -> Design:
    """Return the design that a share was simulated on."""
    return Design(row.n, row.sd_ratio, row.days, row.day_sd, row.layout, row.distribution)


def filled(method: Method, design: Design) -> Recorded:
    """Return the share of a method on a design, simulated."""
    value = simulated(method, design, method.runs, seed_of(method, design))
    return Recorded(
        method=method.name,
        kind=method.kind,
        n=design.n,
        value=value,
        runs=method.runs,
        sd_ratio=design.sd_ratio,
        days=design.days,
        day_sd=design.day_sd,
        layout=design.layout,
        distribution=design.distribution,
    )


def looked_up(rows: Iterable[Recorded]) -> list[Recorded]:
    """Return what reports look up: their methods, on normal values, at the standard deviations that are worst.

    Tests of two means are asked for two groups, the analysis of variance for more, drains for one line.
    """
    worst: dict[tuple[object, ...], Recorded] = {}
    for row in rows:
        by_day = row.method.startswith("blocked_by_day")
        layouts = (SHARED, OWN, PARTLY, MOSTLY) if by_day else ("", OWN, PARTLY, MOSTLY)
        if (
            row.method.removesuffix(WITH_LINE) in NAMES
            and (len(row.groups) <= 2 or row.method == "one_way_anova")
            and row.layout in layouts
            and row.distribution == "normal"
        ):
            cell = (row.method, row.n, row.days, row.layout)
            worst[cell] = max(worst.get(cell, row), row, key=lambda row: (row.weak, row.excess))
    chosen = set(worst.values())
    return [row for row in rows if row in chosen]


def write(path: Path, rows: Sequence[Recorded]) -> None:
    """Write a table of designs and methods, whole or not at all; methods in the order of the registry."""
    heads = {method.name: f"{method.kind}_{method.name}" for method in METHODS}
    there = {row.method for row in rows}
    columns = [*DESIGN, *(head for name, head in heads.items() if name in there)]
    by_design: dict[tuple[Design, int], dict[str, str]] = {}
    for row in rows:
        design = {
            "n": " ".join(map(str, row.n)),
            "sd_ratio": f"{row.sd_ratio:g}",
            "days": "" if row.days is None else str(row.days),
            "day_sd": "" if row.day_sd is None else f"{row.day_sd:g}",
            "layout": row.layout,
            "distribution": row.distribution,
            "runs": str(row.runs),
        }
        by_design.setdefault((design_of(row), row.runs), design)[heads[row.method]] = repr(row.value)
    path.parent.mkdir(exist_ok=True)
    beside = path.with_suffix(".part")
    with beside.open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, columns, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(by_design.values())
    beside.replace(path)


def main(names: list[str], every: Path = EVERY_RATE, short: Path = LOOKED_UP) -> None:
    """Simulate what is lacking, then write both tables; methods and designs that are no longer there go."""
    unknown = sorted(set(names) - {method.name for method in METHODS})
    if unknown:
        sys.exit(f"there is no method {unknown[0]!r}: there are {', '.join(dict.fromkeys(m.name for m in METHODS))}.")
    there = {(row.method, design_of(row)): row for row in every_rate(every)}
    due = {(method.name, design): method for method in METHODS for design in method.designs}
    lacking = [key for key in due if key not in there and (not names or key[0] in names)]
    written = time.monotonic()
    for count, (name, design) in enumerate(lacking, 1):
        row = there[name, design] = filled(due[name, design], design)
        if time.monotonic() > written + BETWEEN_WRITES_S:
            write(every, [there[key] for key in due if key in there])
            written = time.monotonic()
        print(f"{count} of {len(lacking)}: {name} {design}: {row.value:g}", flush=True)
    rows = [there[key] for key in due if key in there]
    write(every, rows)
    write(short, looked_up(rows))


if __name__ == "__main__":
    main(sys.argv[1:])
