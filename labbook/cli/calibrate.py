"""`labbook calibrate`: the ground's parameters from a book's own jumps."""

import os
from pathlib import Path
from typing import Annotated

import typer

from labbook.cli.common import BookOption, WhereOption, opened, options_given
from labbook.terminal import Shown, columns, progress, with_files, within_width


def calibrate(
    context: typer.Context,
    fit: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="A parameter to fit, again for each. [default: kg_scale, bg_scale]"),
    ] = None,
    out: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the scene with what was fitted: a .toml file.")
    ] = None,
    level: Annotated[float, typer.Option(help="Level of the intervals.")] = 0.95,
    where: WhereOption = None,
    book: BookOption = None,
) -> Shown:
    """Fit parameters of the simulated ground to the joules and apex heights that the book measured.

    The scene is that of [simulation] in labbook.toml, simulated for each condition as it was run. Beside each value
    stands the interval of the profile likelihood: a parameter without one is not identified by these data. Each group
    of conditions is then predicted from a fit to the others. Name the scene that --out writes under [simulation], and
    `labbook compare` predicts with it.

    Every factor of the study is an option: --foot small is short for --where "foot=small".

    Example: labbook calibrate --fit kg_scale --out ground.toml
    """
    from data_schema.disk import write_whole
    from data_schema.errors import UsageError
    from labbook.actions.report_command import selection
    from labbook.actions.simulate.calibrating import calibrate_book
    from labbook.presenting.simulation.calibrated import HEAD, as_data, how_to_use, rows, sentences
    from simulator.scene_file import write_scene

    if not 0.5 <= level < 1.0:
        raise UsageError(f"a level of {level:g} is none: give one from 0.5 to below 1, such as 0.95.")
    if out is not None and (out.suffix != ".toml" or out.exists()):
        raise UsageError(f"{out} exists, or is no .toml file: name another for --out.")
    if out is not None and not out.absolute().parent.is_dir():
        raise UsageError(f"there is no folder {out.absolute().parent}: make it, or name another for --out.")
    with opened(book) as opened_book:
        text = selection(opened_book.configuration, where, context.args, options_given(context))
        with progress("calibrate", None) as step:
            found = calibrate_book(opened_book, text, fit or [], level, step)
        folder = opened_book.folder.resolve()
    if out is not None:
        write_whole(out, write_scene(found.scene).encode("utf-8"))
    use = []
    if out is not None:  # labbook.toml says where a scene is from its own folder
        use.append(how_to_use(found.calibration, Path(os.path.relpath(out.resolve(), folder)).as_posix()))
    lines = [*columns(HEAD, rows(found.calibration)), "", *within_width(sentences(found.calibration)), *use]
    return with_files(as_data(found.calibration), lines, {"scene": out})
