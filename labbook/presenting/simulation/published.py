"""The thesis's claims and published experiments beside the simulation: tables, one document, data for programs."""

from __future__ import annotations

import textwrap
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict
from typing import Any, TypeVar

from labbook.presenting.simulation.simulated import assumed_texts
from reports.display import DASH, decimal_text, general_text, given_text, plain_number, with_unit
from reports.tables.formats import markdown_text
from reports.tables.table import Cell, Column, ColumnOf, Columns, Table, column, table_of, text
from simulator.scene import Scene
from simulator.steady.published_results import DEPENDS, VERDICTS, JudgedResult, PublishedResult, contradictions
from simulator.steady.tables import ESTIMATED_OVER_MEASURED, FEET_M, BedRow, EmulatorRow, PlateRow, SteadyTables
from simulator.thesis.claims import Claim, Finding, experiment_claims
from simulator.thesis.readings import Reading

R = TypeVar("R", EmulatorRow, PlateRow, BedRow)


_CLAIMS_CAPTION = (
    "What ch. 3 of the thesis says about its simulations, and what the simulation gives over the grids of the "
    "figures: at which share of their points it lies within the claim's limits. The text gives no ranges and few "
    "limits: both are labbook's own, the ranges those of the figures' axes; about a number is within a quarter of it."
)
_CLAIM_COLUMNS: Columns[Finding] = (
    text("Claim", "claim", lambda found: found.claim.id),
    text("Where", "where", lambda found: found.claim.where),
    text("Statement", "statement", lambda found: found.claim.statement, prose=True),
    text(
        "Measured",
        "measure unit",
        lambda found: Cell(found.claim.measure, (found.claim.measure, found.claim.unit)),
        prose=True,
    ),
    column(
        "Thesis",
        "published",
        lambda found: Cell(_number(found.claim.published, found.claim.unit), (found.claim.published,)),
    ),
    column(
        "Simulated",
        "lowest median highest",
        lambda found: Cell(range_text(found), (found.lowest, found.median, found.highest)),
    ),
    column("Holds if", "at_least at_most", lambda found: _limits(found)),
    column(
        "Points within", "n_within n", lambda found: Cell(f"{found.n_within} of {found.n}", (found.n_within, found.n))
    ),
    column("Holds at", "share_within", lambda found: _share(found)),
)


def claims_table(findings: Sequence[Finding], caption: str = _CLAIMS_CAPTION) -> Table:
    """Make the table of all claims; its CSV has the numbers unrounded."""
    return table_of("claims", caption, findings, _CLAIM_COLUMNS, strong=lambda found: not found.agrees)


def _share(finding: Finding) -> Cell:
    """Return the share in percent, rounded so that only all is 100 % and only none 0 %."""
    percent = 100.0 * finding.share_within
    percent = percent if finding.n_within in (0, finding.n) else min(max(percent, 1.0), 99.0)
    return Cell(f"{percent:.0f} %", (finding.share_within,))


def _number(value: float | None, unit: str) -> str:
    return DASH if value is None else with_unit(general_text(value), unit)


def range_text(finding: Finding) -> str:
    """Write what was found: one number, or the ends of the range and the median, with the unit."""
    ends = [general_text(value) for value in (finding.lowest, finding.highest)]
    if ends[0] == ends[1]:
        return with_unit(ends[0], finding.claim.unit)
    median = general_text(finding.median)
    return f"{with_unit(f'{ends[0]} to {ends[1]}', finding.claim.unit)} (median {median})"


def _limits_text(claim: Claim) -> str:
    """Write within which limits a claim holds, with the unit."""
    if claim.at_least is not None and claim.at_most is not None:
        ends = general_text(claim.at_least), general_text(claim.at_most)
        return with_unit(ends[0] if ends[0] == ends[1] else f"{ends[0]} to {ends[1]}", claim.unit)
    if claim.at_least is not None:
        return f"at least {_number(claim.at_least, claim.unit)}"
    return DASH if claim.at_most is None else f"at most {_number(claim.at_most, claim.unit)}"


def claims_data(findings: Sequence[Finding]) -> list[dict[str, Any]]:
    """Return every field of every claim and finding, for JSON."""
    return [
        {**record, "figures": list(finding.claim.figures), "agrees": finding.agrees}
        for finding, record in zip(findings, claims_table(findings).records, strict=True)
    ]


