"""`labbook sim sweep`: a scene over a grid or a sample of its parameters, to a file."""

from contextlib import nullcontext
from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import JsonOption, before_work, counted, emit, progress
from labbook.cli.sim.options import AccuracyOption, EffectsOption, SceneOption, SetOption, WithinOption


def sweep(
    scene: SceneOption,
    over: Annotated[
        list[str],
        typer.Option(
            "--over",
            metavar="NAME=VALUES",
            help="What to sweep: LOW:HIGH:COUNT[:log] or VALUE,VALUE; for a sample LOW:HIGH[:log]; repeatable.",
        ),
    ],
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="The result: a .nc file or a .zarr folder.")],
    sets: SetOption = None,
    effects: EffectsOption = None,
    within: WithinOption = None,
    sobol: Annotated[
        int | None,
        typer.Option("--sobol", metavar="COUNT", help="Draw so many scenes (best a power of 2) from the ranges."),
    ] = None,
    seed: Annotated[int | None, typer.Option("--seed", help="Another seed draws another sample; 0 without it.")] = None,
    accuracy: AccuracyOption = 1e-6,
    scheduler: Annotated[
        str | None,
        typer.Option("--scheduler", metavar="URL", help="A Dask cluster's scheduler, tcp://HOST:PORT, to compute on."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Simulate a scene over a grid, or a Sobol sample, of its parameters, on all cores, to an xarray Dataset in a file.

    A value outside its parameter's range is refused at once. Where values are in range but do not fit together, the
    sweep goes on without those scenes: it says how many they are and why, and in the file their outcome is refused and
    their numbers are NaN.

    Interrupted or killed, the same command goes on where it was; until the file is whole, FILE.part holds what is done.
    With --effects auto --within 1% the effects are left out that change the scene as it stands, before anything is
    swept, by at most 1 %; those that read what is swept stay. Farther out in the sweep the others may matter more: both
    sets are simulated at the corners of what is swept (at the ends of each range, where they are more than 16), and it
    is said how far off the worst is and where.

    Example: labbook sim sweep --scene sim2 --over b_ad=0:300:31 --over foot_radius=0.02,0.03,0.038 --out sweep.nc
    """
    from labbook.actions.simulate.sweeping import SweepRequest, planned_sweep
    from labbook.presenting.simulation.effects_ablation import chosen_data, verdict
    from labbook.presenting.simulation.swept import corners_data, corners_lines, sweep_data, sweep_lines
    from simulator.sweep.compute import Threads, connected
    from simulator.sweep.run import run_sweep

    request = SweepRequest(scene, tuple(over), tuple(sets or ()), effects, accuracy, sobol, seed, within)
    with progress("checking the sweep", None, shown=not as_json) as step:
        planned = planned_sweep(request, step)
    corners = corners_lines(planned.corners, planned.ablation)
    refused = [f"note: {planned.sweep.refused}"] if planned.sweep.refused else []
    if not as_json:
        before_work([*refused, *corners])
    computing = nullcontext(Threads()) if scheduler is None else connected(scheduler)
    wanted = planned.sweep.jumps_wanted
    with counted("sweeping", wanted, "jumps", shown=not as_json) as advance, computing as compute:
        done = run_sweep(planned.sweep, out, compute, advance)
    chosen_for = "The effects were chosen for the scene as it stands, before anything is swept:"
    said = [] if planned.ablation is None else ["", chosen_for, *verdict(planned.ablation), *corners]
    data = {**sweep_data(done), **chosen_data(planned.ablation), **corners_data(planned.corners, planned.ablation)}
    emit(data, [*sweep_lines(done), *said], as_json)
