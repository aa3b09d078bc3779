"""Runs as a table of text, for the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from data_schema.queries.runs import RunRow

HEAD = ("run", "day", "position", "kind", "condition", "battery", "duration", "jumps", "starts", "state")


def run_cells(rows: Sequence[RunRow]) -> tuple[Sequence[str], list[tuple[str, ...]]]:
    """Return the head and the cells of a list of runs."""
    return HEAD, [
        (
            run.name,
            run.day,
            str(run.position_in_day),
            str(run.kind),
            run.condition_key,
            run.battery,
            "" if run.duration_s is None else f"{run.duration_s:g} s",
            str(run.jumps_made),
            str(run.starts),
            str(run.state),
        )
        for run in rows
    ]
