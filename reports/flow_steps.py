"""The steps from what was planned to what is analysed, as the diagram and its table count them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from reports.content import Flow


@dataclass(frozen=True, slots=True)
class Step:
    """A box of the main line, and what leaves the line on the way to it."""

    name: str
    count: int
    leaving: tuple[str, ...] = ()


def run_steps(flow: Flow) -> tuple[Step, ...]:
    """Return the boxes of the runs."""
    leaving = []
    if flow.runs_void:
        leaving.append(f"{flow.runs_void} void")
    if flow.runs_idle:
        leaving.append(f"{flow.runs_idle} idle, for the passive drain")
    leaving += _reasons(flow.runs_excluded)
    planned = () if flow.runs_planned is None else (Step("runs planned", flow.runs_planned),)
    return (*planned, Step("runs done", flow.runs_done), Step("runs analysed", flow.runs_analysed, tuple(leaving)))


def jump_steps(flow: Flow) -> tuple[Step, ...]:
    """Return the boxes of the jumps."""
    return (
        Step("jumps made", flow.jumps_made),
        Step("jumps detected", flow.jumps_detected),
        Step("jumps analysed", flow.jumps_analysed, tuple(_reasons(flow.jumps_excluded))),
    )


def _reasons(excluded: Mapping[str, int]) -> list[str]:
    return [f"{count} excluded: {reason}" for reason, count in excluded.items()]
