"""What the studies that are kept as sheets say of drawn campaigns, and what is true of them (`validation_document`)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from data_schema.vocabulary import Undefined
from labbook.actions.studies.sheet_source import SheetSource, sheet_source
from labbook.actions.studies.sheets import characterisation_of, compaction_of, field_study_of
from labbook.analysis.studies.characterisation import Characterisation, characterisation
from labbook.analysis.studies.compaction import Compaction
from labbook.analysis.studies.field import FieldStudy, geometric
from labbook.demo.studies.sheets import (
    COMPACTED,
    DAMPING,
    GAINS,
    GRAIN_MM,
    LOOSE,
    MASSES_KG,
    STIFFNESS,
    THIN,
    WIDE,
    SheetCampaign,
    flask_campaign,
    flasks,
    make_sheet_book,
    oscillation_campaign,
    oscillations,
    walk_campaign,
    walks,
)

LEVEL = 0.95
Intervals = Mapping[str, tuple[float, float] | Undefined]

_CURVE = ", along a curve"
_FRACTIONS = {"fraction, loose": LOOSE, "fraction, compacted": COMPACTED, "difference within flasks": COMPACTED - LOOSE}
FRACTIONS = {f"{name}{curve}": value for curve in ("", _CURVE) for name, value in _FRACTIONS.items()}
RESISTANCES = {"ratio within walks": WIDE / THIN, "mean, thin": THIN, "mean, wide": WIDE}
LINES = {
    "stiffness, slope over gain": STIFFNESS[0],
    "stiffness, at gain 0 by the line": STIFFNESS[1],
    "damping, slope over gain": DAMPING[0],
    "damping, at gain 0 by the line": DAMPING[1],
}
ALONE_KG = MASSES_KG[0]
ENDS = (GAINS[0][0], GAINS[-1][0])


def _of_gains() -> Iterator[tuple[str, float]]:
    for gain, damping_gain in GAINS:
        k, d = STIFFNESS[0] * gain + STIFFNESS[1], DAMPING[0] * damping_gain + DAMPING[1]
        alone = (f", {ALONE_KG:g} kg alone",) if gain in ENDS else ()
        for what in ("", ", plane by differences", *alone):
            yield f"stiffness, gain {gain:g}{what}", k
            yield f"damping, gain {damping_gain:g}{what}", d


GAINS_AND_LINES = {**dict(_of_gains()), **LINES}


def flasks_read(chance: np.random.Generator) -> Compaction:
    """Draw a sheet of flasks and read it."""
    return compaction_of(flasks(chance), Path("flasks.csv"), GRAIN_MM, LEVEL, ".")


def walks_read(chance: np.random.Generator) -> FieldStudy:
    """Draw a sheet of walks and read it."""
    text = walks(chance)
    return field_study_of(Path("walks.csv"), lambda _path: text, LEVEL, ".")


def oscillations_read(chance: np.random.Generator) -> Characterisation:
    """Draw oscillations at one neutral length."""
    return characterisation(oscillations(chance), LEVEL)


@contextmanager
def _ingested(study: str, draw: Callable[[int], SheetCampaign], chance: np.random.Generator) -> Iterator[SheetSource]:
    """Draw a study's whole campaign as files, ingest them into a book, and open the sheet that it keeps."""
    with TemporaryDirectory() as folder:
        campaign = draw(int(chance.integers(2**31)))
        book = make_sheet_book(Path(folder) / "demo", campaign, lambda _what: None, lambda _line: None)
        with sheet_source(study, None, book, None) as sheets:
            yield sheets


def flasks_ingested(chance: np.random.Generator) -> Compaction:
    """Draw flasks through files and ingest."""
    with _ingested("compaction", flask_campaign, chance) as sheets:
        path = sheets.sheet
        return compaction_of(sheets.text(path), path, sheets.grain_mm(None), LEVEL, sheets.decimal(path))


def walks_ingested(chance: np.random.Generator) -> FieldStudy:
    """Draw walks through files and ingest."""
    with _ingested("field", walk_campaign, chance) as sheets:
        return field_study_of(sheets.sheet, sheets.text, LEVEL, sheets.decimal(sheets.sheet), sheets.decimal)


def oscillations_ingested(chance: np.random.Generator) -> Characterisation:
    """Draw oscillations at three neutral lengths through files and ingest."""
    with _ingested("characterisation", oscillation_campaign, chance) as sheets:
        return characterisation_of(sheets.sheet, sheets.text, LEVEL, sheets.decimal)


def of_flasks(study: Compaction) -> Intervals:
    """Return the intervals of both fractions and of their difference, by a line and by a curve."""
    found = {f"fraction, {state.name}": state.unbounded.ci for state in study.states}
    found |= {f"fraction, {state.name}{_CURVE}": state.curved_ci for state in study.states}
    rise = "difference within flasks"
    return {**found, rise: study.rise.intervals()[0], f"{rise}{_CURVE}": study.curved_rise_ci}


def of_walks(study: FieldStudy) -> Intervals:
    """Return the intervals of the ratio and of either robot's mean."""
    means = {f"mean, {robot}": geometric(logs)[1] for robot, logs in study.log_means.items()}
    return {"ratio within walks": geometric(study.log_ratio)[1], **means}


def of_oscillations(study: Characterisation) -> Intervals:
    """Return the intervals of each condition, of its plane, of one mass alone, and of the lines."""
    found: dict[str, tuple[float, float] | Undefined] = {}
    for one in study.conditions:
        names = f"stiffness, gain {one.gain:g}", f"damping, gain {one.damping_gain:g}"
        alone = next(mass for mass in one.masses if mass.mass_kg == ALONE_KG)
        for name, pooled, plane, of_mass in zip(
            names,
            (one.stiffness, one.damping),
            (one.plane.fit.stiffness_ci, one.plane.fit.damping_ci),
            (alone.stiffness, alone.damping),
            strict=True,
        ):
            found |= {name: pooled.ci, f"{name}, plane by differences": plane}
            if one.gain in ENDS:
                found[f"{name}, {ALONE_KG:g} kg alone"] = of_mass.ci
    return {**found, **of_lines(study)}


def of_lines(study: Characterisation) -> Intervals:
    """Return the intervals of the lines at a neutral length of 20 cm, whose truth is the thesis's."""
    lines = next(one for one in study.lines if one.neutral_m == 0.2)
    ends = [
        of_line
        for line in (lines.stiffness, lines.damping)
        for of_line in ((line, line) if isinstance(line, Undefined) else (line.slope_ci, line.offset_ci))
    ]
    return dict(zip(LINES, ends, strict=True))
