"""`labbook sim accuracy`: what accuracy costs on one scene."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import JsonOption, emit, progress
from labbook.cli.sim.options import SceneOption, SetOption


def accuracy(
    scene: SceneOption,
    sets: SetOption = None,
    effects: Annotated[
        str | None, typer.Option("--effects", metavar="LIST", help="Effects on and off: +drag,-added_mass.")
    ] = None,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw error against time: a .png, .svg or .pdf file.")
    ] = None,
    quick: Annotated[bool, typer.Option("--quick", help="Try few settings of each method.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Show what accuracy costs: this scene by the thesis's fixed steps, by scipy's integrators and by labbook.

    Errors of depth, lift-off time, apex and cost against a reference, evaluations and times of each method at many
    settings; and what 1 % of the cost in joules takes. Where jumps follow each other, four are made.

    Example: labbook sim accuracy --scene sim2 --set b_ad=100 --plot accuracy.png
    """
    from labbook.actions.simulate.pictures import check_form, save_plot
    from labbook.presenting.simulation.work_precision import as_data, as_lines, work_precision_of
    from reports.figures.work_precision import draw_work_precision
    from simulator.accuracy.study import accuracy_study, points_to_come
    from simulator.changes import changed_by_words
    from simulator.scene_file import load_scene

    with progress("compiling", points_to_come(quick), shown=not as_json) as done:
        check_form("--plot", plot)
        study = accuracy_study(changed_by_words(load_scene(scene), sets or (), effects), quick, done)
        if plot is not None:
            save_plot(lambda: draw_work_precision(work_precision_of(study)), plot)
    files = {} if plot is None else {"plot": str(plot)}
    emit({**as_data(study), **files}, [*as_lines(study), *files.values()], as_json)
