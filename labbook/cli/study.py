"""`labbook study`: studies of the thesis, each from what was measured to its verdict.

What studies have in common is declared once, in `OfAny`, `OfSheet` and `OfRuns`.
"""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from data_schema.errors import InputRefused, UsageError
from labbook.cli.common import BookOption, PlotOption, WhereOption, opened
from labbook.config.studies import STUDIES
from labbook.terminal import Shown, columns, plain, progress, with_files, within_width

if TYPE_CHECKING:
    from labbook.studies.study import Found
    from reports.page.study import Study


@dataclass(frozen=True, slots=True)
class OfAny:
    """The options of every study."""

    level: Annotated[float | None, typer.Option(help="Level of the intervals; usual: 0.95.")] = None
    plot: PlotOption = None
    page: Annotated[Path | None, typer.Option(metavar="FILE", help="Write it as a page: a .html file.")] = None
    book: BookOption = None


@dataclass(frozen=True, slots=True)
class OfSheet(OfAny):
    """The options of a study that is kept as a sheet."""

    file: Annotated[
        Path | None, typer.Argument(metavar="[FILE]", help="A CSV file; without one, the book's sheet.")
    ] = None
    decimal: Annotated[
        str | None, typer.Option(metavar="SIGN", help="The table's decimal sign, where it is unclear.")
    ] = None
    complete: Annotated[
        bool, typer.Option("--complete", help="The last line of a file is whole, though it has no line end.")
    ] = False


@dataclass(frozen=True, slots=True)
class OfRuns(OfAny):
    """The options of a study of runs."""

    where: WhereOption = None


app = typer.Typer(no_args_is_help=True)


def _show(name: str, shared: OfAny, **own: Any) -> Shown:
    """Ask a study with the options that it shares with others, and its own."""
    from reports.display import BESIDE
    from reports.figures.kind import check_form, write_figure

    options = asdict(shared)
    plot, page = options.pop("plot"), options.pop("page")
    check_form("--plot", plot)
    check_form("--page", page, (".html",))
    found = _asked(name, **options, **own)
    study = found.study
    if plot is not None:
        write_figure(study.draw(), plot)
    if page is not None:
        _write_page(found, page)
    lines = within_width(study.sentences())
    for head, *rows in (table for table in (study.table(), [BESIDE, *study.beside()]) if len(table) > 1):
        lines += ["", *columns(head, rows)]
    return with_files(_data(study), lines, {"plot": plot, "page": page})


def _asked(
    name: str,
    book: Path | None,
    file: Path | None = None,
    complete: bool = False,
    **options: Any,
) -> "Found[Study]":
    """Ask a study; `options` are those that labbook.toml may have too."""
    from labbook.config.model import StudyProtocol
    from labbook.studies.registry import ask
    from labbook.studies.study import Asked

    with progress(f"study {name}", None) as step:
        return ask(name, Asked(book, file, StudyProtocol(**options), complete, step))


def _data(study: "Study") -> dict[str, Any]:
    """Return a study for JSON: its fields, and what stands beside as a person reads it."""
    from reports.display import BESIDE

    return {**plain(study), "beside": [dict(zip(BESIDE, row, strict=True)) for row in study.beside()]}


def _write_page(found: "Found[Study]", page: Path) -> None:
    from data_schema.disk import write_whole
    from labbook.book.write_session import now_utc
    from reports.page.study import study_page

    made_at = now_utc().split(".")[0] + "Z"
    write_whole(page, study_page(found.study, found.sources, found.files, made_at).encode("utf-8"))


@app.command()
def compaction(
    shared: OfSheet,
    grain: Annotated[float | None, typer.Option(metavar="MM", help="The grains' diameter, mm.")] = None,
) -> Shown:
    """Show how densely a bed's grains lie, poured and compacted, from the water that fills flasks of several sizes.

    FILE, else the sheet in the book, has the columns radius_mm, state (two words, such as loose and compacted) and
    water_ml, in any units that their names say, and flask_ml where the flasks' volumes were measured. The fractions are
    extrapolated over grain size / radius to a bed without walls (thesis 5.1.2).

    Example: labbook study compaction flasks.csv --grain 3.4 --plot compaction.pdf
    """
    return _show("compaction", shared, grain_mm=grain)


@app.command("field")
def field_walks(shared: OfSheet) -> Shown:
    """Compare what two robots need that walk together: specific resistance, energy over weight times distance.

    FILE, else the sheet in the book, has the columns walk, robot, mass_kg, distance_m and energy_Wh, or charge_mAh and
    voltage_V, or log, a file with time_s and power_W, or current_A and voltage_V; in any units that names say. The
    robots are compared within walks, by the logarithm of their ratio (thesis 2.2.3).

    Example: labbook study field walks.csv --plot field.pdf
    """
    return _show("field", shared)


