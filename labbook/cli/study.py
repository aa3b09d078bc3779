"""`labbook study`: studies of the thesis, each from what was measured to its verdict."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from labbook.cli.common import BookOption, JsonOption, WhereOption
from labbook.terminal import emit, within_width

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LevelOption = Annotated[float, typer.Option("--level", help="Level of the intervals.")]
PlotOption = Annotated[Path | None, typer.Option("--plot", metavar="FILE", help="Draw it: a .png, .svg or .pdf file.")]
DecimalOption = Annotated[
    str | None, typer.Option("--decimal", metavar="SIGN", help="The table's decimal sign, where it is unclear.")
]

app = typer.Typer(no_args_is_help=True)


def _text(file: Path, plot: Path | None) -> str:
    """Read a sheet, once it is known that what it gives can be drawn."""
    from labbook.cli.reading import read_text
    from reports.figures.kind import check_form

    check_form("--plot", plot)
    return read_text(file, marked_utf_16=True)


def _show(
    data: dict[str, Any],
    said: list[str],
    draw: "Callable[[], Figure]",
    plot: Path | None,
    as_json: bool,
    table: list[str] | None = None,
) -> None:
    from labbook.actions.simulate.pictures import save_plot

    if plot is not None:
        save_plot(draw, plot)
    files = {} if plot is None else {"plot": str(plot)}
    emit({**data, **files}, [*within_width(said), *(table or ()), *files.values()], as_json)


@app.command()
def compaction(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A CSV file, one filled flask a row.")],
    grain: Annotated[float, typer.Option("--grain", metavar="MM", help="The grains' diameter, mm.")],
    level: LevelOption = 0.95,
    plot: PlotOption = None,
    decimal: DecimalOption = None,
    as_json: JsonOption = False,
) -> None:
    """Show how densely a bed's grains lie, poured and compacted, from the water that fills flasks of several sizes.

    FILE has the columns radius_mm, state (two words, such as loose and compacted) and water_ml, in any units that their
    names say, and flask_ml where the flasks' volumes were measured. The fractions are extrapolated over grain size /
    radius to a bed without walls (thesis 5.1.2).

    Example: labbook study compaction flasks.csv --grain 3.4 --plot compaction.pdf
    """
    from labbook.actions.studies.compaction import compaction_of
    from labbook.presenting.studies.compaction import as_data, drawn, sentences
    from reports.figures.compaction import draw_compaction

    study = compaction_of(_text(file, plot), file, grain, level, decimal)
    _show(as_data(study), sentences(study), lambda: draw_compaction(drawn(study)), plot, as_json)


@app.command("field")
def field_walks(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A CSV file, one robot on one walk a row.")],
    level: LevelOption = 0.95,
    plot: PlotOption = None,
    decimal: DecimalOption = None,
    as_json: JsonOption = False,
) -> None:
    """Compare what two robots need that walk together: specific resistance, energy over weight times distance.

    FILE has the columns walk, robot, mass_kg, distance_m and energy_Wh, or charge_mAh and voltage_V, in any units that
    their names say. The robots are compared within walks, by the logarithm of their ratio (thesis 2.2.3).

    Example: labbook study field walks.csv --plot field.pdf
    """
    from labbook.actions.studies.field import field_study_of
    from labbook.presenting.studies.field import as_data, drawn, sentences
    from reports.figures.field import draw_field

    study = field_study_of(_text(file, plot), file, level, decimal)
    _show(as_data(study), sentences(study), lambda: draw_field(drawn(study)), plot, as_json)


@app.command()
def characterisation(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A CSV file, one trajectory a row.")],
    level: LevelOption = 0.95,
    plot: PlotOption = None,
    decimal: DecimalOption = None,
    as_json: JsonOption = False,
) -> None:
    """Measure what a leg's gains are in N/m and kg/s, from oscillations of a mass that stands on it.

    FILE has the columns file, gain, damping_gain, mass_kg and, where it was varied, neutral_cm; each file is a log with
    time_ms, position_mm (positive the way the leg is compressed) and velocity (m/s), in any units that their names say.
    A condition needs 250 points (thesis 4.2.6); three gains give a line.

    Example: labbook study characterisation trials.csv --plot gains.pdf
    """
    from labbook.actions.studies.characterisation import characterisation_of
    from labbook.cli.reading import read_text
    from labbook.presenting.studies.characterisation import HEAD, as_data, drawn, rows, sentences
    from labbook.terminal import columns
    from reports.figures.characterisation import draw_characterisation
    from reports.figures.kind import check_form

    check_form("--plot", plot)
    study = characterisation_of(file, lambda path: read_text(path, marked_utf_16=True), level, decimal)
    table = [] if as_json else ["", *columns(HEAD, rows(study))]
    _show(as_data(study), sentences(study), lambda: draw_characterisation(*drawn(study)), plot, as_json, table)


@app.command("force-plate")
def force_plate(
    where: WhereOption = None,
    window: Annotated[
        int | None, typer.Option("--window", metavar="N", help="Samples of the moving average; default: its corner.")
    ] = None,
    level: LevelOption = 0.95,
    plot: PlotOption = None,
    book: BookOption = None,
    as_json: JsonOption = False,
) -> None:
    """Compare the joules of a hop that force plate and leg say with those that the battery gave.

    Of the book's runs that have a plate's record, a log with the leg's length, and a recharge. Both clocks are aligned
    at the touchdowns; force and leg length go through the leg's kinematics and the motors' model (thesis 3.2.2).

    Example: labbook study force-plate --where "k_gain>=300" --plot plate.pdf
    """
    from labbook.actions.studies.force_plate import force_plate_of
    from labbook.presenting.studies.force_plate import HEAD, as_data, drawn, rows, sentences
    from labbook.terminal import columns, progress
    from reports.figures.force_plate import draw_force_plate
    from reports.figures.kind import check_form

    check_form("--plot", plot)
    with progress("study force-plate", None, shown=not as_json) as step:
        study = force_plate_of(book, where, window, level, step)
    table = [] if as_json else ["", *columns(HEAD, rows(study))]
    _show(as_data(study), sentences(study), lambda: draw_force_plate(*drawn(study)), plot, as_json, table)


@app.command()
def emulator(
    where: WhereOption = None,
    constant: Annotated[
        float, typer.Option("--constant", metavar="GAIN", help="The active-damping gain that is the same at all gains.")
    ] = 50.0,
    ratio: Annotated[
        float, typer.Option("--ratio", help="The extension gain over the active-damping gain that is scaled with it.")
    ] = 6.0,
    same: Annotated[
        float, typer.Option("--same", metavar="%", help="A change of the apex below it is not appreciable.")
    ] = 2.0,
    level: LevelOption = 0.95,
    plot: PlotOption = None,
    book: BookOption = None,
    as_json: JsonOption = False,
) -> None:
    """Compare constant and scaled active damping with compression-extension at each extension gain.

    Of the book's runs with joules and apexes: savings and lost height with their intervals, by the days that both
    sides share, and how savings go with the apex. Gains at which no controller jumps appreciably higher than at the one
    before are beyond the motors' torque limit, and are left out (thesis 4.3).

    Example: labbook study emulator --plot emulator.pdf
    """
    from labbook.actions.studies.emulator import emulator_study_of
    from labbook.presenting.studies.emulator import HEAD, as_data, drawn, rows, sentences
    from labbook.terminal import columns, progress
    from reports.figures.emulator import draw_emulator
    from reports.figures.kind import check_form

    check_form("--plot", plot)
    with progress("study emulator", None, shown=not as_json) as step:
        study = emulator_study_of(book, where, constant, ratio, same, level, step)
    table = [] if as_json else ["", *columns(HEAD, rows(study))]
    _show(as_data(study), sentences(study), lambda: draw_emulator(*drawn(study)), plot, as_json, table)
