"""Joules a jump of each run: 3.6 x voltage x (charge - passive charge) / jumps made (thesis 5.1.4)."""

from __future__ import annotations

import json
from collections.abc import Mapping

from data_schema.queries.charges import ChargeOfRun
from data_schema.queries.results import ResultRow
from data_schema.queries.runs import RunRow
from data_schema.vocabulary import Undefined
from labbook.analysis.outcomes.energy import joules_per_jump, joules_per_mah
from labbook.analysis.outcomes.passive_drain import Drain, recharge_of
from labbook.analysis.outcomes.run_results import RunResults
from labbook.analysis.results.facts import charge_input, run_input
from labbook.analysis.results.result_cache import (
    Algorithm,
    Computed,
    NewNumber,
    Request,
    ResultCache,
    fingerprint,
    result_fingerprint,
)
from labbook.analysis.study_data import StudyData
from stats.compare.shared_error import SharedError
from stats.lines.passive_drain import PassiveDrain, rounding_sd_mah

ALGORITHM = Algorithm("run_energy", 13)


def usable_charge(run: RunRow, charges: list[ChargeOfRun]) -> ChargeOfRun | str:
    """Return the one charge that a jump run's energy rests on, or why there is none."""
    charge = recharge_of(run, charges)
    return charge if isinstance(charge, str) or run.jumps_made else "no jumps made"


def run_energies(
    cache: ResultCache, evidence: StudyData, drains: Mapping[str, Drain], variant: str | None = None
) -> RunResults:
    """Ensure the energy of every selected jump run that has what it takes; `variant` names a recomputation."""
    requests: dict[str, Request] = {}
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
    drain_row: ResultRow,
    variant: str | None,
) -> Request:
    voltage_v = evidence.study.reference_voltage_v
    return Request(
        ALGORITHM,
        {"run": run.name} | ({"variant": variant} if variant else {}),
        (
            run_input(run),
            charge_input(charge),
            result_fingerprint("drain", drain_row),
            fingerprint("voltage", "study", evidence.study.uid, repr(voltage_v)),
        ),
        {},
        lambda: _outcome(run, charge, drain, voltage_v),
    )


def shared_error(row: ResultRow) -> SharedError:
    """Return what a run's joules share with other runs: the errors of its robot's drain line, in joules a jump."""
    payload = json.loads(row.payload_json)
    fit = next(item.input_uid for item in row.inputs if item.role == "drain")
    terms = {(fit, term): float(value) for term, value in payload["shared_terms_j"].items()}
    return SharedError(terms, {fit: float(payload["drain_df"])})


def _outcome(run: RunRow, charge: ChargeOfRun, drain: PassiveDrain, voltage_v: float) -> Computed:
    assert run.duration_s is not None  # noqa: S101 - `usable_charge` has asked
    passive = drain.at(run.duration_s)
    worth_j_mah = joules_per_mah(voltage_v, run.jumps_made)
    joules = joules_per_jump(charge.charge_mah, passive.charge_mah, voltage_v, run.jumps_made)
    return Computed(
        (
            NewNumber(
                "joules_per_jump",
                joules,
                "J",
                se=worth_j_mah * rounding_sd_mah(charge.resolution_mah),
                shared_se=worth_j_mah * passive.se,
                n=run.jumps_made,
            ),
            NewNumber("passive_charge", passive.charge_mah, "mAh", shared_se=passive.se, n=drain.n, df=drain.df),
        ),
        {
            "drain_df": drain.df,
            "shared_terms_j": {term: -worth_j_mah * mah for term, mah in drain.error_terms_mah(run.duration_s).items()},
            "extrapolated": passive.extrapolated,
        },
    )