@app.command()
def characterisation(shared: OfSheet) -> Shown:
    """Measure what a leg's gains are in N/m and kg/s, from oscillations of a mass that stands on it.

    FILE, else the sheet in the book, has the columns file, gain, damping_gain, mass_kg and, where it was varied,
    neutral_cm; each file is a log with time_ms, position_mm (positive the way the leg is compressed) and velocity
    (m/s), in any units that their names say.
    A condition needs 250 points (thesis 4.2.6); three gains give a line.

    Example: labbook study characterisation trials.csv --plot gains.pdf
    """
    return _show("characterisation", shared)


@app.command("force-plate")
def force_plate(
    shared: OfRuns,
    window: Annotated[
        int | None, typer.Option(metavar="N", help="Samples of the moving average; default: its corner.")
    ] = None,
) -> Shown:
    """Compare the joules of a hop that force plate and leg say with those that the battery gave.

    Of the book's runs that have a plate's record, a log with the leg's length, and a recharge. Both clocks are aligned
    at the touchdowns; force and leg length go through the leg's kinematics and the motors' model (thesis 3.2.2).

    Example: labbook study force-plate --where "k_gain>=300" --plot plate.pdf
    """
    return _show("force-plate", shared, window=window)


@app.command()
def emulator(
    shared: OfRuns,
    constant: Annotated[
        float | None,
        typer.Option(metavar="GAIN", help="The active-damping gain that is the same at all; usual: 50."),
    ] = None,
    ratio: Annotated[
        float | None,
        typer.Option(help="The extension gain over the damping gain that is scaled with it; usual: 6."),
    ] = None,
    same: Annotated[
        float | None,
        typer.Option(metavar="%", help="A rise of the apex below it is not appreciable; usual: 2."),
    ] = None,
) -> Shown:
    """Compare constant and scaled active damping with compression-extension at each extension gain.

    Of the book's runs with joules and apexes: savings and lost height with their intervals, by the days that both
    sides share, and how savings go with the apex. Gains at which no controller jumps appreciably higher than at the one
    before are beyond the motors' torque limit, and are left out (thesis 4.3).

    Example: labbook study emulator --plot emulator.pdf
    """
    return _show("emulator", shared, constant=constant, ratio=ratio, same_percent=same)


def _of_runs(name: str) -> None:
    """Add the command of a study of runs that has no options of its own."""

    def command(shared: OfRuns) -> Shown:
        return _show(name, shared)

    command.__doc__ = STUDIES[name].help
    app.command(name)(command)


for _name, _entry in STUDIES.items():
    if _entry.help:
        _of_runs(_name)


@app.command("all")
def all_studies(
    pages: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write each as a page into a folder, as NAME.html.")
    ] = None,
    book: BookOption = None,
) -> Shown:
    """Show every study of a book: those whose sheet it has, that labbook.toml names, or that it was made for.

    Each is asked with what [studies.NAME] of labbook.toml says. The exit code is 2 where one cannot be made.

    Example: labbook study all --pages studies/
    """
    from labbook.studies.registry import studies_of_book

    if pages is not None and pages.exists() and not pages.is_dir():
        raise UsageError(f"--pages {pages} is a file: name a folder; it is made where there is none.")
    if pages is not None:
        pages.mkdir(parents=True, exist_ok=True)
    with opened(book) as opened_book, opened_book.reading() as connection:
        names = studies_of_book(connection, opened_book.configuration)
    if not names:
        raise InputRefused(
            "the book has no study: ingest a study's sheet, or write [studies.NAME] in labbook.toml, NAME being one of "
            f"{', '.join(STUDIES)}."
        )
    data: dict[str, Any] = {}
    lines: list[str] = []
    for name in names:
        try:
            found = _asked(name, book)
        except (InputRefused, UsageError) as error:
            data[name] = {"refused": str(error)}
            lines += [f"{name}: refused", *within_width([str(error)]), ""]
            continue
        data[name] = _data(found.study)
        lines += [f"{name}: {found.study.title}", *within_width(found.study.sentences())]
        if pages is not None:
            page = pages / f"{name}.html"
            _write_page(found, page)
            data[name]["page"] = str(page)
            lines.append(str(page))
        lines.append("")
    return Shown(data, lines[:-1], 2 if any("refused" in one for one in data.values()) else 0)
