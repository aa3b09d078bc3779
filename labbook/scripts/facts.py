"""What was measured of the runs behind a number: their values as a report of the same runs has them, by condition.

The table beside a script has it, of each run or of each jump, with the columns' meanings and units.
"""

from __future__ import annotations

import csv
import hashlib
import io
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import sqlalchemy as sa

from data_schema.errors import UsageError
from data_schema.outcomes import Outcome
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import CalibratedChannel
from data_schema.vocabulary import Undefined
from ingest.store import Store
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.contrasts import AskedContrast, asked_contrasts
from labbook.analysis.comparison.order import ADJUSTED, adjusted_for_position
from labbook.analysis.comparison.pairing import Pair
from labbook.analysis.comparison.robustness import with_void, without_day
from labbook.analysis.outcomes.charger_step import rounding_in, with_rounding_of
from labbook.analysis.outcomes.conditions import ConditionValues, RunNumber, condition_values, measure
from labbook.analysis.outcomes.detection import BODY_HEIGHT, Detections
from labbook.analysis.outcomes.run_apexes import ApexVariant, as_protocol, run_apexes, without_exclusions
from labbook.analysis.outcomes.run_energy import Recharge, RunEnergy, idle_charges
from labbook.analysis.outcomes.run_force import ALL_RULES, PushOffRules, RunForce, run_forces_by_rules
from labbook.analysis.prediction.checking import AllPredicted, side_of
from labbook.analysis.prediction.predicting import predictions
from labbook.analysis.prediction.simulating import ALWAYS, SIMULATED
from labbook.analysis.preregistration.planned import Planned, planned_analysis
from labbook.analysis.results import Results
from labbook.analysis.study_data import StudyData, gather
from labbook.config.parsing import Configuration
from reports.results import WITHOUT_EXCLUSIONS
from stats.apexes.detectors import DETECTORS

Cell = str | float | int
Row = Mapping[str, Cell]


@dataclass(frozen=True, slots=True)
class Script:
    """A number's script.

    Parameters
    ----------
    rows : of the table, whose columns `COLUMNS` describes
    steps : functions of templates, each applied to what the one before returns; the first takes
        the table's rows, the last returns the number
    settings : values of the templates' constants, by name
    table : the name of the table's file
    """

    rows: Sequence[Row]
    steps: Sequence[str]
    settings: Mapping[str, object] = field(default_factory=dict)
    table: str = "runs.csv"


@dataclass(frozen=True, slots=True)
class Asked:
    """A number that a script is asked for: its name, and the scope of its result."""

    name: str
    scope: Mapping[str, Any]

    @property
    def outcome(self) -> Outcome:
        """The outcome that it is of: joules where the result names none, as of savings."""
        return {str(each): each for each in Outcome}.get(str(self.scope.get("quantity")), Outcome.JOULES)

    @property
    def variant(self) -> str:
        """The variant of the analysis that it is of, "" of the report's own."""
        return str(self.scope.get("variant", ""))


WITHOUT = "without "
_RULES = {str(rules): rules for rules in ALL_RULES}


@dataclass(frozen=True, slots=True)
class Varied:
    """The facts of a variant of the analysis, and by which jumps.

    `day` is one that is left out, "" where none is; `rules` are those of single jumps on a plate, where not the
    protocol's.
    """

    evidence: StudyData
    jumps: ApexVariant
    day: str = ""
    rules: PushOffRules | None = None


