"""`labbook calibrate`: the ground from a book's own jumps; `labbook calibrate-sensor`: a sensor from a log."""

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
    from labbook.actions.simulate.calibrating import HEAD, as_data, calibrate_book, how_to_use, rows, sentences
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


def calibrate_sensor(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A log in which the sensor rests at each known value.")],
    column: Annotated[str, typer.Option(metavar="COLUMN", help="The sensor's column.")],
    points: Annotated[str, typer.Option(metavar="VALUES", help="The known values in order of time: 0.2,0.4,0.6.")],
    unit: Annotated[str, typer.Option(help="The unit of the known values.")] = "m",
    channel: Annotated[str, typer.Option(help="What it measures (`labbook channels`).")] = "body_height",
    time: Annotated[str | None, typer.Option(metavar="COLUMN:UNIT", help="The time column and its unit: t:ms.")] = None,
    rate: Annotated[float | None, typer.Option(help="Samples a second, where the file has no time.")] = None,
    source: Annotated[str | None, typer.Option(help="How the values are known: a ruler, page 12.")] = None,
) -> Shown:
    """Fit scale and offset of a sensor to a log in which it was held still at known values, one after the other.

    Hold it for a second or longer at each; two values give a line, three or more its standard error. Put the printed
    line under [profiles.NAME.columns] in labbook.toml.

    Example: labbook calibrate-sensor heights.csv --column adc_h --points 0.20,0.40,0.60 --source "ruler, page 12"
    """
    from data_schema.errors import UsageError
    from labbook.actions.files.calibrating_sensor import calibrate_sensor as fitted
    from labbook.config.profiles import check_unit, declared_channel

    try:
        known = [float(value) for value in points.split(",")]
    except ValueError:
        raise UsageError(f"--points {points!r} are no numbers: write for example 0.20,0.40,0.60.") from None
    channel = declared_channel(channel)
    check_unit(unit, channel)
    options: dict[str, object] = {} if rate is None else {"rate_hz": rate}
    if time is not None:
        options["time_column"], _colon, time_unit = time.partition(":")
        options["time_unit"] = time_unit or None
    found = fitted(file, column, known, unit, channel, options, source)
    head = (f"known [{unit}]", "shown", "SD", "samples", f"residual [{unit}]")
    rows = [
        (f"{value:g}", f"{rest.mean:.6g}", f"{rest.sd:.2g}", rest.n, f"{left:.2g}")
        for value, rest, left in zip(found.known, found.rests, found.left, strict=True)
    ]
    line = f"{found.calibration.sentence(found.column, found.channel, found.unit)}."
    if found.n_rests > len(known):
        line += f" It rests {found.n_rests} times: the {len(known)} longest are taken."
    return Shown(found, [line, *columns(head, rows), "", "for [profiles.NAME.columns]:", found.profile()])