_RESULT_COLUMNS: Columns[JudgedResult] = (
    text("Result", "result", lambda item: item.result.id),
    text("Where", "where", lambda item: item.result.where),
    text("What", "statement", lambda item: item.statement, prose=True),
    column("Published", "published unit relation", lambda item: _published(item.result)),
    column("Simulated", "lowest median highest saving", lambda item: _simulated(item)),
    column("Reproduced if", "at_least at_most", lambda item: _limits(item.finding)),
    text("Verdict", "verdict n_within n", lambda item: _verdict(item)),
    text("Remark", "remark", lambda item: item.remark, prose=True),
)
_RESULTS_CAPTION = (
    "A result is reproduced where all that is simulated for it lies within the limits, and contradicted where any "
    "point does not; its verdict says how many. It depends on unpublished gains where another leg and foot than the "
    "shipped ones of set 1, of which the thesis gives none, meet it at all speeds (see below). Limits and ranges are "
    "those of the claims above and of labbook sim figures, for the text gives few. Parameters are those of the shipped "
    "scenes: none was chosen for a verdict, but some of the emulator's for its apexes, and the bed's stiffness for the "
    "height that the small foot cleared. Beside a p value stands the saving that is simulated in its conditions."
)
_SIGNS = {"": "=", "less than": "<", "greater than": ">"}


def results_table(results: Sequence[JudgedResult]) -> Table:
    """Make the table of all published results; its CSV has the numbers unrounded."""
    caption = f"{_RESULTS_CAPTION} {verdict_counts(results)}"
    return table_of("published_results", caption, results, _RESULT_COLUMNS)


_PLURAL = {**{verdict: verdict for verdict in VERDICTS}, DEPENDS: DEPENDS.replace("depends", "depend")}


def verdict_counts(results: Sequence[JudgedResult]) -> str:
    """Count the verdicts: "Of 47: 7 reproduced, 8 contradicted, 32 not testable."."""
    counts = Counter(item.verdict for item in results)
    counted = [f"{counts[verdict]} {verdict if counts[verdict] == 1 else _PLURAL[verdict]}" for verdict in VERDICTS]
    return f"Of {len(results)}: {', '.join(counted)}."


def _published(result: PublishedResult) -> Cell:
    text = DASH
    if result.published is not None:
        number = given_text(result.published)
        text = f"{result.relation} {with_unit(number, result.unit)}".strip()
        text = f"p {_SIGNS[result.relation]} {number}" if result.unit == "p" else text
    return Cell(text, (result.published, result.unit, result.relation))


def _simulated(item: JudgedResult) -> Cell:
    found = item.finding
    if found is not None:
        return Cell(range_text(found), (found.lowest, found.median, found.highest, item.saving))
    text = DASH if item.saving is None else f"saves {decimal_text(100.0 * item.saving, 1)} %"
    return Cell(text, (None, None, None, item.saving))


def _limits(found: Finding | None) -> Cell:
    if found is None:
        return Cell(DASH, (None, None))
    return Cell(_limits_text(found.claim), (found.claim.at_least, found.claim.at_most))


def _verdict(item: JudgedResult) -> Cell:
    found = item.finding
    if found is None:
        return Cell(item.verdict, (item.verdict, None, None))
    at = f" at {found.n - found.n_within} of {found.n}" if not found.agrees and found.n > 1 else ""
    return Cell(item.verdict + at, (item.verdict, found.n_within, found.n))


_APEX = "apex"
_BESIDE = {
    **{(claim.column, gain): claim.beside for claim in experiment_claims() for gain in claim.gains},
    (_APEX, 200.0): "~0.335",
    (_APEX, 300.0): "~0.414",
}
"""Published words by column and gain; two apexes lie on the straight line between those that are given."""
_FACTORS = {"%": 100.0, "mm": 1e3, "ms": 1e3}


