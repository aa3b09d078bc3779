"""Options that declare what a file does not say of itself, of `labbook ingest` and `labbook files reread`."""

from typing import Annotated, Any

import typer

_RATE = typer.Option("--rate", help="Samples a second, where the file has no time.")
_UNIT = typer.Option("--unit", metavar="COLUMN=UNIT", help="A column's unit, for example time=ms.")
_COLUMN = typer.Option(
    "--column",
    metavar="COLUMN=CHANNEL[:UNIT]",
    help='What a column holds: "h=body_height:mm" (`labbook channels`), or "i=own.coil_current:A"; with a calibration '
    '"h=body_height:mm, scale=0.29, offset=-4.7" or "h=body_height:m, raw=812 3071, value=0.2 0.85".',
)
_ENCODING = typer.Option("--encoding", help="The page of text that is not UTF-8.")
_DECIMAL = typer.Option("--decimal", help="The decimal sign, . or ,")
_DELIMITER = typer.Option("--delimiter", help="What stands between cells: one sign, or tab.")
_INSTRUMENT = typer.Option("--instrument", help="Whose axes, signs and units: bertec_acquire, action_z_down, ...")
_FORMAT = typer.Option("--format", help="Read it as this format (`labbook formats`), whatever it looks like.")
_PROFILE = typer.Option("--profile", help="Read it with this [profiles.NAME] of labbook.toml.")
_DATES = typer.Option("--dates", help="The order in dates: y-m-d, d.m.y, d/m/y or m/d/y.")
_CLOCK = typer.Option("--clock", help="Whether 12:30 is hours first, h:m, or minutes first, m:s.")
_DAY = typer.Option("--day", help="The local date of a log that has none: chooses between dated calibrations.")
_AXES = typer.Option("--axes", help="The frame of forces: 'z up', 'z down' or 'y up'.")
_OVERRIDE = typer.Option("--override-units", help="Declared units stand against those of the header.")
_COMPLETE = typer.Option("--complete", help="The last line is whole, though it has no line end.")
_NO_CHECK = typer.Option("--no-robot-check", help="Do not compare with the masses and legs of [robots].")

DECLARED: dict[str, tuple[Any, Any]] = {
    "rate": (Annotated[float | None, _RATE], None),
    "unit": (Annotated[list[str] | None, _UNIT], None),
    "column": (Annotated[list[str] | None, _COLUMN], None),
    "encoding": (Annotated[str | None, _ENCODING], None),
    "decimal": (Annotated[str | None, _DECIMAL], None),
    "delimiter": (Annotated[str | None, _DELIMITER], None),
    "instrument": (Annotated[str | None, _INSTRUMENT], None),
    "format": (Annotated[str | None, _FORMAT], None),
    "profile": (Annotated[str | None, _PROFILE], None),
    "dates": (Annotated[str | None, _DATES], None),
    "clock": (Annotated[str | None, _CLOCK], None),
    "day": (Annotated[str | None, _DAY], None),
    "axes": (Annotated[str | None, _AXES], None),
    "override_units": (Annotated[bool, _OVERRIDE], False),
    "complete": (Annotated[bool, _COMPLETE], False),
    "no_robot_check": (Annotated[bool, _NO_CHECK], False),
}
"""The options by parameter, each with its default; `file_options.declared_options` reads what was given."""
