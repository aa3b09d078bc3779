"""`labbook sim run`: one scene."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import JsonOption, emit, progress
from labbook.cli.sim.options import AccuracyOption, EffectsOption, SceneOption, SetOption, WithinOption


def run(
    scene: SceneOption,
    sets: SetOption = None,
    effects: EffectsOption = None,
    within: WithinOption = None,
    accuracy: AccuracyOption = 1e-6,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw the motion: a .png, .svg or .pdf file.")
    ] = None,
    animate: Annotated[
        Path | None, typer.Option("--animate", metavar="FILE", help="Make a moving picture: a .gif file.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Simulate a scene and show its jump: times, heights, joules, how sure they are and what they rest on.

    Of a scene with many jumps the last one is shown, and drawn. With --effects auto --within 1% the effects are left
    out that change cost, apex and depth by at most 1 % together (see labbook sim effects). --json gives every change of
    the contact mode by the kernel's names and, beside them, by those of the ground, as in the plot.

    Example: labbook sim run --scene sim2 --set b_ad=100 --effects +drag --accuracy 1e-8 --plot jump.png
    """
    from labbook.actions.simulate.pictures import ANIMATION_KINDS, check_form, draw_motion
    from labbook.actions.simulate.sweeping import auto_of, with_enough
    from labbook.presenting.simulation.effects_ablation import chosen_data, verdict
    from labbook.presenting.simulation.simulated import as_data, as_lines
    from simulator.changes import changed_by_words
    from simulator.jump import simulate
    from simulator.scene_file import load_scene

    check_form("--plot", plot)
    check_form("--animate", animate, ANIMATION_KINDS)
    auto = auto_of(effects, within, accuracy)
    with progress("simulating", None, shown=not as_json) as step:
        full = changed_by_words(load_scene(scene), sets or (), auto.words)
        ablation = auto.ablation(full, step)
        drawn = plot is not None or animate is not None
        result = simulate(with_enough(full, ablation), accuracy, trajectory=drawn)
        if drawn:
            draw_motion(result, plot, animate)
    said = [] if ablation is None else ["", *verdict(ablation)]
    files = {name: str(path) for name, path in (("plot", plot), ("animation", animate)) if path is not None}
    data = {**as_data(result), **chosen_data(ablation), **files}
    emit(data, [*as_lines(result), *said, *files.values()], as_json)