def _column(
    title: str, unit: str, field: str, value: Callable[[R], float], places: int = 0, published: str = ""
) -> ColumnOf[R]:
    """Make a column of simulated numbers, in the unit of `field`; the one `published` stands in brackets."""

    def cell(row: R) -> Cell:
        number = value(row)
        text = decimal_text(_FACTORS.get(unit, 1.0) * number, places)
        known = _BESIDE.get((published, row.gain))
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


_EMULATOR_CAPTION = (
    "on the ground emulator; in brackets what the thesis says (4.3, 4.4), with ~ on the straight line between the two "
    "apexes that it gives. Savings and lost apex heights are those of active damping against compression-extension "
    "(CE): scaled, its gain a sixth of the extension gain, and constant, a gain of 50. Joules are heat and mechanical "
    "energy of a whole jump. Sink: of the platform under CE. Capped: at the motors' stall torque. Within reach: the "
    "heat under CE while the extending leg drives the platform down, where active damping acts."
)
_PLATE_CAPTION = (
    "on the force plate, compression-extension. Of this experiment the thesis gives no apex and no joules, only the "
    "slope of the joules estimated from the plate's forces over those of the battery, "
    f"{ESTIMATED_OVER_MEASURED:g} (3.2.2): nothing stands beside these numbers. Touchdown: velocity of the body. "
    "Foot's loss: its kinetic energy when the plate stops it."
)
_BED_CAPTION = (
    "One drop onto the bed of glass beads in each of the 24 conditions; damping gain 0 is compression-extension. "
    "The thesis gives no joules and no apexes of these conditions, only what stands among the results below. "
    "Saving and apex gained: against compression-extension with the same foot, given by its radius, and the same "
    "extension gain. Joules are heat and mechanical energy of the stance. Capped: at the motors' stall torque."
)


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


_OPEN = (
    "Of set 1 (3.2) the thesis gives neither the foot's radius nor the leg's gains, but for that of active damping: "
    "the scene sim1 takes those of set 2, as assumed. Of 1024 legs and feet drawn from k_compression 100 to 300 N/m, "
    "k_extension 600 to 700 N/m, b_compression 0.5 to 10 and b_extension 0.5 to 15 kg/s and a radius of 15 to 30 mm, "
    "25 meet a saving of 15 to 25 %, 1.5 to 2.5 times the mechanical energy and apexes within 5 % at six speeds of "
    "touchdown from 0.5 to 1.75 m/s (benchmarks/unpublished_gains.py). Nor does Eq. 3.5 say of how many motors it is: "
    "labbook takes the heat of both, which share the current, and the drag of one. What other readings give at these "
    "speeds, with the limits that are not met:"
)


def document(
    tables: SteadyTables, findings: Sequence[Finding], results: Sequence[JudgedResult], readings: Sequence[Reading]
) -> str:
    """Write all of it as Markdown; the same on every machine."""
    return "\n\n".join(part.rstrip("\n") for part in _parts(tables, findings, results, readings)) + "\n"


