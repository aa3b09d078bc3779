"""Joules a jump of each run: 3.6 x voltage x (charge - passive charge) / jumps made (thesis 5.1.4)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from data_schema.queries.charges import ChargeOfRun
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.energy import joules_per_jump, joules_per_mah
from labbook.analysis.outcomes.passive_drain import Drain, DrainFit, recharge_of
from labbook.analysis.outcomes.run_results import RunResults
from labbook.analysis.results.codec import Algorithm, StoredResult
from labbook.analysis.results.facts import charge_input, run_input
from labbook.analysis.results.result_cache import Request, ResultCache, fingerprint, result_fingerprint
from labbook.analysis.study_data import StudyData
from reports.numbers import Number
from stats.compare.shared_error import SharedError
from stats.lines.passive_drain import PassiveDrain, rounding_sd_mah


@dataclass(frozen=True, slots=True)
class RunEnergy(StoredResult):
    """Joules a jump of a run, and the passive charge that was taken off.

    `drain_df` and `shared_terms_j` are the error of the drain line in joules a jump: degrees of freedom, and a signed
    standard error a term. `extrapolated`: the run's duration lies outside those of the idle runs.
    """

    joules_per_jump: Number
    passive_charge: Number
    drain_df: float
    shared_terms_j: Mapping[str, float]
    extrapolated: bool

    @property
    def shared_error(self) -> SharedError:
        """What these joules share with those of other runs: the errors of the robot's drain line."""
        fit = next(item.input_uid for item in self.origin.inputs if item.role == "drain")
        return SharedError({(fit, term): size for term, size in self.shared_terms_j.items()}, {fit: self.drain_df})


ALGORITHM = Algorithm("run_energy", 13, RunEnergy)


def usable_charge(run: RunRow, charges: list[ChargeOfRun]) -> ChargeOfRun | str:
    """Return the one charge that a jump run's energy rests on, or why there is none."""
    charge = recharge_of(run, charges)
    return charge if isinstance(charge, str) or run.jumps_made else "no jumps made"


def run_energies(
    cache: ResultCache, evidence: StudyData, drains: Mapping[str, Drain], variant: str | None = None
) -> RunResults[RunEnergy]:
    """Ensure the energy of every selected jump run that has what it takes; `variant` names a recomputation."""
    requests: dict[str, Request[RunEnergy]] = {}
    missing: dict[str, str] = {}
    for run in evidence.runs:
        charge = usable_charge(run, evidence.charges.get(run.uid, []))
        drain = drains[run.robot_uid]
        if isinstance(charge, str):
            missing[run.uid] = charge
        elif isinstance(drain.line, Undefined):
            missing[run.uid] = f"no passive-drain fit for robot {drain.robot}"
        else:
            requests[run.uid] = _request(evidence, run, charge, drain.line, drain.result, variant)
    return RunResults(dict(zip(requests, cache.ensure(list(requests.values())), strict=True)), missing)


def _request(
    evidence: StudyData,
    run: RunRow,
    charge: ChargeOfRun,
    drain: PassiveDrain,
    fit: DrainFit,
    variant: str | None,
) -> Request[RunEnergy]:
    voltage_v = evidence.study.reference_voltage_v
    return Request(
        ALGORITHM,
        {"run": run.name} | ({"variant": variant} if variant else {}),
        (
            run_input(run),
            charge_input(charge),
            result_fingerprint("drain", fit),
            fingerprint("voltage", "study", evidence.study.uid, repr(voltage_v)),
        ),
        {},
        lambda: _energy(run, charge, drain, voltage_v),
    )


def _energy(run: RunRow, charge: ChargeOfRun, drain: PassiveDrain, voltage_v: float) -> RunEnergy:
    assert run.duration_s is not None  # noqa: S101 - `usable_charge` has asked
    passive = drain.at(run.duration_s)
    worth_j_mah = joules_per_mah(voltage_v, run.jumps_made)
    joules = joules_per_jump(charge.charge_mah, passive.charge_mah, voltage_v, run.jumps_made)
    return RunEnergy(
        joules_per_jump=Number(
            joules,
            "J",
            se=worth_j_mah * rounding_sd_mah(charge.resolution_mah),
            shared_se=worth_j_mah * passive.se,
            n=run.jumps_made,
        ),
        passive_charge=Number(passive.charge_mah, "mAh", shared_se=passive.se, n=drain.n, df=drain.df),
        drain_df=drain.df,
        shared_terms_j={term: -worth_j_mah * mah for term, mah in drain.error_terms_mah(run.duration_s).items()},
        extrapolated=passive.extrapolated,
    )
