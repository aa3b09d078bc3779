"""Joules a jump of each run: 3.6 x voltage x (charge - passive charge) / jumps made (thesis 5.1.4).

The passive charge is what the drain line gives at the run's own duration; the line is fitted to all idle runs of the
robot in the study.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from data_schema.errors import InputRefused
from data_schema.queries.charges import ChargeOfRun
from data_schema.queries.runs import RunRow
from data_schema.queries.sources import InputRow
from data_schema.reasons import Reason
from data_schema.units import MAH_TO_COULOMB
from data_schema.vocabulary import ChargeMode, Undefined
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.run_apexes import ApexVariant
from labbook.analysis.results import (
    Algorithm,
    Results,
    RunResults,
    charge_input,
    fingerprint,
    idle_runs_input,
    interval_ends,
    result_fingerprint,
    run_input,
)
from labbook.analysis.study_data import StudyData
from labbook.config.parsing import Configuration
from reports.numbers import Number, Origin, Result
from reports.results import MAH_MIN, Drain, DrainFit, IdleRun
from stats.checks import as_number
from stats.compare.shared_error import SharedError
from stats.lines.passive_drain import DrainEstimate, PassiveDrain, fit_passive_drain, rounding_sd_mah, why_no_line
from stats.scatter import finite

DRAIN = Algorithm("passive_drain", 16)


@dataclass(frozen=True, slots=True)
class Recharge:
    """What was put back after a run: the sum of its charges, where the pack was charged in parts.

    `resolution_mah` is the step of one reading with the same rounding error.
    """

    charge_mah: float
    resolution_mah: float
    charges: tuple[ChargeOfRun, ...]


def recharge_of(run: RunRow, charges: Sequence[ChargeOfRun]) -> Recharge | Undefined:
    """Return what a run of known duration took: its one charge, and what was added to that; or why there is none."""
    charged = [item for item in charges if item.mode == ChargeMode.CHARGE]
    first = [item for item in charged if not item.added]
    if not first:
        return Undefined(Reason.PART_OF_CHARGE if charged else Reason.NO_CHARGE)
    if len(first) > 1:
        return Undefined(Reason.SEVERAL_CHARGES, n=len(first))
    if run.duration_s is None:
        return Undefined(Reason.NO_DURATION)
    resolution_mah = math.hypot(*(item.resolution_mah for item in charged))
    return Recharge(sum(item.charge_mah for item in charged), resolution_mah, tuple(charged))


def only_charge_missing(runs: Sequence[RunRow], charges: Mapping[str, Sequence[ChargeOfRun]]) -> list[RunRow]:
    """Return the runs of jumps that would have joules if they had a charge; `charges` are by the run's uid."""
    known = [(run, recharge_of(run, charges.get(run.uid, ()))) for run in runs if run.duration_s and run.jumps_made]
    return [run for run, why in known if isinstance(why, Undefined) and why.code is Reason.NO_CHARGE]


def idle_charges(evidence: StudyData) -> list[tuple[RunRow, Recharge]]:
    """Return the idle runs that can be fitted: with a duration and a charge."""
    found = [(run, recharge_of(run, evidence.charges.get(run.uid, []))) for run in evidence.idle]
    return [(run, charge) for run, charge in found if not isinstance(charge, Undefined)]


def unused_idle(evidence: StudyData) -> list[tuple[RunRow, Undefined]]:
    """Return the idle runs that cannot be fitted, and why."""
    found = [(run, recharge_of(run, evidence.charges.get(run.uid, []))) for run in evidence.idle]
    return [(run, reason) for run, reason in found if isinstance(reason, Undefined)]


def drain_lines(evidence: StudyData) -> dict[str, PassiveDrain | Undefined]:
    """Fit a line through the idle runs of each robot that has idle or jump runs, by the robot's uid."""
    idle = idle_charges(evidence)
    robots = dict.fromkeys(run.robot_uid for run in (*evidence.idle, *evidence.runs))
    return {robot: _fit([item for item in idle if item[0].robot_uid == robot]) for robot in robots}


def passive_drains(computed: Results, evidence: StudyData, variant: str | None = None) -> dict[str, Drain]:
    """Return each robot's line and what it gives at a run's duration; `variant` names a recomputation."""
    duration_s = evidence.configuration.protocol.run_duration_s
    names = {run.robot_uid: run.robot for run in (*evidence.idle, *evidence.runs)}
    idle = idle_charges(evidence)
    found = {}
    for robot, line in drain_lines(evidence).items():
        inputs, own = [idle_runs_input(robot)], [item for item in idle if item[0].robot_uid == robot]
        for run, charge in own:
            inputs += [run_input(run), *map(charge_input, charge.charges)]
        about = {"robot": names[robot]} | ({"variant": variant} if variant else {})
        fit = computed.record(DRAIN, about, inputs, _drain_fit(line, duration_s), {"run_duration_s": duration_s})
        runs = tuple(IdleRun(run.name, run.duration_s or 0.0, charge.charge_mah) for run, charge in own)
        found[robot] = Drain(names[robot], line, fit, runs)
    return found