def _parts(
    tables: SteadyTables, findings: Sequence[Finding], results: Sequence[JudgedResult], readings: Sequence[Reading]
) -> Iterator[str]:
    yield "# Published experiments, simulated"
    yield _filled("Written by `labbook sim published --out docs/published.md`; do not edit.")
    yield _filled(_INTRODUCTION)
    agreeing, unmatched = sum(finding.agrees for finding in findings), _unmatched(findings)
    silent = len(unmatched) - len(findings) + agreeing
    score = f"{agreeing} of {len(findings)} agree; for {silent} more the simulation gives nothing to compare."
    emulator, plate = (
        f"Jump {one.scene.jumps} of {one.scene.jumps} {caption}"
        for one, caption in ((tables.emulator, _EMULATOR_CAPTION), (tables.force_plate, _PLATE_CAPTION))
    )
    for title, table in (
        ("Ground emulator (thesis ch. 4)", table_of("emulator", emulator, tables.emulator.rows, _EMULATOR_COLUMNS)),
        ("Force plate (thesis 3.2.2)", table_of("force_plate", plate, tables.force_plate.rows, _PLATE_COLUMNS)),
        ("Granular bed (thesis ch. 5)", table_of("bed", _BED_CAPTION, tables.bed.rows, _BED_COLUMNS)),
        ("What agrees", claims_table(findings, f"{_CAPTION} {score}")),
        ("Every published result", results_table(results)),
    ):
        yield f"## {title}"
        caption, rows = markdown_text(table).split("\n\n")
        yield _filled(caption)
        yield rows
    yield "## What set 1 leaves open"
    yield _filled(_OPEN)
    texts: list[str] = []
    for reading in readings:  # what it gives, and which claims it does not meet at every speed
        found = (f"`{one.claim.id}` {range_text(one)}{_missed_text(one)}" for one in reading.findings)
        texts.append(_filled(f"- **{reading.name}**: {'; '.join(found)}.", "  "))
    yield "\n".join(texts)
    yield "## What cannot be matched, and why"
    for claim in unmatched:
        reason = claim.reason or "no reason is known."
        yield _filled(f"**{claim.id}** ({claim.where}): {claim.statement}. {reason}")
    yield "## Where the thesis contradicts itself"
    yield "\n".join(_filled(f"- **{item.where}**: {item.text}", "  ") for item in contradictions())
    yield "## What it rests on"
    yield _filled(f"Simulated for a relative error of {plain_number(tables.accuracy)}. {_GAINS}")
    for scene in (tables.emulator.scene, tables.force_plate.scene, tables.bed.scene):
        jumps = "one jump" if scene.jumps == 1 else f"{scene.jumps} jumps"
        yield _filled(f"Scene `{scene.name}`, {jumps}. {scene.description} Assumed:")
        yield "\n".join(_filled(f"- {text}", "  ") for text in assumed_texts(scene))


def _missed_text(found: Finding) -> str:
    """Say at how many points a claim does not hold, and what it asks for; nothing where it holds at all."""
    if found.agrees:
        return ""
    return f" (not {_limits_text(found.claim)} at {found.n - found.n_within} of {found.n})"


def _unmatched(findings: Sequence[Finding]) -> list[Claim]:
    agreeing = {finding.claim.id for finding in findings if finding.agrees}
    return [claim for claim in experiment_claims() if claim.id not in agreeing]


def as_data(
    tables: SteadyTables, findings: Sequence[Finding], results: Sequence[JudgedResult], readings: Sequence[Reading]
) -> dict[str, Any]:
    """Return everything for JSON: SI units, shares as fractions."""
    by_id, reasons = {one.claim.id: one for one in findings}, {claim.id: claim.reason for claim in _unmatched(findings)}
    return {
        "accuracy": tables.accuracy,
        "emulator": _experiment(
            tables.emulator.scene,
            tables.emulator.rows,
            ("scaled_saving", "constant_saving", "scaled_loss", "constant_loss"),
        ),
        "force_plate": _experiment(tables.force_plate.scene, tables.force_plate.rows, ("battery_j",)),
        "bed": _experiment(tables.bed.scene, tables.bed.rows, ("saving", "apex_gain_m")),
        "published": [
            {
                **asdict(claim),
                **({} if claim.id not in by_id else {**asdict(by_id[claim.id]), "claim": claim.id}),
                "compared": claim.id in by_id,
                "agrees": claim.id not in reasons,
                "reason": reasons.get(claim.id, ""),
            }
            for claim in experiment_claims()
        ],
        "agreeing": sum(finding.agrees for finding in findings),
        "results": results_table(results).records,
        "readings": [
            {
                "reading": reading.name,
                "of_unpublished": reading.of_unpublished,
                "findings": [{**asdict(one), "claim": one.claim.id, "agrees": one.agrees} for one in reading.findings],
            }
            for reading in readings
        ],
        "contradictions": [asdict(item) for item in contradictions()],
    }


def _experiment(
    scene: Scene, rows: Sequence[EmulatorRow | PlateRow | BedRow], derived: Sequence[str]
) -> dict[str, Any]:
    """Return a table with its scene; `derived` are properties of its rows."""
    return {
        "scene": scene.name,
        "jumps": scene.jumps,
        "assumed": {name: {"value": scene[name], "why": scene.values[name].why} for name in scene.assumed},
        "rows": [{**asdict(row), **{name: getattr(row, name) for name in derived}} for row in rows],
    }


def _filled(text: str, indent: str = "") -> str:
    return textwrap.fill(text, 120, break_long_words=False, break_on_hyphens=False, subsequent_indent=indent)
