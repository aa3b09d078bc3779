"""Published experiments beside their simulation: lines for a terminal, a document in Markdown, data for programs.

Steady jumps on emulator and force plate and drops onto the bed as tables, what is published in brackets beside what is
simulated; then every published result with its verdict.
"""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from functools import cache
from typing import Any, TypeVar

from labbook.presenting.simulation.published_results import (
    claims_table,
    results_table,
    short_rows,
    verdict_counts,
)
from labbook.presenting.simulation.simulated import assumed_texts
from labbook.presenting.simulation.work_precision import plain_number
from reports.display import decimal_text
from reports.tables.formats.as_markdown import markdown_text
from reports.tables.table import Cell, Column, Columns, Table, table_of
from simulator.scene import Scene
from simulator.steady.published_numbers import Comparison, apex_between_m, published_numbers
from simulator.steady.published_results import JudgedResult, contradictions
from simulator.steady.tables import (
    ESTIMATED_OVER_MEASURED,
    FEET_M,
    BedRow,
    BedTable,
    EmulatorRow,
    EmulatorTable,
    PlateRow,
    PlateTable,
    SteadyTables,
)
from simulator.thesis.claims import Finding

R = TypeVar("R", EmulatorRow, PlateRow, BedRow)
_APEX = "apex"
_ON_THE_LINE = (200.0, 300.0)
"""Gains between the two whose apexes are published."""
_FACTORS = {"%": 100.0, "mm": 1e3, "ms": 1e3}


def _column(
    title: str, unit: str, field: str, value: Callable[[R], float], places: int = 0, published: str = ""
) -> tuple[Column, Callable[[R], Cell]]:
    """Make a column of simulated numbers, in the unit of `field`; the one `published` stands in brackets."""

    def cell(row: R) -> Cell:
        number = value(row)
        text = decimal_text(_FACTORS.get(unit, 1.0) * number, places)
        known = _beside().get((published, row.gain))
        return Cell(f"{text} ({known})" if known else text, (number,))

    return Column(title, (field,), unit), cell


_EMULATOR_COLUMNS: Columns[EmulatorRow] = (
    _column("gain", "", "gain", lambda row: row.gain),
    _column("apex CE", "m", "apex_height_m", lambda row: row.ce.apex_height_m, 3, _APEX),
    _column("joules CE", "J", "cost_j", lambda row: row.ce.cost_j, 1),
    _column("saving, scaled", "%", "scaled_saving", lambda row: row.scaled_saving, 1, "scaled_saving"),
    _column("saving, constant", "%", "constant_saving", lambda row: row.constant_saving, 1, "constant_saving"),
    _column("apex lost, scaled", "%", "scaled_loss", lambda row: row.scaled_loss, 1, "loss"),
    _column("apex lost, constant", "%", "constant_loss", lambda row: row.constant_loss, 1, "loss"),
    _column("sink at switch", "mm", "switch_depth_m", lambda row: row.yielding.switch_depth_m),
    _column("deepest sink", "mm", "max_depth_m", lambda row: row.ce.max_depth_m),
    _column("period", "s", "period_s", lambda row: row.ce.period_s, 2),
    _column("capped", "ms", "capped_time_s", lambda row: row.ce.capped_time_s),
    _column("within reach", "J", "yielding_heat_j", lambda row: row.yielding.heat_j, 1),
)
_PLATE_COLUMNS: Columns[PlateRow] = (
    _column("gain", "", "gain", lambda row: row.gain),
    _column("apex", "m", "apex_height_m", lambda row: row.jump.apex_height_m, 3),
    _column("heat", "J", "heat_j", lambda row: row.jump.heat_j, 1),
    _column("mechanical", "J", "mechanical_j", lambda row: row.jump.mechanical_j, 1),
    _column("drag", "J", "drag_j", lambda row: row.jump.drag_j, 1),
    _column("joules", "J", "cost_j", lambda row: row.jump.cost_j, 1),
    _column(f"joules / {ESTIMATED_OVER_MEASURED:g}", "J", "battery_j", lambda row: row.battery_j, 1),
    _column("touchdown", "m/s", "touchdown_velocity_m_s", lambda row: row.jump.touchdown_velocity_m_s, 2),
    _column("foot's loss", "J", "impact_loss_j", lambda row: row.jump.impact_loss_j, 2),
    _column("capped", "ms", "capped_time_s", lambda row: row.jump.capped_time_s),
    _column("shortest leg", "m", "min_leg_length_m", lambda row: row.jump.min_leg_length_m, 3),
)
_BED_COLUMNS: Columns[BedRow] = (
    _column("foot", "mm", "foot_radius_m", lambda row: FEET_M[row.foot]),
    _column("gain", "", "gain", lambda row: row.gain),
    _column("damping gain", "", "damping_gain", lambda row: row.damping_gain),
    _column("joules", "J", "cost_j", lambda row: row.cost_j, 1),
    _column("saving", "%", "saving", lambda row: row.saving, 1),
    _column("apex", "m", "apex_height_m", lambda row: row.apex_height_m, 3),
    _column("apex gained", "mm", "apex_gain_m", lambda row: row.apex_gain_m, 1),
    _column("deepest sink", "mm", "max_depth_m", lambda row: row.max_depth_m),
    _column("capped", "ms", "capped_time_s", lambda row: row.capped_time_s),
)


