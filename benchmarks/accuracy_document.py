"""Measures what accuracy costs on the shipped scenes, and writes that part of `docs/accuracy.md` with its figures.

python benchmarks/accuracy_document.py
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

from benchmarks import machine
from benchmarks.document import replace_between, table_text
from benchmarks.section import Table
from labbook.presenting.simulation.work_precision import SENSITIVE, figure_notes, figure_title
from reports.display import plain_number, time_text
from reports.figures.style import publication_style
from reports.figures.work_precision import draw_work_precision
from simulator.accuracy.fixed_step_euler import THESIS_STEP_S
from simulator.accuracy.methods import EULER, LABBOOK, TITLES
from simulator.accuracy.study import COST, AccuracyStudy, Need, Point, accuracy_study, needs
from simulator.scene_file import load_scene

DOCUMENT = Path(__file__).resolve().parent.parent / "docs" / "accuracy.md"
SCENES = ("sim2", "sim1", "bed", "emulator", "force_plate")
FIRST, LAST = "<!-- measured: what accuracy costs -->", "<!-- end of what accuracy costs -->"
"""Lines between which everything is written anew."""

GOALS = (1e-2, 1e-4, 1e-6, 1e-9)
FIGURE_DPI = 130


def main() -> None:
    """Study all scenes, draw them, and put the results between the two lines of the document."""
    load = machine.load()
    parts = [f"Load at the start: {load:.1f}.\n\n" + table_text(Table(("", ""), tuple(machine.described()), ""))]
    for name in SCENES:
        print(f"== {name}", flush=True)
        study = accuracy_study(load_scene(name), done=lambda what: print(f"   {what}", flush=True))
        with publication_style():
            figure = draw_work_precision(study, figure_title(study), figure_notes(study))
            figure.savefig(DOCUMENT.parent / _figure(name), dpi=FIGURE_DPI)
        parts.append("\n".join(_section(study)))
    replace_between(DOCUMENT, FIRST, LAST, parts)
    print(f"wrote {DOCUMENT}")


def _figure(scene: str) -> str:
    return f"accuracy_{scene}.png"


def _section(study: AccuracyStudy) -> Iterator[str]:
    scene, reference = study.scene, study.reference
    yield f"### {scene.name}\n"
    jumps = f", jump {scene.jumps} of {scene.jumps}" if scene.jumps > 1 else ""
    yield f"{scene.title}{jumps}. Against: {reference.source}.\n"
    yield f"![Error against time of scene {scene.name}]({_figure(scene.name)})\n"
    floors = ", ".join(f"{TITLES[name].lower()} {floor:.0e}" for name, floor in reference.floor.items() if floor)
    yield f"Nothing is claimed under: {floors}.\n"
    yield table_text(_needs_table(study))
    yield from _what_it_shows(study)


def _needs_table(study: AccuracyStudy) -> Table:
    """For each method, the setting and the time that each goal for the cost takes."""
    columns = [needs(study, goal) for goal in GOALS]
    rows = [(found[0].series.method, *map(_cell, found)) for found in zip(*columns, strict=True)]
    rows += [(series.method, series.why_not, "", "", "") for series in study.series if series.why_not]
    heads = ("cost in joules to", *(f"{100 * goal:g} %" if goal >= 1e-3 else plain_number(goal) for goal in GOALS))
    return Table(heads, tuple(rows), "")


def _cell(need: Need) -> str:
    if not need.within_reach:
        return "beyond round-off"
    if need.point is None:
        return "not reached"
    shown = f"{need.series.setting} {plain_number(need.point.setting)} {need.series.unit}".rstrip()
    return f"{shown}: {time_text(need.point.seconds)}"


def _what_it_shows(study: AccuracyStudy) -> Iterator[str]:
    own = {point.setting: point for point in _points(study, LABBOOK)}
    coarse, default, fine = own[1e-2], own[1e-6], own[1e-12]
    known = study.reference.floor[COST] or math.inf
    if known > SENSITIVE:
        yield (
            "This scene hangs on the last bits of its parameters: its sampled active damping lets errors grow from "
            f"tick to tick, and no program that computes in double precision knows its joules better than {known:.0e}. "
            "labbook sees the growth and begins anew with finer steps, whatever accuracy is asked for: "
            f"{time_text(default.seconds)} at its default."
        )
    else:
        yield (
            f"labbook at its default of 1e-6 takes {time_text(default.seconds)}, "
            f"{default.seconds / coarse.seconds:.2g} times what it takes for 1 %; 1e-12 takes "
            f"{fine.seconds / default.seconds:.2g} times the default."
        )
    thesis = next((point for point in _points(study, EULER) if point.setting == THESIS_STEP_S), None)
    if thesis is not None:
        error = (thesis.errors or {})[COST] or math.inf
        yield (
            f"The thesis's scheme at its step of 1e-6 s is off by {error:.1e} in joules, after "
            f"{time_text(thesis.seconds)}: {thesis.seconds / default.seconds:.3g} times labbook's default."
        )
    yield ""


def _points(study: AccuracyStudy, method: str) -> tuple[Point, ...]:
    return next(series.points for series in study.series if series.method == method)


if __name__ == "__main__":
    main()
