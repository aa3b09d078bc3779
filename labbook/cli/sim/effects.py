"""`labbook sim effects`: what each effect of a scene is worth."""

from typing import Annotated

import typer

from labbook.cli.common import JsonOption, columns, emit, progress


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("effects")(effects)


def effects(
    scene: Annotated[
        str,
        typer.Option("--scene", metavar="NAME", help="bed, sim1, sim2, emulator, force_plate, or a .toml file."),
    ],
    within: Annotated[
        str, typer.Option("--within", metavar="SHARE", help="The change of cost, apex and depth that may pass.")
    ] = "1%",
    sets: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="NAME=VALUE",
            help="A parameter in SI units, or gain, flight, jumps, ...: see `labbook sim parts`; repeatable.",
        ),
    ] = None,
    switched: Annotated[
        str | None, typer.Option("--effects", metavar="LIST", help="Effects on and off at first: +drag,-added_mass.")
    ] = None,
    accuracy: Annotated[float, typer.Option("--accuracy", help="The relative error aimed at.")] = 1e-6,
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
    from labbook.actions.simulate.effects_ablation import EffectsRequest, effects_task, measure_effects
    from labbook.presenting.simulation import effects_ablation as shown
    from labbook.presenting.simulation.effects_ablation_data import ablation_data, time_data, times_data

    task = effects_task(EffectsRequest(scene, within, tuple(sets or ()), switched, accuracy, timings))
    if not as_json:
        typer.echo(shown.ahead(len(task.sets), task.kernels), err=True)
    with progress("effects", task.steps, shown=not as_json) as step:
        done = measure_effects(task, step)
    data = {
        **ablation_data(done.scene, done.ablation),
        "times": {
            "full": time_data(done.full_time),
            "smallest": time_data(done.smallest_time),
            "without": times_data(done.times_without),
        },
    }
    head, *rows = shown.alone_table(done.ablation, done.times_without, done.full_time)
    lines = [*shown.heading(done.scene, done.ablation), "", *columns(head, rows)]
    if pairs:
        head, *rows = shown.pairs_table(done.ablation)
        lines += ["", *columns(head, rows)]
    lines += ["", *shown.footnotes(done.ablation), "", *shown.verdict(done.ablation)]
    lines += shown.time_lines(done.full_time, done.smallest_time)
    emit(data, lines, as_json)
