"""Facts as inputs of results: what changes their hash is exactly what a result may use."""

from __future__ import annotations

from data_schema.journal import canonical
from data_schema.queries.charges import ChargeOfRun
from data_schema.queries.detections import DecisionRow
from data_schema.queries.results import InputRow
from data_schema.queries.runs import RunRow
from data_schema.queries.signals import SignalRow
from labbook.analysis.results.result_cache import fingerprint


def run_input(run: RunRow) -> InputRow:
    """Name a run and the facts about it that numbers rest on; whether it is void decides who uses its numbers."""
    return fingerprint(
        "run",
        "run",
        run.uid,
        canonical([run.kind, run.duration_s, run.jumps_made, run.condition_key, run.robot]),
    )


def charge_input(charge: ChargeOfRun) -> InputRow:
    """Name a charge and what it says."""
    return fingerprint(
        "charge", "charge", charge.uid, canonical([charge.charge_mah, charge.resolution_mah, charge.mode])
    )


def idle_runs_input(robot_uid: str) -> InputRow:
    """Name the idle runs of a robot: a drain line rests on all there are, also before another one is added."""
    return fingerprint("idle runs", "idle_runs", robot_uid, robot_uid)


def signal_input(signal: SignalRow, role: str) -> InputRow:
    """Name the samples of a signal; they are their own hash."""
    return InputRow(role, "signal", signal.sha256, signal.sha256)


def decision_input(decision: DecisionRow) -> InputRow:
    """Name a person's verdict; it never changes."""
    return fingerprint("decision", "decision", decision.uid, decision.uid)


def condition_input(run: RunRow) -> InputRow:
    """Name the condition of a run: a summary rests on it, also before another run joins it."""
    return fingerprint("condition", "condition", run.condition_uid or "", run.condition_key)