def _fit(idle: list[tuple[RunRow, Recharge]]) -> PassiveDrain | Undefined:
    durations_s = [run.duration_s or 0.0 for run, _ in idle]
    none = why_no_line(durations_s)
    if none is not None:
        return none
    return fit_passive_drain(
        durations_s,
        [charge.charge_mah for _, charge in idle],
        resolution_mah=max((charge.resolution_mah for _, charge in idle)),
    )


def _drain_fit(drain: PassiveDrain | Undefined, duration_s: float | None) -> DrainFit:
    if isinstance(drain, Undefined):
        slope, intercept, r_squared, at_run = (Number(drain, unit) for unit in ("mAh/min", "mAh", "1", "mAh"))
        return DrainFit(slope, intercept, r_squared, at_run)
    low, high = interval_ends(drain.slope_ci_mah_s(), MAH_MIN)
    from_low, from_high = interval_ends(drain.intercept_ci_mah())
    slope = Number(
        drain.slope_mah_s * MAH_MIN, "mAh/min", drain.slope_se_mah_s * MAH_MIN, ci_low=low, ci_high=high, df=drain.df,
        n=drain.n,
    )  # fmt: skip
    intercept = Number(
        drain.intercept_mah, "mAh", drain.intercept_se_mah, ci_low=from_low, ci_high=from_high, df=drain.df, n=drain.n
    )
    r_squared = Number(drain.r_squared, "1", n=drain.n)
    if duration_s is None:
        duration_s = drain.duration_mean_s
    found = drain.at(duration_s)
    return DrainFit(
        slope=slope,
        intercept=intercept,
        r_squared=r_squared,
        at_run=Number(
            found.charge_mah,
            "mAh",
            found.se,
            ci_low=found.ci_low,
            ci_high=found.ci_high,
            ci_level=found.level,
            df=found.df,
            n=drain.n,
        ),
        run_duration_s=duration_s,
        extrapolated=found.extrapolated,
    )


@dataclass(frozen=True, slots=True)
class RunEnergy(Result):
    """Joules a jump of a run, the charge that was put back, and the passive charge that was taken off.

    `step_mah` is that of the charge's rounding. `drain_df` and `shared_terms_j` are the error of the drain line in
    joules a jump: degrees of freedom, and a signed standard error a term. `extrapolated`: the run's duration lies
    outside those of the idle runs.
    """

    joules_per_jump: Number
    passive_charge: Number
    drain_df: float
    shared_terms_j: Mapping[str, float]
    extrapolated: bool
    charge_mah: float
    step_mah: float

    @property
    def shared_error(self) -> SharedError:
        """What these joules share with those of other runs: the errors of the robot's drain line."""
        fit = next(item.input_uid for item in self.origin.inputs if item.role == "drain")
        return SharedError({(fit, term): size for term, size in self.shared_terms_j.items()}, {fit: self.drain_df})


RUN_ENERGY = Algorithm("run_energy", 14)


def usable_charge(run: RunRow, charges: list[ChargeOfRun]) -> Recharge | Undefined:
    """Return the charge that a jump run's energy is computed from, or why there is none."""
    charge = recharge_of(run, charges)
    return charge if isinstance(charge, Undefined) or run.jumps_made else Undefined(Reason.NO_JUMP_MADE)


def below_drain(run: RunRow, charges: list[ChargeOfRun], line: PassiveDrain | Undefined) -> tuple[float, float] | None:
    """Return a run's charge and its passive charge, in mAh, where the charge is the lesser and joules are negative.

    None where it is not, or where one of them is unknown.
    """
    charge = usable_charge(run, charges)
    if isinstance(charge, Undefined) or isinstance(line, Undefined) or run.duration_s is None:
        return None
    passive_mah = line.charge_at(run.duration_s)
    return (charge.charge_mah, passive_mah) if charge.charge_mah < passive_mah else None


def above_capacity(run: RunRow, charges: Sequence[ChargeOfRun], configuration: Configuration) -> str | None:
    """Say which charge of a run is more than its pack holds; None where none is."""
    pack = configuration.batteries.get(run.battery)
    above = [charge.charge_mah for charge in charges if pack is not None and charge.charge_mah > pack.capacity_mah]
    if pack is None or not above:
        return None
    return f"a charge of {above[0]:g} mAh, more than the {pack.capacity_mah:g} mAh that pack {run.battery} holds"


