"""Closed loop: simulated campaigns with a known truth, through a study's own sheet and analysis, and how often its
intervals cover. Writes docs/validation.csv and the table of docs/validation.md anew, a study after another.

python benchmarks/validation_document.py [STUDY ...]
"""

from __future__ import annotations

import csv
import datetime
import functools
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import scipy.stats

from benchmarks import validation_bed as bed
from benchmarks import validation_calibration as calibration
from benchmarks import validation_emulator as emulator
from benchmarks import validation_sheets as sheets
from benchmarks.document import replace_between, table_text
from benchmarks.section import Table
from benchmarks.validation_emulator import LEVEL, drain_error, ingested
from benchmarks.validation_sheets import Intervals
from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.run_energy import joules_per_mah
from labbook.demo.studies.force_plate import (
    DAYS,
    HOPS,
    IDLE_S,
    SCATTER,
    VOLTAGE_V,
    PlateStudyRun,
    plate_campaign,
    plate_files,
)
from labbook.demo.studies.runs import StudyScatter
from labbook.demo.truth import recharged_mah
from labbook.studies.force_plate import MOTOR_PARAMETERS, Drive, ForcePlateStudy, PlateRun, ask, compare_joules
from simulator.scene_file import load_scene
from stats.compare.shared_error import SharedError
from stats.groups.multiple import holm
from stats.lines.passive_drain import fit_passive_drain
from stats.lines.regression import SlopeThroughOrigin, slope_through_origin

DOCUMENT = Path(__file__).resolve().parent.parent / "docs" / "validation.md"
DATA = DOCUMENT.with_suffix(".csv")
CAMPAIGNS, FEW, SEED = 2000, 20, 21


@dataclass(frozen=True, slots=True)
class ClosedLoop:
    """A study: how a campaign is drawn (a sheet, or logs as read), what the study says of it, and what is true."""

    what: str
    draw: Callable[[np.random.Generator], Any]
    intervals: Callable[[Any], Intervals]
    truths: Mapping[str, float] | Callable[[], Mapping[str, float]]
    campaigns: int = CAMPAIGNS


SLOPE, DRIFT = "slope less that without errors", "drift of a log's clock less the true one"


def plate_book(chance: np.random.Generator) -> tuple[list[PlateStudyRun], ForcePlateStudy]:
    """Draw the campaign of four days on a force plate through files and ingest; returns it and what the study says."""
    campaign = plate_campaign(int(chance.integers(2**31)))
    return campaign, ingested(ask, plate_files(campaign))


@functools.cache
def slopes_without_errors() -> dict[int, float]:
    """Return by window the slope that instruments without errors give, where runs differ by nothing but their hops."""
    exact = [run for run in plate_campaign(SEED, scatter=StudyScatter(0.0, 0.0, 0.0), noise=0.0) if run.gain]
    study = compare_joules([in_memory(run, run.cost_j) for run in exact])
    return {one.window: one.slope for one in study.windows}


def in_memory(run: PlateStudyRun, measured_j: float) -> PlateRun:
    """Return a run of a drawn campaign as the study takes it, with these joules of the battery."""
    scene = load_scene("force_plate")
    links = {"upper_link": scene["upper_link"], "lower_link": scene["lower_link"]}
    assert run.plate is not None and run.log_ms is not None and run.channels is not None  # noqa: PT018
    return PlateRun(
        name=run.name,
        day=run.date.isoformat(),
        condition=f"k_gain {run.gain}",
        measured_j=measured_j,
        shared=SharedError(),
        hops=run.jumps_made,
        foot_mass_kg=scene["foot_mass"],
        drive=Drive(**links, **{name: scene[name] for name in MOTOR_PARAMETERS}),
        plate_time_s=run.plate.time_ms / 1e3,
        force_n=run.plate.force_n[:, 2],
        leg_time_s=(run.log_ms - run.log_ms[0]) / 1e3,
        length_m=run.channels["leg_length [m]"],
    )


def _of_plate(drawn: tuple[list[PlateStudyRun], ForcePlateStudy]) -> Intervals:
    campaign, study = drawn
    slope, drift = slopes_without_errors()[study.window], next(run.clocks[1] for run in campaign if run.gain)
    return {SLOPE: _less(study.slope.ci, slope), DRIFT: _less(study.runs[0].clocks.drift_ci, drift)}


HOPS_COST_J = {300: 44.95, 400: 57.1, 500: 63.4, 600: 67.1}
ESTIMATES_J = {300: 48.5, 400: 60.9, 500: 67.2, 600: 71.0}
RUN_S = {300: 65, 400: 70, 500: 73, 600: 75}
"""By gain about what the simulated campaign has: joules of a hop, and estimated; seconds of a run."""