def _emulator_shown(table: EmulatorTable) -> Table:
    """Make the table of the ground emulator."""
    caption = (
        f"Jump {table.scene.jumps} of {table.scene.jumps} on the ground emulator; in brackets what the thesis says "
        "(4.3, 4.4), with ~ on the straight line between the two apexes that it gives. Savings and lost apex heights "
        "are those of active damping against compression-extension (CE): scaled, its gain a sixth of the extension "
        "gain, and constant, a gain of 50. Joules are heat and mechanical energy of a whole jump. Sink: of the "
        "platform under CE. Capped: at the motors' stall torque. Within reach: the heat under CE while the extending "
        "leg drives the platform down, where active damping acts."
    )
    return table_of("emulator", caption, table.rows, _EMULATOR_COLUMNS)


def _plate_shown(table: PlateTable) -> Table:
    """Make the table of the force plate."""
    caption = (
        f"Jump {table.scene.jumps} of {table.scene.jumps} on the force plate, compression-extension. Of this "
        "experiment the thesis gives no apex and no joules, only the slope of the joules estimated from the plate's "
        f"forces over those of the battery, {ESTIMATED_OVER_MEASURED:g} (3.2.2): nothing stands beside these numbers. "
        "Touchdown: velocity of the body. Foot's loss: its kinetic energy when the plate stops it."
    )
    return table_of("force_plate", caption, table.rows, _PLATE_COLUMNS)


def _bed_shown(table: BedTable) -> Table:
    """Make the table of the granular bed."""
    caption = (
        "One drop onto the bed of glass beads in each of the 24 conditions; damping gain 0 is compression-extension. "
        "The thesis gives no joules and no apexes of these conditions, only what stands among the results below. "
        "Saving and apex gained: against compression-extension with the same foot, given by its radius, and the same "
        "extension gain. Joules are heat and mechanical energy of the stance. Capped: at the motors' stall torque."
    )
    return table_of("bed", caption, table.rows, _BED_COLUMNS)


@cache
def _beside() -> dict[tuple[str, float], str]:
    """Return the published words by column and gain."""
    found = {(number.column, gain): number.beside for number in published_numbers() for gain in number.gains}
    return found | {(_APEX, gain): f"~{decimal_text(apex_between_m(gain), 3)}" for gain in _ON_THE_LINE}


_WIDTH = 120
_INTRODUCTION = (
    "What one set of parameters gives for the experiments of the thesis in which jumps follow each other, beside what "
    "the thesis says of them. Many of the parameters were never published; those that are assumed stand at the end. On "
    "the emulator some were chosen so that the published apexes are approached, so that an apex that agrees proves "
    "little; other sets approach them as well."
)
_CAPTION = (
    "A number agrees where every simulated value lies within its limits. The text gives few limits, the others are "
    "labbook's own: about a number is within a quarter of it, and an apex agrees within 7 mm, just under the bound "
    "that the thesis gives for the scatter of its apexes."
)
_GAINS = (
    "The leg's gains are taken as the fits of the emulator's leg say (2.56 N/m a unit of gain and 67.36 N/m; thesis "
    "4.2.6, 5.1.1), active damping as 3.32 kg/m a unit of gain: on the emulator without the fit's offset, which is "
    "that leg's own friction, on the bed with it, 19.67 kg/m."
)
_NO_REASON = "no reason is known."


def findings_of(compared: Sequence[Comparison]) -> tuple[Finding, ...]:
    """Return the findings on the numbers that the simulation gives something for."""
    return tuple(item.finding for item in compared if item.finding is not None)


def reasons(compared: Sequence[Comparison]) -> dict[str, str]:
    """Return why each number that is not matched is not, by its id."""
    return {item.published.claim.id: item.published.reason or _NO_REASON for item in compared if not item.agrees}


def score(compared: Sequence[Comparison]) -> str:
    """Count the numbers that agree."""
    judged = findings_of(compared)
    agreeing, silent = sum(finding.agrees for finding in judged), len(compared) - len(judged)
    return f"{agreeing} of {len(judged)} agree; for {silent} more the simulation gives nothing to compare."


def terminal_tables(
    tables: SteadyTables, compared: Sequence[Comparison], results: Sequence[JudgedResult]
) -> dict[str, list[list[str]]]:
    """Return by title the tables of experiments, compared numbers and results: rows of texts, heads first."""
    emulator, plate, _ = (f"jump {scene.jumps} of {scene.jumps}" for scene in _scenes(tables))
    return {
        f"ground emulator, {emulator}, in brackets what the thesis says": _emulator_shown(tables.emulator).texts,
        f"force plate, {plate}": _plate_shown(tables.force_plate).texts,
        "granular bed, one drop in each condition": _bed_shown(tables.bed).texts,
        "what the thesis says, and what is simulated": short_rows(claims_table(findings_of(compared))),
        "every published result": short_rows(results_table(results)),
    }


