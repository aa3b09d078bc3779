"""The charges of a file: which are new, which are known, and which contradict what stands."""

from __future__ import annotations

from typing import Any

from data_schema.queries import imports
from data_schema.queries.charges import ChargeOfRun, charges_of_run, charges_waiting_for
from data_schema.queries.facts import find_uid, insert_fact
from data_schema.vocabulary import Severity
from ingest.model import ChargeRow, Finding, ReadFile
from labbook.statements.assigning import assign_charge
from labbook.statements.findings import finding_values
from labbook.statements.scene import Scene, derived_uid, run_named


def add_charges(scene: Scene, ingest_key: int, file_uid: str, read: ReadFile) -> list[str]:
    """Add a file's charges; returns the runs that got one.

    A hand-kept sheet grows and comes again: a row that a run's charge says already, or one that waits for the run, is
    not a second charge, and one that contradicts the run's waits in the inbox; both leave a finding.
    """
    touched = []
    for row in read.charges:
        run_uid = run_named(scene, row.stated_run)
        standing = charges_of_run(scene.connection, run_uid) if run_uid else []
        waiting = charges_waiting_for(scene.connection, row.stated_run) if row.stated_run else []
        if any(_same_charge(row, charge) for charge in (*standing, *waiting)):
            message = f"The charge of run {row.stated_run} is in the book already; this row adds nothing."
            imports.add_findings(scene.connection, ingest_key, [_charge_finding("charge_known", row, message)])
            continue
        uid = derived_uid("charge", file_uid, row.row_number)
        insert_fact(scene.connection, "charge", uid, _charge_values(scene, file_uid, row))
        if standing:
            message = (
                f"Run {row.stated_run} has a charge of {standing[0].charge_mah:g} mAh (charge:{standing[0].uid}); this "
                f"row waits in the inbox: correct that charge if it is wrong."
            )
            imports.add_findings(scene.connection, ingest_key, [_charge_finding("charge_contradicts", row, message)])
        elif run_uid:
            assign_charge(scene, uid, run_uid)
            touched.append(run_uid)
    return touched


def _same_charge(row: ChargeRow, standing: ChargeOfRun) -> bool:
    voltages = {row.end_voltage_v, standing.end_voltage_v} - {None}
    return row.charge_mah == standing.charge_mah and str(row.mode) == standing.mode and len(voltages) < 2


def _charge_finding(rule: str, row: ChargeRow, message: str) -> dict[str, Any]:
    value = f"{row.charge_mah:g} mAh"
    return finding_values(Finding(Severity.NOTE, rule, message, None, None, value, 1, ()))


def _charge_values(scene: Scene, file_uid: str, row: ChargeRow) -> dict[str, Any]:
    return {
        "file": file_uid,
        "row_number": row.row_number,
        "run": None,
        "stated_run": row.stated_run,
        "battery": find_uid(scene.connection, "battery", name=row.stated_pack) if row.stated_pack else None,
        "stated_pack": row.stated_pack,
        "charge_mah": row.charge_mah,
        "resolution_mah": row.resolution_mah,
        "duration_s": row.duration_s,
        "end_voltage_v": row.end_voltage_v,
        "mode": str(row.mode),
        "ended_utc": row.ended_utc,
        "ended_original": row.ended_original,
    }
