"""What the studies that are kept as sheets say of drawn campaigns, and what is true of them (`validation_document`)."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

import numpy as np

from benchmarks.validation_emulator import LEVEL, ingested
from data_schema.vocabulary import Undefined
from ingest.formats.study_sheets import read_flasks, read_walks
from ingest.tables.sheet import SheetFile
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
    flask_campaign,
    flasks,
    oscillation_campaign,
    oscillations,
    walk_campaign,
    walks,
)
from labbook.demo.writers import CampaignFiles
from labbook.studies import characterisation, compaction, field
from labbook.studies.characterisation import Characterisation
from labbook.studies.compaction import Compaction
from labbook.studies.field import FieldStudy
from labbook.studies.study import Asked, Found, S_co

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
        for what in ("", *alone):
            yield f"stiffness, gain {gain:g}{what}", k
            yield f"damping, gain {damping_gain:g}{what}", d


GAINS_AND_LINES = {**dict(_of_gains()), **LINES}


def flasks_read(chance: np.random.Generator) -> Compaction:
    """Draw a sheet of flasks and read it."""
    return compaction.compaction(
        read_flasks(SheetFile("flasks.csv", flasks(chance).encode(), decimal=".")), GRAIN_MM, LEVEL
    )


def walks_read(chance: np.random.Generator) -> FieldStudy:
    """Draw a sheet of walks and read it."""
    return field.field_study(read_walks(SheetFile("walks.csv", walks(chance).encode(), decimal=".")), LEVEL)


def oscillations_read(chance: np.random.Generator) -> Characterisation:
    """Draw oscillations at one neutral length."""
    return characterisation.characterisation(oscillations(chance), LEVEL)


def _through_files(
    ask: Callable[[Asked], Found[S_co]], draw: Callable[[int], CampaignFiles]
) -> Callable[[np.random.Generator], S_co]:
    """Draw a study's whole campaign as files, ingest them into a book, and ask the study of it."""
    return lambda chance: ingested(ask, draw(int(chance.integers(2**31))))


flasks_ingested = _through_files(compaction.ask, flask_campaign)
walks_ingested = _through_files(field.ask, walk_campaign)
oscillations_ingested = _through_files(characterisation.ask, oscillation_campaign)


def of_flasks(study: Compaction) -> Intervals:
    """Return the intervals of both fractions and of their difference, by a line and by a curve."""
    found = {f"fraction, {one.state}": one for one in study.states} | {"difference within flasks": study.difference}
    return {name: one.ci for name, one in found.items()} | {
        f"{name}{_CURVE}": one.curved_ci for name, one in found.items()
    }


def of_walks(study: FieldStudy) -> Intervals:
    """Return the intervals of the ratio and of either robot's mean."""
    return {"ratio within walks": study.ratio.ci, **{f"mean, {one.name}": one.ci for one in study.robots}}


def of_oscillations(study: Characterisation) -> Intervals:
    """Return the intervals of each condition, of one mass alone, and of the lines."""
    found: dict[str, tuple[float, float] | Undefined] = {}
    for one in study.conditions:
        stiffness, damping = f"stiffness, gain {one.gain:g}", f"damping, gain {one.damping_gain:g}"
        found |= {stiffness: one.stiffness_n_m.ci, damping: one.damping_kg_s.ci}
        if one.gain in ENDS:
            alone = next(mass for mass in one.masses if mass.mass_kg == ALONE_KG)
            found[f"{stiffness}, {ALONE_KG:g} kg alone"] = alone.stiffness_n_m.ci
            found[f"{damping}, {ALONE_KG:g} kg alone"] = alone.damping_kg_s.ci
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


FLASKS = (of_flasks, FRACTIONS)
WALKS = (of_walks, RESISTANCES)
OSCILLATIONS = (of_oscillations, GAINS_AND_LINES)
OF_LINES = (of_lines, LINES)
"""What a study says, and what is true of it."""
