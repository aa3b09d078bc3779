"""`labbook sim effects`: what a scene does without each of its effects."""

from typing import Annotated

import typer

from labbook.cli.common import JsonOption, columns, emit, progress
from labbook.cli.sim.options import AccuracyOption, SceneOption, SetOption


def effects(
    scene: SceneOption,
    within: Annotated[
        str, typer.Option("--within", metavar="SHARE", help="The change of cost, apex and depth that may pass.")
    ] = "1%",
    sets: SetOption = None,
    switched: Annotated[
        str | None, typer.Option("--effects", metavar="LIST", help="Effects on and off at first: +drag,-added_mass.")
    ] = None,
    accuracy: AccuracyOption = 1e-6,
    pairs: Annotated[bool, typer.Option("--pairs", help="Show every pair of effects, too.")] = False,
    timings: Annotated[
        bool, typer.Option("--timings", help="Compile and time a kernel without each effect: seconds for each.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Leave out each effect of a scene, alone and in pairs, and find the smallest set that is good enough.

    Good enough are cost, apex and depth within a share of those with all effects. Of a scene with many jumps the tenth
    is looked at. `labbook sim run --effects auto --within 1%` uses the set.

    Example: labbook sim effects --scene sim2 --within 1%
    """
    from dataclasses import asdict

    from data_schema.errors import UsageError
    from labbook.presenting.simulation import effects_ablation as shown
    from simulator.ablation.kernel_time import ablation_times
    from simulator.ablation.smallest import tolerance_of
    from simulator.ablation.study import ablation_of_effects, measured_scene, sets_to_leave_out
    from simulator.changes import changed_by_words, without_auto
    from simulator.scene_file import load_scene

    words, auto = without_auto(switched)
    if auto:
        raise UsageError("sim effects finds the smallest set of effects itself: leave auto out of --effects.")
    tolerance = tolerance_of(within, accuracy)
    full = changed_by_words(load_scene(scene), sets or (), words)
    tried = sets_to_leave_out(measured_scene(full))
    kernels = 2 + (sum(len(left_out) == 1 for left_out in tried) if timings else 0)
    if not as_json:
        typer.echo(shown.announcement(len(tried), kernels), err=True)
    with progress("effects", len(tried) + 1 + kernels, shown=not as_json) as step:
        ablation = ablation_of_effects(full, tolerance, accuracy, step)
        times = ablation_times(ablation, timings, step)
    head, *rows = shown.alone_table(ablation, times.without, times.full)
    lines = [*shown.heading(full, ablation), "", *columns(head, rows)]
    if pairs:
        head, *rows = shown.pairs_table(ablation)
        lines += ["", *columns(head, rows)]
    lines += ["", *shown.footnotes(ablation), "", *shown.verdict(ablation)]
    lines += shown.time_lines(times.full, times.smallest)
    emit({**shown.ablation_data(full, ablation), "times": asdict(times)}, lines, as_json)
