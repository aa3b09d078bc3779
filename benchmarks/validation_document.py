"""Closed loop: simulated campaigns with a known truth, through a study's own sheet and analysis, and how often its
intervals cover. Writes the table of docs/validation.md anew.

python benchmarks/validation_document.py
"""

from __future__ import annotations

import datetime
import math
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import scipy.stats

from benchmarks.document import table_text
from benchmarks.section import Table
from data_schema.vocabulary import Undefined
from labbook.actions.studies.compaction import compaction_of
from labbook.actions.studies.field import field_study_of
from stats.groups.multiple import holm

DOCUMENT = Path(__file__).resolve().parent.parent / "docs" / "validation.md"
CAMPAIGNS, LEVEL, SEED = 2000, 0.95, 21
FIRST, LAST = "<!-- measured -->", "<!-- end of measured -->"
FLASK_RADII_MM, GRAIN_MM = (15.0, 20.0, 30.0, 45.0, 60.0), 3.4
LOOSE, COMPACTED, WALLS = 0.61, 0.63, (-0.25, -0.2)
"""Volume fractions without walls (thesis 5.1.2), and their change with grain size / flask radius (assumed)."""
THIN, WIDE = 1.3, 1.1
"""Specific resistance of two robots (thesis 2.2.3)."""

Intervals = Mapping[str, tuple[float, float] | Undefined]


@dataclass(frozen=True, slots=True)
class ClosedLoop:
    """A study: how a campaign's sheet is drawn, what the study says of it, and what is true."""

    what: str
    sheet: Callable[[np.random.Generator], str]
    intervals: Callable[[str], Intervals]
    truths: Mapping[str, float]


def flasks(chance: np.random.Generator, of_flask: float = 0.002, of_filling: float = 0.0015) -> str:
    """Draw a sheet of flasks with normal errors of their fractions: one of each flask, and one of each filling."""
    lines = ["radius_mm,state,water_ml"]
    for radius_mm in FLASK_RADII_MM:
        volume_ml, shared = 4.0 / 3.0 * math.pi * radius_mm**3 / 1e3, chance.normal(0.0, of_flask)
        for state, fraction, wall in zip(("loose", "compacted"), (LOOSE, COMPACTED), WALLS, strict=True):
            filled = fraction + wall * GRAIN_MM / radius_mm + shared + chance.normal(0.0, of_filling)
            lines.append(f"{radius_mm:g},{state},{volume_ml * (1.0 - filled):.9g}")
    return "\n".join(lines) + "\n"


def walks(chance: np.random.Generator) -> str:
    """Draw a sheet of four walks of which some are harder for both robots, and what either needs scatters by 3 %."""
    lines = ["walk,robot,mass_kg,distance_m,energy_Wh"]
    for walk in range(4):
        distance_m, hardness = chance.uniform(100.0, 600.0), chance.normal(0.0, 0.3)
        for robot, mass_kg, needed in (("thin", 8.1, THIN), ("wide", 8.3, WIDE)):
            scattered = needed * math.exp(hardness + chance.normal(0.0, 0.03))
            energy_wh = scattered * mass_kg * 9.80665 * distance_m / 3600.0
            lines.append(f"{walk},{robot},{mass_kg},{distance_m:.9g},{energy_wh:.9g}")
    return "\n".join(lines) + "\n"


def _of_flasks(text: str) -> Intervals:
    found = compaction_of(text, Path("flasks.csv"), GRAIN_MM, LEVEL, ".")
    by_state = {f"fraction, {state.name}": state.unbounded.ci for state in found.states}
    return {**by_state, "difference within flasks": found.rise.intervals()[0]}


def _of_walks(text: str) -> Intervals:
    return {"ratio within walks": field_study_of(text, Path("walks.csv"), LEVEL, ".").ratio_ci}


STUDIES = {
    "compaction": ClosedLoop(
        "five flasks, an error of 0.002 a flask and of 0.0015 a filling",
        flasks,
        _of_flasks,
        {
            "fraction, loose": LOOSE,
            "fraction, compacted": COMPACTED,
            "difference within flasks": COMPACTED - LOOSE,
        },
    ),
    "field": ClosedLoop(
        "four walks that differ by 30 %, robots that scatter by 3 %",
        walks,
        _of_walks,
        {"ratio within walks": WIDE / THIN},
    ),
}


def covered(study: ClosedLoop, campaigns: int, seed: int = SEED) -> dict[str, int]:
    """Count by quantity the campaigns whose interval covers what is true."""
    chance, counts = np.random.default_rng(seed), dict.fromkeys(study.truths, 0)
    for _ in range(campaigns):
        for name, interval in study.intervals(study.sheet(chance)).items():
            if not isinstance(interval, Undefined):
                counts[name] += interval[0] <= study.truths[name] <= interval[1]
    return counts


def outside(counts: Mapping[str, int], campaigns: int, band: float = 0.999) -> list[str]:
    """Return the quantities whose count lies outside the binomial band, by Holm over all."""
    ps = {name: float(scipy.stats.binomtest(count, campaigns, LEVEL).pvalue) for name, count in counts.items()}
    adjusted = holm(ps, "covers").adjusted_p
    return [name for name, p in zip(counts, adjusted, strict=True) if isinstance(p, float) and p < 1.0 - band]


def lines() -> Iterator[str]:
    """Write the table."""
    yield f"Measured on {datetime.datetime.now(datetime.UTC).date()}: {CAMPAIGNS} campaigns a study.\n"
    rows, counts = [], dict[str, int]()
    for name, study in STUDIES.items():
        print(f"== {name}", flush=True)
        for quantity, count in covered(study, CAMPAIGNS).items():
            counts[f"{name}, {quantity}"] = count
            rows.append((name, study.what, quantity, f"{count / CAMPAIGNS:.4f}"))
    yield table_text(Table(("study", "campaign", "interval of", "covers"), tuple(rows), ""))
    found = outside(counts, CAMPAIGNS)
    yield f"Outside the 99.9 % binomial band, by Holm over all: {'; '.join(found) or 'none'}.\n"


def main() -> None:
    """Put the table between its two lines of the document."""
    text = DOCUMENT.read_text(encoding="utf-8")
    if text.count(FIRST) != 1 or text.count(LAST) != 1:
        sys.exit(f"{DOCUMENT} has no place for the results: put the lines {FIRST} and {LAST} into it.")
    before, after = text.split(FIRST)[0], text.split(LAST)[1]
    DOCUMENT.write_text("\n".join([before + FIRST, "", *lines(), LAST]) + after, encoding="utf-8")


if __name__ == "__main__":
    main()