@dataclass(frozen=True)
class Facts:
    """The facts of the runs that a report selects, in a book as it was when the report was made."""

    connection: sa.Connection
    store: Store
    configuration: Configuration
    selection: str
    _found: dict[tuple[Outcome, str], list[ConditionValues]] = field(default_factory=dict)

    @cached_property
    def evidence(self) -> StudyData:
        """The selected runs with what was measured of them."""
        return gather(self.connection, self.configuration, self.selection or None)

    @cached_property
    def planned(self) -> Planned:
        """The settings of the analysis."""
        selected = frozenset(run.uid for run in self.evidence.selected)
        return planned_analysis(self.connection, self.configuration, selected)

    @property
    def swept(self) -> str:
        """The factor with a control, "" where none has one."""
        return pairing.swept_factor(self.configuration) or ""

    def varied(self, variant: str) -> Varied:
        """Return the facts of a variant of the analysis; raises `UsageError` where it has no script."""
        protocol = as_protocol(self.evidence)
        detector = variant.removeprefix("with the ").removesuffix(" detector")
        if variant in ("", ADJUSTED):
            return Varied(self.evidence, protocol)
        if variant == WITHOUT_EXCLUSIONS:
            return Varied(with_void(self.evidence), without_exclusions(self.evidence))
        if variant.startswith(WITHOUT):
            day = variant.removeprefix(WITHOUT)
            return Varied(without_day(self.evidence, day), protocol, day)
        if detector in DETECTORS:
            return Varied(self.evidence, replace(protocol, detector=detector))
        if variant in _RULES:
            return Varied(self.evidence, protocol, rules=_RULES[variant])
        raise UsageError(
            f"the number is of the variant {variant!r}, which has no script: ask for the same number of the report's "
            f"own way, {WITHOUT_EXCLUSIONS}, without a day, by another detector or other rules, or {ADJUSTED}."
        )

    def conditions(self, outcome: Outcome, variant: str = "") -> list[ConditionValues]:
        """Return the conditions of the runs, in the order in which a report has them."""
        if (outcome, variant) not in self._found:
            self._found[outcome, variant] = self._measured(outcome, variant)
        return self._found[outcome, variant]

    def _measured(self, outcome: Outcome, variant: str) -> list[ConditionValues]:
        varied = self.varied(variant)
        found = self._conditions(varied, outcome)
        if not varied.day:
            return found
        # whether runs are rounded alike is decided by those of all days
        of_all_days = {item.run.uid: item.shared for one in self.conditions(outcome) for item in one.runs}
        return [
            replace(
                one,
                runs=tuple(
                    replace(
                        item,
                        shared=with_rounding_of(rounding_in(item.shared, without=True), of_all_days[item.run.uid]),
                    )
                    for item in one.runs
                ),
            )
            for one in found
        ]

    def conditions_beside(self, outcome: Outcome) -> list[ConditionValues]:
        """Return the conditions of which the selection takes no run, which count in a planned family of tests."""
        if not self.planned.stated or not self.evidence.beside:
            return []
        beside = replace(self.evidence, runs=self.evidence.beside)
        return self._conditions(Varied(beside, as_protocol(self.evidence)), outcome)

    def _conditions(self, varied: Varied, outcome: Outcome) -> list[ConditionValues]:
        evidence, computed, detections = varied.evidence, Results(), Detections(self.connection, self.store)
        found = measure(outcome, computed, detections, evidence, varied.jumps).results
        if varied.rules is not None:
            single = [uid for uid, force in found.items() if isinstance(force, RunForce) and force.single_jumps]
            found = {**found, **run_forces_by_rules(computed, detections, evidence, single)[varied.rules]}
        return condition_values(computed, evidence.runs, found, outcome)

    @property
    def settings(self) -> dict[str, object]:
        """The settings of templates that are the study's."""
        return {"REFERENCE_VOLTAGE_V": float(self.evidence.study.reference_voltage_v)}

    def decision_level(self, outcome: Outcome) -> float:
        """Return the level of the intervals of comparisons."""
        settings = self.planned.settings
        return 1.0 - (2.0 if settings.one_sided and outcome.has_savings else 1.0) * settings.alpha

    def pooled(self, outcome: Outcome, variant: str = "") -> list[Pair]:
        """Return the comparisons of all levels with the control, one a group; adjusted for position where asked for."""
        found = pairing.pairs_pooled(self.conditions(outcome, variant), self.swept)
        adjusted = adjusted_for_position(found) if variant == ADJUSTED else found
        return found if isinstance(adjusted, Undefined) else adjusted

    def contrasts(self) -> dict[str, AskedContrast]:
        """Return the contrasts of means of the plan, or those that the factors suggest, by their labels."""
        settings = self.planned.settings
        outcomes = {each.outcome for each in settings.contrasts} or {each for each in Outcome if each.has_savings}
        conditions = {outcome: self.conditions(outcome) for outcome in Outcome if outcome in outcomes}
        values = pairing.treated_values(self.configuration, self.swept)
        return asked_contrasts(settings.contrasts, conditions, self.swept, values)

    @cached_property
    def predicted(self) -> AllPredicted:
        """What is predicted for every condition of an outcome that is simulated, by its key and a robot's uid."""
        conditions = {outcome: self.conditions(outcome) for outcome in SIMULATED}
        keys = list(dict.fromkeys(one.key for several in conditions.values() for one in several))
        wanted = [outcome for outcome in SIMULATED if outcome in ALWAYS or conditions[outcome]]
        return predictions(Results(), self.connection, self.evidence, keys, lambda _step: None, wanted)

    def is_simulated(self, condition: ConditionValues, outcome: Outcome, *, varied: bool = False) -> bool:
        """Return whether there is a prediction for all runs of a condition; with `varied`, one with an error."""
        found = [one for one, _runs in side_of([condition], self.predicted)]
        return all(one.value(outcome) is not None for one in found) and not (
            varied and any(None in values for one in found for values in one.varied(outcome).values())
        )

    def pairs(self, outcome: Outcome, variant: str = "") -> list[Pair]:
        """Return what the planned families compare, in order."""
        return pairing.pairs_with_control(self.conditions(outcome, variant), self.swept)


def keys_of(pair: Pair) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the conditions of both sides of a comparison by their keys, the control's first."""
    return tuple(one.key for one in pair.a), tuple(one.key for one in pair.b)


def conditions_in(pairs: Sequence[Pair]) -> list[ConditionValues]:
    """Return the conditions that some comparisons are of, each once."""
    found: Mapping[str, ConditionValues] = {one.key: one for pair in pairs for one in (*pair.a, *pair.b)}
    return list(found.values())


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
