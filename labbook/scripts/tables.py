"""The table beside a script: what was measured of each run, or of each jump, with the columns' meanings and units."""

from __future__ import annotations

import csv
import hashlib
import io
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import CalibratedChannel
from labbook.analysis.outcomes.charger_step import rounding_in
from labbook.analysis.outcomes.conditions import ConditionValues, RunNumber
from labbook.analysis.outcomes.detection import BODY_HEIGHT, Detections
from labbook.analysis.outcomes.run_apexes import run_apexes
from labbook.analysis.outcomes.run_energy import Recharge, RunEnergy, idle_charges
from labbook.analysis.results import Results
from labbook.scripts.facts import Facts
from labbook.scripts.script import Cell, Row

COLUMNS: Mapping[str, str] = {
    "kind": "jumps or idle: runs of jumps, and runs without jumps for the passive drain",
    "run": "name of the run",
    "day": "day on which it was made",
    "position_in_day": "its place among the runs of its day, from 1",
    "robot": "robot; each has its own drain line",
    "battery": "battery pack",
    "condition": "levels of the factors",
    "charge_mah": "charge put back after the run, mAh",
    "resolution_mah": "step in which the charger shows it, mAh",
    "duration_s": "from power on to power off, s",
    "jumps_made": "jumps made, not jumps found",
    "rounded_alike": "yes where repeats scatter by less than half a step, so that they share the error of rounding",
    "jump": "number of the jump in its run; jumps that do not count are left out",
    "apex_height_m": "apex height of the jump, m",
    "calibration": "calibration that the height was measured with",
    "calibration_df": "degrees of freedom of its fit",
    "height_sign": "height = sign * (scale * sensor reading + zero)",
    "height_scale": "see height_sign",
    "height_zero": "see height_sign",
    "calibration_scale": "scale of the calibration itself",
    "error_slopes": "of each independent error of the calibration, standard error = slope * reading + intercept",
    "error_intercepts": "see error_slopes",
    "value": "what was measured of the run",
    "simulated": "what the simulator gives for the run's condition and robot, in the unit of what was measured",
    "simulated_error": "relative error of the simulation: its accuracy, or what rounding grows to",
    "varied": "assumed parameters, each once lowered and once raised, between semicolons",
    "simulated_varied": "what the simulator gives with each of them so, between semicolons; nan without an apex",
}


_READING = {Outcome.JOULES: "joules_of_runs", Outcome.APEX: "heights_of_runs"}


def reading_of(outcome: Outcome) -> str:
    """Return the function of the templates that gives the values of runs from the rows of a table."""
    return _READING.get(outcome, "measured_of_runs")


def rows_of(facts: Facts, conditions: Sequence[ConditionValues], outcome: Outcome, variant: str = "") -> list[Row]:
    """Return the rows of the runs of some conditions: charges with idle runs, heights of jumps, or values."""
    if outcome is Outcome.JOULES:
        robots = {item.run.robot_uid for one in conditions for item in one.runs}
        return [*idle_rows(facts, robots, variant), *(_charged(item) for one in conditions for item in one.runs)]
    if outcome is Outcome.APEX:
        return list(_heights(facts, conditions, variant))
    return [{**_run(item.run), "value": item.value} for one in conditions for item in one.runs]


def rows_with_simulated(
    facts: Facts, conditions: Sequence[ConditionValues], outcome: Outcome, variant: str = ""
) -> list[Row]:
    """Return the rows of the runs of some conditions, with what was simulated for each."""
    simulated: dict[Cell, Row] = {}
    for item in (item for one in conditions for item in one.runs):
        found = facts.predicted[item.run.condition_key, item.run.robot_uid]
        varied = [(name, value) for name, values in found.varied(outcome).items() for value in values]
        simulated[item.run.name] = {
            "simulated": _number(found.value(outcome)),
            "simulated_error": found.relative_error,
            "varied": ";".join(name for name, _value in varied),
            "simulated_varied": ";".join(repr(_number(value)) for _name, value in varied),
        }
    return [{**row, **simulated.get(row["run"], {})} for row in rows_of(facts, conditions, outcome, variant)]


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def idle_rows(facts: Facts, robots: Iterable[str], variant: str = "") -> list[Row]:
    """Return the idle runs of robots, by their uids, that a drain line is fitted to."""
    wanted = set(robots)
    return [
        {**_run(run), "kind": "idle", **_charge(run, recharge)}
        for run, recharge in idle_charges(facts.varied(variant).evidence)
        if run.robot_uid in wanted
    ]


def table_bytes(rows: Sequence[Row]) -> bytes:
    """Write rows as CSV, floats with all their digits."""
    columns = [name for name in COLUMNS if any(name in row for row in rows)]
    file = io.StringIO(newline="")
    writer = csv.DictWriter(file, columns, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(
        {name: repr(cell) if isinstance(cell, float) else cell for name, cell in row.items()} for row in rows
    )
    return file.getvalue().encode()


def columns_in(rows: Sequence[Row]) -> dict[str, str]:
    """Return the columns that rows have, with what they mean."""
    return {name: meaning for name, meaning in COLUMNS.items() if any(name in row for row in rows)}


def _run(run: RunRow) -> Row:
    return {
        "kind": "jumps",
        "run": run.name,
        "day": run.day,
        "position_in_day": run.position_in_day,
        "robot": run.robot,
        "battery": run.battery,
        "condition": run.condition_key,
    }


def _charge(run: RunRow, recharge: Recharge) -> Row:
    return {
        "charge_mah": recharge.charge_mah,
        "resolution_mah": recharge.resolution_mah,
        "duration_s": run.duration_s or 0.0,
    }


def _charged(item: RunNumber) -> Row:
    energy = item.result
    assert isinstance(energy, RunEnergy)  # noqa: S101 - joules are measured of nothing else
    return {
        **_run(item.run),
        **_charge(item.run, Recharge(energy.charge_mah, energy.step_mah, ())),
        "jumps_made": item.run.jumps_made,
        "rounded_alike": "yes" if rounding_in(item.shared).terms else "",
    }


def _heights(facts: Facts, conditions: Sequence[ConditionValues], variant: str) -> Iterator[Row]:
    varied = facts.varied(variant)
    found = run_apexes(Results(), Detections(facts.connection, facts.store), varied.evidence, varied.jumps)
    calibrated = {
        log.sha256: channel
        for logs in varied.evidence.logs.values()
        for log in logs
        for channel in varied.evidence.calibrated.get(log.uid, ())
        if channel.name == BODY_HEIGHT
    }
    for item in (item for one in conditions for item in one.runs):
        for jump in found.judgements[item.run.uid].jumps:
            if jump.excluded is None and jump.jump.apex_height_m is not None:
                yield {
                    **_run(item.run),
                    "jump": jump.jump.number,
                    "apex_height_m": jump.jump.apex_height_m,
                    **_calibration(calibrated.get(jump.signal_sha256)),
                }


def _calibration(channel: CalibratedChannel | None) -> Row:
    if channel is None or not channel.calibration.errors:
        return {}
    slopes, intercepts = zip(*channel.calibration.errors, strict=True)
    return {
        "calibration": hashlib.sha256(repr(channel.calibration).encode()).hexdigest()[:12],
        "calibration_df": float("inf") if channel.calibration.df is None else channel.calibration.df,
        "height_sign": channel.sign,
        "height_scale": channel.scale,
        "height_zero": channel.zero_offset,
        "calibration_scale": channel.calibration.scale,
        "error_slopes": " ".join(map(repr, slopes)),
        "error_intercepts": " ".join(map(repr, intercepts)),
    }