def recharges(chance: np.random.Generator) -> SlopeThroughOrigin:
    """Draw what the charger says after four days of runs whose estimates are exact; returns their slope."""
    scatter, idle, made = SCATTER, [], []
    of_charger = VOLTAGE_V, scatter.recharge_mah
    for day in range(DAYS):
        idle += [(seconds, recharged_mah(chance, seconds, 0.0, *of_charger)) for seconds in IDLE_S]
        of_day = 1.0 + chance.normal(0.0, scatter.day)
        for gain, cost_j in HOPS_COST_J.items():
            joules = HOPS * cost_j * of_day * (1.0 + chance.normal(0.0, scatter.run))
            made.append((day, gain, recharged_mah(chance, RUN_S[gain], joules, *of_charger)))
    line = fit_passive_drain([seconds for seconds, _ in idle], [mah for _, mah in idle], resolution_mah=1.0)
    worth_j = joules_per_mah(VOLTAGE_V, HOPS)
    return slope_through_origin(
        [worth_j * (mah - line.at(RUN_S[gain]).charge_mah) for _, gain, mah in made],
        [ESTIMATES_J[gain] for _, gain, _ in made],
        [day for day, _, _ in made],
        [drain_error(line, RUN_S[gain], worth_j) for _, gain, _ in made],
        LEVEL,
    )


def _less(interval: tuple[float, float] | Undefined, true: float) -> tuple[float, float] | Undefined:
    return interval if isinstance(interval, Undefined) else (interval[0] - true, interval[1] - true)


FEW_MAH = "saving, scaled active damping, gain 100"
"""At 25 mAh of a hundred jumps the charger's last digit is 4 %."""
INGESTED = "the same, through files and ingest"
STUDIES = {
    "compaction": ClosedLoop(
        "five flasks, an error of 0.002 a flask and of 0.0015 a filling; water read to 0.1 ml, above 100 ml to 1 ml",
        sheets.flasks_read,
        *sheets.FLASKS,
    ),
    "compaction, ingested": ClosedLoop(INGESTED, sheets.flasks_ingested, *sheets.FLASKS, FEW),
    "field": ClosedLoop(
        "four walks that differ by 30 %, robots that scatter by 3 %; charges to 1 mAh, distances to 0.1 m",
        sheets.walks_read,
        *sheets.WALKS,
    ),
    "field, ingested": ClosedLoop(INGESTED, sheets.walks_ingested, *sheets.WALKS, FEW),
    "characterisation": ClosedLoop(
        "three masses on four pairs of gains, 300 Hz for 0.5 s; 0.1 mm and 5 mm/s, 1 % of packets lost",
        sheets.oscillations_read,
        *sheets.OSCILLATIONS,
    ),
    "characterisation, ingested": ClosedLoop(
        "the same, twice each, at three neutral lengths, through files and ingest",
        sheets.oscillations_ingested,
        *sheets.OF_LINES,
        FEW,
    ),
    "force-plate, charges": ClosedLoop(
        "four days of four gains; days and runs scatter by 1 %, recharges by 0.35 mAh, read to 1 mAh",
        recharges,
        lambda slope: {"slope": slope.ci},
        {
            "slope": sum(ESTIMATES_J[gain] * cost_j for gain, cost_j in HOPS_COST_J.items())
            / sum(cost_j * cost_j for cost_j in HOPS_COST_J.values())
        },
    ),
    "force-plate": ClosedLoop(
        "four days of four gains, 80 hops a run, through files and ingest; days and runs scatter by 1 %",
        plate_book,
        _of_plate,
        {SLOPE: 0.0, DRIFT: 0.0},
        FEW,
    ),
    "emulator, charges": ClosedLoop(
        "four days of 14 conditions; joules scatter by 1 % a day and 1.5 % a run, flights by 1 % a run; read to 1 mAh",
        emulator.from_charges,
        emulator.intervals,
        emulator.true_changes,
    ),
    "emulator, 150 jumps": ClosedLoop(
        "the same, of 150 jumps a run",
        lambda chance: emulator.from_charges(chance, 150),
        lambda study: {FEW_MAH: emulator.intervals(study)[FEW_MAH]},
        lambda: {FEW_MAH: emulator.true_changes(150)[FEW_MAH]},
    ),
    "emulator": ClosedLoop(
        "four days of 14 conditions, 100 jumps a run, through files and ingest; the same scatter",
        emulator.emulator_book,
        emulator.intervals,
        emulator.true_changes,
        FEW,
    ),
    "bed, charges": ClosedLoop(
        "24 conditions of ten runs on some 17 days, with controls every day; joules scatter by 0.4 J a day and 1.2 mAh "
        "a run, apexes by 1.5 mm a run; read to 1 mAh",
        bed.from_charges,
        bed.intervals,
        bed.truths,
    ),
    "bed": ClosedLoop(INGESTED, bed.bed_book, bed.intervals, bed.truths, FEW),
    "calibrate": ClosedLoop(
        "means of eight conditions on six days, one run of each a day; days and runs scatter by 1 J and 3 mm",
        lambda chance: calibration.from_means(chance, 1.0),
        calibration.intervals,
        calibration.truths,
    ),
    "calibrate, days alike": ClosedLoop(
        "the same, on days that do not differ",
        lambda chance: calibration.from_means(chance, 0.0),
        calibration.intervals,
        calibration.truths,
        200,
    ),
}


