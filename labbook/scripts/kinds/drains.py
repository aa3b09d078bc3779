"""Slope, intercept and R squared of a passive-drain line, and the charge that it gives at a run's duration."""

from labbook.scripts.facts import Facts
from labbook.scripts.script import Asked, Script
from labbook.scripts.tables import idle_rows

_NUMBERS = ("slope", "intercept", "r_squared", "at_run")


def script(asked: Asked, facts: Facts) -> Script | None:
    """Return the script of a number of a robot's drain line."""
    robots = {run.robot_uid: run.robot for run in (*facts.evidence.idle, *facts.evidence.runs)}
    wanted = [uid for uid, name in robots.items() if name == asked.scope["robot"]]
    if asked.name not in _NUMBERS or not wanted:
        return None
    rows = idle_rows(facts, wanted, asked.variant)
    durations_s = [float(row["duration_s"]) for row in rows]
    duration_s = facts.configuration.protocol.run_duration_s
    settings = {"RUN_DURATION_S": sum(durations_s) / len(durations_s) if duration_s is None else float(duration_s)}
    return Script(rows, (f"drain.{asked.name}",), settings)