def notes(tables: SteadyTables, compared: Sequence[Comparison], results: Sequence[JudgedResult]) -> list[str]:
    """Say for a terminal what cannot be matched and why, and list the assumed parameters."""
    lines = [verdict_counts(results), "", f"numbers of the experiments: {score(compared)}", "", "not matched, and why:"]
    lines += [f"  {name}: {reason}" for name, reason in reasons(compared).items()]
    lines += ["", _GAINS]
    for scene in _scenes(tables):
        lines += ["", f"{scene.name}, {_jumps_text(scene)}, rests on assumed parameters:"]
        lines += [f"  {text}" for text in assumed_texts(scene)]
    return [*lines, "", f"simulated for a relative error of {plain_number(tables.accuracy)}."]


def document(tables: SteadyTables, compared: Sequence[Comparison], results: Sequence[JudgedResult]) -> str:
    """Write all of it as Markdown; the same on every machine."""
    return "\n\n".join(part.rstrip("\n") for part in _parts(tables, compared, results)) + "\n"


def _parts(tables: SteadyTables, compared: Sequence[Comparison], results: Sequence[JudgedResult]) -> Iterator[str]:
    yield "# Published experiments, simulated"
    yield _filled("Written by `labbook sim published --out docs/published.md`; do not edit.")
    yield _filled(_INTRODUCTION)
    for title, table in (
        ("Ground emulator (thesis ch. 4)", _emulator_shown(tables.emulator)),
        ("Force plate (thesis 3.2.2)", _plate_shown(tables.force_plate)),
        ("Granular bed (thesis ch. 5)", _bed_shown(tables.bed)),
        ("What agrees", claims_table(findings_of(compared), f"{_CAPTION} {score(compared)}")),
        ("Every published result", results_table(results)),
    ):
        yield f"## {title}"
        caption, rows = markdown_text(table).split("\n\n")
        yield _filled(caption)
        yield rows
    yield "## What cannot be matched, and why"
    statements = {item.published.claim.id: item.published.claim for item in compared}
    for name, reason in reasons(compared).items():
        yield _filled(f"**{name}** ({statements[name].where}): {statements[name].statement}. {reason}")
    yield "## Where the thesis contradicts itself"
    yield "\n".join(_filled(f"- **{item.where}**: {item.text}", "  ") for item in contradictions())
    yield "## What it rests on"
    yield _filled(f"Simulated for a relative error of {plain_number(tables.accuracy)}. {_GAINS}")
    for scene in _scenes(tables):
        yield _filled(f"Scene `{scene.name}`, {_jumps_text(scene)}. {scene.description} Assumed:")
        yield "\n".join(_filled(f"- {text}", "  ") for text in assumed_texts(scene))


def as_data(tables: SteadyTables, compared: Sequence[Comparison], results: Sequence[JudgedResult]) -> dict[str, Any]:
    """Return everything for JSON: SI units, shares as fractions."""
    return {
        "accuracy": tables.accuracy,
        "emulator": {
            **_scene_data(tables.emulator.scene),
            "rows": [
                {
                    **asdict(row),
                    "scaled_saving": row.scaled_saving,
                    "constant_saving": row.constant_saving,
                    "scaled_loss": row.scaled_loss,
                    "constant_loss": row.constant_loss,
                }
                for row in tables.emulator.rows
            ],
        },
        "force_plate": {
            **_scene_data(tables.force_plate.scene),
            "rows": [{**asdict(row), "battery_j": row.battery_j} for row in tables.force_plate.rows],
        },
        "bed": {
            **_scene_data(tables.bed.scene),
            "rows": [{**asdict(row), "saving": row.saving, "apex_gain_m": row.apex_gain_m} for row in tables.bed.rows],
        },
        "published": [_published_data(item) for item in compared],
        "agreeing": sum(item.agrees for item in compared),
        "results": results_table(results).records,
        "contradictions": [asdict(item) for item in contradictions()],
    }


def _published_data(item: Comparison) -> dict[str, Any]:
    found = {} if item.finding is None else asdict(item.finding)
    found.pop("claim", None)
    return {
        **asdict(item.published.claim),
        "gains": item.published.gains,
        **found,
        "compared": item.finding is not None,
        "agrees": item.agrees,
        "reason": "" if item.agrees else item.published.reason,
    }


def _scene_data(scene: Scene) -> dict[str, Any]:
    assumed = {name: {"value": scene[name], "why": scene.values[name].why} for name in scene.assumed}
    return {"scene": scene.name, "jumps": scene.jumps, "assumed": assumed}


def _scenes(tables: SteadyTables) -> tuple[Scene, Scene, Scene]:
    return tables.emulator.scene, tables.force_plate.scene, tables.bed.scene


def _jumps_text(scene: Scene) -> str:
    return "one jump" if scene.jumps == 1 else f"{scene.jumps} jumps"


def _filled(text: str, indent: str = "") -> str:
    return textwrap.fill(text, _WIDTH, break_long_words=False, break_on_hyphens=False, subsequent_indent=indent)
