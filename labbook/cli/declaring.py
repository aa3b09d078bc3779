"""Options that declare what a file does not say of itself, of `labbook ingest` and `labbook files reread`."""

from dataclasses import dataclass
from typing import Annotated

import typer


@dataclass(frozen=True, slots=True)
class Declared:
    """What was declared, an option a field; `file_options.declared_options` reads it."""

    rate: Annotated[float | None, typer.Option(help="Samples a second, where the file has no time.")] = None
    unit: Annotated[
        list[str] | None, typer.Option(metavar="COLUMN=UNIT", help="A column's unit, for example time=ms.")
    ] = None
    column: Annotated[
        list[str] | None,
        typer.Option(
            metavar="COLUMN=CHANNEL[:UNIT]",
            help='What a column holds: "h=body_height:mm" (`labbook channels`), or "i=own.coil_current:A"; with a '
            'calibration "h=body_height:mm, scale=0.29, offset=-4.7" or "h=body_height:m, raw=812 3071, value=0.2 '
            '0.85".',
        ),
    ] = None
    encoding: Annotated[str | None, typer.Option(help="The page of text that is not UTF-8.")] = None
    decimal: Annotated[str | None, typer.Option(help="The decimal sign, . or ,")] = None
    delimiter: Annotated[str | None, typer.Option(help="What stands between cells: one sign, or tab.")] = None
    instrument: Annotated[
        str | None, typer.Option(help="Whose axes, signs and units: bertec_acquire, action_z_down, ...")
    ] = None
    format: Annotated[
        str | None, typer.Option(help="Read it as this format (`labbook formats`), whatever it looks like.")
    ] = None
    profile: Annotated[str | None, typer.Option(help="Read it with this [profiles.NAME] of labbook.toml.")] = None
    dates: Annotated[str | None, typer.Option(help="The order in dates: y-m-d, d.m.y, d/m/y or m/d/y.")] = None
    clock: Annotated[str | None, typer.Option(help="Whether 12:30 is hours first, h:m, or minutes first, m:s.")] = None
    day: Annotated[
        str | None, typer.Option(help="The local date of a log that has none: chooses between dated calibrations.")
    ] = None
    axes: Annotated[str | None, typer.Option(help="The frame of forces: 'z up', 'z down' or 'y up'.")] = None
    override_units: Annotated[
        bool, typer.Option("--override-units", help="Declared units stand against those of the header.")
    ] = False
    complete: Annotated[bool, typer.Option("--complete", help="The last line is whole, though it has no line end.")] = (
        False
    )
    no_robot_check: Annotated[
        bool, typer.Option("--no-robot-check", help="Do not compare with the masses and legs of [robots].")
    ] = False
