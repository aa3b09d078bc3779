"""A study of what accuracy costs: as a table, as sentences, as data, and as what its figure draws.

What computes: the processor that times were taken on.
"""

from __future__ import annotations

import math
import platform
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from labbook.presenting.simulation.simulated import finite, scene_data, title_text, which_jump
from labbook.terminal import columns
from reports.display import plain_number, sentence_start, time_text
from simulator.accuracy.methods import LABBOOK, TITLES
from simulator.accuracy.study import COST, GOALS, AccuracyStudy, Point, Series, needs


def processor() -> str:
    """Return the processor's name."""
    info = Path("/proc/cpuinfo")
    if info.exists():
        for line in info.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.split(":", 1)[1].strip()
    return platform.processor() or platform.machine()


SENSITIVE = 1e-9
"""A floor above this gets a sentence: the scene is sensitive to the last bits of its parameters."""


def as_data(study: AccuracyStudy) -> dict[str, Any]:
    """Return the whole study for JSON; an error that does not exist, or is infinite, is null."""
    scene, reference = study.scene, study.reference
    data: dict[str, Any] = finite(
        {
            **scene_data(scene),
            "jumps": scene.jumps,
            "reference": {**asdict(reference), **reference.values, "floor": reference.floor},
            "methods": [asdict(series) for series in study.series],
            "needs": [
                {
                    "method": need.series.method,
                    "output": COST,
                    "goal": goal,
                    "within_reach": need.within_reach,
                    "setting": need.point and need.point.setting,
                    "seconds": need.point and need.point.seconds,
                }
                for goal in GOALS
                for need in needs(study, goal)
            ],
        }
    )
    return data


def as_lines(study: AccuracyStudy) -> list[str]:
    """Return what people read: against what, the table, and what 1 % and a millionth of the cost take."""
    scene, reference = study.scene, study.reference
    return [
        title_text(scene, "", reference.outcome),
        f"errors are relative{which_jump(scene, scene.jumps)}, against: {reference.source}.",
        _floor_line(study),
        _times(),
        "",
        *_table(study),
        "",
        *(line for goal in GOALS for line in _advice(study, goal)),
    ]


def figure_title(study: AccuracyStudy) -> str:
    """Return what heads the figure."""
    return title_text(study.scene, which_jump(study.scene, study.scene.jumps), study.reference.outcome)


def figure_notes(study: AccuracyStudy) -> tuple[str, ...]:
    """Say against what errors are, where times were taken, and what failed or is not covered."""
    return (f"Errors are against: {study.reference.source}.", sentence_start(_times()), *_not_drawn(study))


def _times() -> str:
    return f"times are of one run, on one core of: {processor()}."


def _not_drawn(study: AccuracyStudy) -> Iterator[str]:
    for series in study.series:
        if series.why_not:
            yield f"{series.method}: {series.why_not}."
        for point in series.points:
            if point.failure:
                yield f"{series.method} at {_setting(series, point)}: {point.failure}."


def _floor_line(study: AccuracyStudy) -> str:
    floors = {name: floor for name, floor in study.reference.floor.items() if floor is not None}
    listed = ", ".join(f"{TITLES[name].lower()} {floor:.1e}" for name, floor in floors.items())
    line = f"nothing is claimed under: {listed} (the last bit of every parameter moved; doubt of the reference)."
    if max(floors.values(), default=0.0) > SENSITIVE:
        line += (
            " This scene hangs on the last bits of its parameters: no program that computes with doubles knows better."
        )
    return line


def _table(study: AccuracyStudy) -> list[str]:
    head = ("method", "setting", *(title.lower() for title in TITLES.values()), "evaluations", "time")
    rows: list[tuple[str, ...]] = []
    for series in study.series:
        if series.why_not:
            rows.append((series.method, "-", *("-" for _ in TITLES), "-", series.why_not))
        for point in series.points:
            last = time_text(point.seconds) if not point.failure else point.failure
            errors = (_error_text(study, point, name) for name in TITLES)
            rows.append((series.method, _setting(series, point), *errors, str(point.evaluations), last))
    return columns(head, rows)


def _error_text(study: AccuracyStudy, point: Point, name: str) -> str:
    error, floor = (point.errors or {}).get(name), study.reference.floor[name]
    if error is None or floor is None:
        return "-"
    if math.isinf(error):
        return "not reached"
    return f"{'<' if error <= floor else ''}{error:.1e}"


def _advice(study: AccuracyStudy, goal: float) -> Iterator[str]:
    found = needs(study, goal)
    share = f"{100.0 * goal:g} %" if goal >= 1e-3 else plain_number(goal)
    floor = study.reference.floor[COST]
    if not found[-1].within_reach:
        known = "nothing is known" if floor is None or math.isinf(floor) else f"{floor:.1e} is all that can be known"
        yield f"for {share} of the cost in joules nobody can say what is needed: {known}."
        return
    own = next((need.point for need in found if need.series.method == LABBOOK), None)
    for need in found:
        method, paid = need.series.method, f"no setting of {need.series.method} that was tried will do."
        if need.point is not None:
            paid = (
                f"you need {_setting(need.series, need.point)} with {method}; you pay {time_text(need.point.seconds)}"
            )
            if own is not None and method != LABBOOK:
                paid += f", {need.point.seconds / own.seconds:.3g} times what labbook takes"
            paid += "."
        yield f"for {share} of the cost in joules {paid}"


def _setting(series: Series, point: Point) -> str:
    return f"{series.setting} {plain_number(point.setting)} {series.unit}".rstrip()
