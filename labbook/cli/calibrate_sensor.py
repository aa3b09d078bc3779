"""`labbook calibrate-sensor`: scale and offset of a sensor from a log of known values."""

from pathlib import Path
from typing import Annotated

import typer

from labbook.terminal import Shown, columns


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
        (f"{value:g}", f"{rest.mean:.6g}", f"{rest.sd:.2g}", str(rest.n), f"{left:.2g}")
        for value, rest, left in zip(found.known, found.rests, found.left, strict=True)
    ]
    line = f"{found.calibration.sentence(found.column, found.channel, found.unit)}."
    if found.n_rests > len(known):
        line += f" It rests {found.n_rests} times: the {len(known)} longest are taken."
    return Shown(found, [line, *columns(head, rows), "", "for [profiles.NAME.columns]:", found.profile()])