def run_energies(
    computed: Results, evidence: StudyData, drains: Mapping[str, Drain], variant: str | None = None
) -> RunResults[RunEnergy]:
    """Compute the energy of every selected jump run that has what it takes; `variant` names a recomputation."""
    found: dict[str, RunEnergy] = {}
    missing: dict[str, Undefined] = {}
    voltage_v = evidence.study.reference_voltage_v
    nowhere = Origin()  # until `record` says it
    voltage = fingerprint("voltage", "study", evidence.study.uid, repr(voltage_v))
    for run in evidence.runs:
        charge = usable_charge(run, evidence.charges.get(run.uid, []))
        drain = drains[run.robot_uid]
        if isinstance(charge, Undefined):
            missing[run.uid] = charge
        elif isinstance(drain.line, Undefined):
            missing[run.uid] = Undefined(Reason.NO_DRAIN_FIT, robot=drain.robot)
        else:
            found[run.uid] = computed.record(
                RUN_ENERGY,
                {"run": run.name} | ({"variant": variant} if variant else {}),
                (
                    run_input(run),
                    *map(charge_input, charge.charges),
                    result_fingerprint("drain", drain.result),
                    voltage,
                ),
                _energy(run, charge, drain.line, voltage_v, nowhere),
            )
    return RunResults(found, missing)


def energies_with_drains(
    runs: Sequence[RunRow],
    charges: Mapping[str, list[ChargeOfRun]],
    lines: Mapping[str, PassiveDrain | Undefined],
    voltage_v: float,
) -> dict[str, RunEnergy]:
    """Return the energy of every run that has what it takes, with lines by the robot's uid, without ids."""
    found = {}
    origins = {robot: Origin(inputs=(InputRow("drain", "result", robot, ""),)) for robot in lines}
    for run in runs:
        charge, line = usable_charge(run, charges.get(run.uid, [])), lines[run.robot_uid]
        if not isinstance(charge, Undefined) and not isinstance(line, Undefined):
            found[run.uid] = _energy(run, charge, line, voltage_v, origins[run.robot_uid])
    return found


def _energy(run: RunRow, charge: Recharge, drain: PassiveDrain, voltage_v: float, origin: Origin) -> RunEnergy:
    assert run.duration_s is not None  # noqa: S101 - `usable_charge` has asked
    passive, error_terms_mah = _passive_charge(drain, run.duration_s)
    j_per_mah = joules_per_mah(voltage_v, run.jumps_made)
    joules = joules_per_jump(charge.charge_mah, passive.charge_mah, voltage_v, run.jumps_made)
    return RunEnergy(
        origin=origin,
        joules_per_jump=Number(
            joules,
            "J",
            se=j_per_mah * rounding_sd_mah(charge.resolution_mah),
            shared_se=j_per_mah * passive.se,
            n=run.jumps_made,
        ),
        passive_charge=Number(passive.charge_mah, "mAh", shared_se=passive.se, n=drain.n, df=drain.df),
        drain_df=drain.df,
        shared_terms_j={term: -j_per_mah * mah for term, mah in error_terms_mah.items()},
        extrapolated=passive.extrapolated,
        charge_mah=charge.charge_mah,
        step_mah=charge.resolution_mah,
    )


@lru_cache(maxsize=1024)  # many runs are as long
def _passive_charge(drain: PassiveDrain, duration_s: float) -> tuple[DrainEstimate, Mapping[str, float]]:
    return drain.at(duration_s), drain.error_terms_mah(duration_s)


def joules_per_jump(
    charge_mah: float, passive_mah: float, reference_voltage_v: float, jumps_made: int
) -> float | Undefined:
    """Return the energy of one jump in joules; `Undefined` where no jump was made.

    Jumps made, not jumps detected. Raises `InputRefused` for values that are not finite, a voltage that is not
    positive or a negative count.
    """
    charge_mah = as_number("the charge", charge_mah, low=0.0)
    passive_mah = as_number("the passive charge", passive_mah)
    if jumps_made < 0:
        raise InputRefused(f"jumps made is {jumps_made}: give a count of 0 or more.")
    if jumps_made == 0:
        return Undefined(Reason.NO_JUMP_MADE)
    joules = joules_per_mah(reference_voltage_v, jumps_made) * (charge_mah - passive_mah)
    return finite(joules, "the energy of a jump")


def joules_per_mah(reference_voltage_v: float, jumps_made: float) -> float:
    """Return the joules a jump of one mAh: 2.2 J at 15.4 V and 25 jumps."""
    voltage = as_number("the reference voltage", reference_voltage_v, above=0.0)
    per_mah = MAH_TO_COULOMB * voltage / as_number("jumps made", jumps_made, above=0.0)
    if not 0.0 < per_mah < math.inf:
        raise InputRefused(f"a mAh is worth {per_mah:g} J a jump: check voltage and jumps made.")
    return per_mah


def measured(
    computed: Results, _detections: Detections, data: StudyData, _variant: ApexVariant
) -> RunResults[RunEnergy]:
    """Compute the energies, whatever jumps count."""
    return run_energies(computed, data, passive_drains(computed, data))