def covered(
    study: ClosedLoop, campaigns: int, seed: int = SEED, progress: Callable[[int], None] = lambda _done: None
) -> dict[str, tuple[int, int]]:
    """Count by quantity the campaigns whose interval covers what is true; returns (count, campaigns)."""
    chance, truths = np.random.default_rng(seed), study.truths() if callable(study.truths) else study.truths
    counts = dict.fromkeys(truths, 0)
    for done in range(campaigns):
        progress(done)
        for name, interval in study.intervals(study.draw(chance)).items():
            if not isinstance(interval, Undefined):
                counts[name] += interval[0] <= truths[name] <= interval[1]
    return {name: (count, campaigns) for name, count in counts.items()}


def outside(counts: Mapping[str, tuple[int, int]], band: float = 0.999) -> list[str]:
    """Return the quantities whose count lies outside the binomial band, by Holm over all."""
    ps = {name: float(scipy.stats.binomtest(*count, LEVEL).pvalue) for name, count in counts.items()}
    adjusted = holm(ps, "covers").adjusted_p
    return [name for name, p in zip(counts, adjusted, strict=True) if isinstance(p, float) and p < 1.0 - band]


class Row(NamedTuple):
    """A line of docs/validation.csv: of so many campaigns of a study so many have an interval that covers."""

    study: str
    interval: str
    campaigns: int
    covering: int
    measured_on: str


def read_rows() -> list[Row]:
    """Read what is known of the studies that there are."""
    if not DATA.exists():
        return []
    with DATA.open(encoding="utf-8", newline="") as file:
        rows = [Row(row[0], row[1], int(row[2]), int(row[3]), row[4]) for row in list(csv.reader(file))[1:]]
    return [row for row in rows if row.study in STUDIES]


def measure(name: str) -> list[Row]:
    """Draw the campaigns of a study."""
    study, today = STUDIES[name], str(datetime.datetime.now(datetime.UTC).date())

    def progress(done: int) -> None:
        if done % (study.campaigns // 10) == 0:
            print(f"   {done} of {study.campaigns} campaigns", flush=True)

    counts = covered(study, study.campaigns, progress=progress)
    return [Row(name, quantity, campaigns, count, today) for quantity, (count, campaigns) in counts.items()]


def write(rows: Sequence[Row]) -> None:
    """Write the rows, and from them the table between its two lines of the document."""
    rows = sorted(rows, key=lambda row: list(STUDIES).index(row.study))
    with DATA.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerows([Row._fields, *rows])
    replace_between(DOCUMENT, "<!-- measured -->", "<!-- end of measured -->", lines(rows))


def lines(rows: Sequence[Row]) -> Iterator[str]:
    """Write the campaigns, their table, and what lies outside."""
    for name in dict.fromkeys(row.study for row in rows):
        yield f"- {name}: {STUDIES[name].what}"
    cells = [
        (row.study, row.interval, str(row.campaigns), f"{row.covering / row.campaigns:.4f}", row.measured_on)
        for row in rows
    ]
    yield "\n" + table_text(Table(("study", "interval of", "n", "covers", "measured on"), tuple(cells), ""))
    found = outside({f"{row.study}, {row.interval}": (row.covering, row.campaigns) for row in rows})
    yield f"Outside the 99.9 % binomial band, by Holm over all: {'; '.join(found) or 'none'}.\n"


def main(names: Sequence[str]) -> None:
    """Measure the studies with these names, all without one, and write each as it is done."""
    unknown = [name for name in names if name not in STUDIES]
    if unknown:
        sys.exit(f"no study is called {unknown[0]!r}: {', '.join(STUDIES)}.")
    for name in names or STUDIES:
        print(f"== {name}", flush=True)
        write([*(row for row in read_rows() if row.study != name), *measure(name)])


if __name__ == "__main__":
    main(sys.argv[1:])
