"""`labbook study`: studies of the thesis, each from what was measured to its verdict."""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from labbook.cli.common import BookOption, JsonOption, WhereOption
from labbook.terminal import columns, emit, progress, within_width

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LevelOption = Annotated[float, typer.Option("--level", help="Level of the intervals.")]
PlotOption = Annotated[Path | None, typer.Option("--plot", metavar="FILE", help="Draw it: a .png, .svg or .pdf file.")]
DecimalOption = Annotated[
    str | None, typer.Option("--decimal", metavar="SIGN", help="The table's decimal sign, where it is unclear.")
]

PageOption = Annotated[Path | None, typer.Option("--page", metavar="FILE", help="Write it as a page: a .html file.")]

app = typer.Typer(no_args_is_help=True)


class _Sheets:
    """Reads a study's text files, and remembers the hash of what it read."""

    def __init__(self, plot: Path | None, page: Path | None) -> None:
        """Check first that what they give can be shown."""
        _check_files(plot, page)
        self.sources: list[tuple[str, str]] = []

    def text(self, path: Path) -> str:
        """Read a file."""
        from labbook.cli.reading import decoded, read_file

        data = read_file(path)
        source = ("File", f"{path.name}, SHA-256 {hashlib.sha256(data).hexdigest()}")
        if source not in self.sources:
            self.sources.append(source)
        return decoded(path, data, marked_utf_16=True)


@dataclass(frozen=True, slots=True)
class _Shown:
    """What a study gives: data for programs, sentences with the answer first, a table, and a figure with its caption.

    `sources` are the sheets, or the book, that it comes from.
    """

    title: str
    data: dict[str, Any]
    said: list[str]
    draw: "Callable[[], Figure]"
    caption: str
    sources: Sequence[tuple[str, str]]
    head: Sequence[str] = ()
    rows: Sequence[Sequence[str]] = ()


def _show(shown: _Shown, plot: Path | None, page: Path | None, as_json: bool) -> None:
    from labbook.actions.simulate.pictures import save_plot

    if plot is not None:
        save_plot(shown.draw, plot)
    if page is not None:
        _write_page(shown, page)
    files = {name: str(path) for name, path in (("plot", plot), ("page", page)) if path is not None}
    table = ["", *columns(shown.head, shown.rows)] if shown.rows and not as_json else []
    emit({**shown.data, **files}, [*within_width(shown.said), *table, *files.values()], as_json)


def _write_page(shown: _Shown, page: Path) -> None:
    from data_schema.disk import write_whole
    from labbook.book.write_session import now_utc
    from reports.page.study import StudyPage, study_page

    made = StudyPage(
        shown.title,
        shown.said,
        shown.draw,
        shown.caption,
        shown.head,
        shown.rows,
        shown.sources,
        now_utc().split(".")[0] + "Z",
    )
    write_whole(page, study_page(made).encode("utf-8"))


def _check_files(plot: Path | None, page: Path | None) -> None:
    from reports.figures.kind import check_form

    check_form("--plot", plot)
    check_form("--page", page, (".html",))


@app.command()
def compaction(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A CSV file, one filled flask a row.")],
    grain: Annotated[float, typer.Option("--grain", metavar="MM", help="The grains' diameter, mm.")],
    level: LevelOption = 0.95,
    plot: PlotOption = None,
    page: PageOption = None,
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

    sheets = _Sheets(plot, page)
    study = compaction_of(sheets.text(file), file, grain, level, decimal)
    _show(
        _Shown(
            "How densely the grains lie",
            as_data(study),
            sentences(study),
            lambda: draw_compaction(drawn(study)),
            "Volume fractions over grain size / flask radius: flasks, lines, and the intervals without walls (at 0).",
            sheets.sources,
        ),
        plot,
        page,
        as_json,
    )


@app.command("field")
def field_walks(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A CSV file, one robot on one walk a row.")],
    level: LevelOption = 0.95,
    plot: PlotOption = None,
    page: PageOption = None,
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

    sheets = _Sheets(plot, page)
    study = field_study_of(sheets.text(file), file, level, decimal)
    _show(
        _Shown(
            "What two robots need on the same walks",
            as_data(study),
            sentences(study),
            lambda: draw_field(drawn(study)),
            "Specific resistance of both robots: each walk a line, and the means with their intervals.",
            sheets.sources,
        ),
        plot,
        page,
        as_json,
    )


@app.command()
def characterisation(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A CSV file, one trajectory a row.")],
    level: LevelOption = 0.95,
    plot: PlotOption = None,
    page: PageOption = None,
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
    from labbook.presenting.studies.characterisation import HEAD, as_data, drawn, rows, sentences
    from reports.figures.characterisation import draw_characterisation

    sheets = _Sheets(plot, page)
    study = characterisation_of(file, sheets.text, level, decimal)
    _show(
        _Shown(
            "What the leg's gains are in N/m and kg/s",
            as_data(study),
            sentences(study),
            lambda: draw_characterisation(*drawn(study)),
            "Stiffness over position gain and damping over velocity gain, by neutral length, with intervals and lines.",
            sheets.sources,
            HEAD,
            rows(study),
        ),
        plot,
        page,
        as_json,
    )


@app.command("force-plate")
def force_plate(
    where: WhereOption = None,
    window: Annotated[
        int | None, typer.Option("--window", metavar="N", help="Samples of the moving average; default: its corner.")
    ] = None,
    level: LevelOption = 0.95,
    plot: PlotOption = None,
    page: PageOption = None,
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
    from reports.figures.force_plate import draw_force_plate

    _check_files(plot, page)
    with progress("study force-plate", None, shown=not as_json) as step:
        found = force_plate_of(book, where, window, level, step)
    study = found.study
    _show(
        _Shown(
            "Joules of plate and leg against the battery's",
            as_data(study),
            sentences(study),
            lambda: draw_force_plate(*drawn(study)),
            "Force and leg length of one hop on one clock; joules estimated over measured, hops and line; the moving "
            "average's window, its corner, and the slope over it.",
            found.sources,
            HEAD,
            rows(study),
        ),
        plot,
        page,
        as_json,
    )


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
        float, typer.Option("--same", metavar="%", help="A rise of the apex below it is not appreciable.")
    ] = 2.0,
    level: LevelOption = 0.95,
    plot: PlotOption = None,
    page: PageOption = None,
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
    from reports.figures.emulator import draw_emulator

    _check_files(plot, page)
    with progress("study emulator", None, shown=not as_json) as step:
        found = emulator_study_of(book, where, constant, ratio, same, level, step)
    study = found.study
    _show(
        _Shown(
            "What active damping saves at each gain",
            as_data(study),
            sentences(study),
            lambda: draw_emulator(*drawn(study)),
            "Joules and apexes by extension gain, means and standard errors over runs; savings over the apex under CE.",
            found.sources,
            HEAD,
            rows(study),
        ),
        plot,
        page,
        as_json,
    )
