"""What `labbook sim figures` does: the figures of ch. 3 drawn, its claims judged, both written to a folder."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure

from data_schema.errors import UsageError, unknown_name
from labbook.presenting.simulation.published_results import claims_table
from reports.figures import thesis_comparisons, thesis_jumps
from reports.figures.kind import write_figure
from reports.tables.formats.as_csv import csv_bytes
from reports.tables.formats.as_markdown import markdown_text
from simulator.thesis.claims import Finding, claims, findings
from simulator.thesis.comparisons import Jumps
from simulator.thesis.figures import ThesisFigures


@dataclass(frozen=True, slots=True)
class ThesisFigure:
    """One figure: its number in the thesis, its file's name, what it shows, and how it is drawn.

    `jumps` are those that it summarizes; a figure of single motions has none.
    """

    number: str
    name: str
    title: str
    caption: str
    draw: Callable[[ThesisFigures], Figure]
    jumps: Callable[[ThesisFigures], tuple[Jumps, ...]] = lambda _figures: ()

    def full_caption(self, figures: ThesisFigures) -> str:
        """Return the caption, with how many of the jumps are ill-conditioned."""
        jumps = self.jumps(figures)
        if not jumps:
            return self.caption
        flagged = sum(int(part.ill_conditioned.sum()) for part in jumps)
        total = sum(part.ill_conditioned.size for part in jumps)
        return (
            f"{self.caption} {flagged} of {total} jumps are ill-conditioned: a decision of the sampled controller is "
            "close, or its damping lets errors grow."
        )


def _speed_jumps(figures: ThesisFigures) -> tuple[Jumps, ...]:
    return figures.over_velocity.jumps.ce, figures.over_velocity.jumps.ad


def _ground_jumps(figures: ThesisFigures) -> tuple[Jumps, ...]:
    return figures.over_ground.jumps.ce, figures.over_ground.jumps.ad


_ALL = (
    ThesisFigure(
        "3.2",
        "ground_functions",
        "The ground's stiffness, drag and added mass",
        thesis_jumps.GROUND_FUNCTIONS_CAPTION,
        lambda figures: thesis_jumps.draw_ground_functions(figures.ground_functions),
    ),
    ThesisFigure(
        "3.4",
        "body_and_toe",
        "Body and toe of a jump with either controller",
        thesis_jumps.BODY_AND_TOE_CAPTION,
        lambda figures: thesis_jumps.draw_body_and_toe(figures.example),
    ),
    ThesisFigure(
        "3.5",
        "energies",
        "Mechanical energies of a jump",
        thesis_jumps.ENERGIES_CAPTION,
        lambda figures: thesis_jumps.draw_energies(figures.energies),
    ),
    ThesisFigure(
        "3.6",
        "power_surface",
        "Power that the ground takes from the foot",
        thesis_jumps.POWER_SURFACE_CAPTION,
        lambda figures: thesis_jumps.draw_power_surface(figures.power_surface),
    ),
    ThesisFigure(
        "3.8",
        "cost_over_velocity",
        "Cost and efficiency over the initial velocity",
        thesis_comparisons.COST_OVER_SPEED_CAPTION,
        lambda figures: thesis_comparisons.draw_cost_over_speed(figures.over_velocity),
        _speed_jumps,
    ),
    ThesisFigure(
        "3.9",
        "apex_over_velocity",
        "Apex height and mechanical energy over the initial velocity",
        thesis_comparisons.APEX_OVER_SPEED_CAPTION,
        lambda figures: thesis_comparisons.draw_apex_over_speed(figures.over_velocity),
        _speed_jumps,
    ),
    ThesisFigure(
        "3.11",
        "cost_over_ground",
        "Cost and efficiency over the ground",
        thesis_comparisons.COST_OVER_GROUNDS_CAPTION,
        lambda figures: thesis_comparisons.draw_cost_over_grounds(figures.over_ground),
        _ground_jumps,
    ),
    ThesisFigure(
        "3.12",
        "apex_over_ground",
        "Apex height and mechanical energy over the ground",
        thesis_comparisons.APEX_OVER_GROUNDS_CAPTION,
        lambda figures: thesis_comparisons.draw_apex_over_grounds(figures.over_ground),
        _ground_jumps,
    ),
    ThesisFigure(
        "3.13",
        "joules_by_damping",
        "Cost over active damping, for feet, gains and grounds",
        thesis_comparisons.JOULES_BY_DAMPING_CAPTION,
        lambda figures: thesis_comparisons.draw_joules_by_damping(figures.over_damping),
        lambda figures: (figures.over_damping.jumps,),
    ),
)
THESIS_FIGURES: dict[str, ThesisFigure] = {figure.number: figure for figure in _ALL}
"""Number in the thesis -> figure; 3.1, 3.3, 3.7 and 3.10 are sketches, measurements and another simulator's."""


FORMATS = ("png", "pdf", "svg")


@dataclass(frozen=True, slots=True)
class WrittenFigure:
    """A figure and its file."""

    figure: ThesisFigure
    file: Path


@dataclass(frozen=True, slots=True)
class WrittenThesis:
    """What was written: figures, the file of captions, and the claims with their files where there are any.

    `earlier` are figures that the folder held before: captions and claims are about them, too. `claims_in_all`: how
    many claims there are about all figures.
    """

    figures: tuple[WrittenFigure, ...]
    earlier: tuple[WrittenFigure, ...]
    captions: Path
    findings: tuple[Finding, ...]
    tables: tuple[Path, ...]
    claims_in_all: int


def write_thesis_figures(folder: Path, form: str, only: Sequence[str], step: Callable[[str], None]) -> WrittenThesis:
    """Simulate, draw and write the figures of these numbers (all without any), and judge the claims about them.

    Captions and claims cover what the folder then holds: figures of an earlier call, too.
    """
    if form not in FORMATS:
        raise unknown_name("format", form, FORMATS)
    for number in only:
        if number not in THESIS_FIGURES:
            raise UsageError(
                f"{number!r} is no figure of ch. 3 that a simulation makes: give one of {', '.join(THESIS_FIGURES)}."
            )
    chosen = [figure for number, figure in THESIS_FIGURES.items() if not only or number in only]
    folder.mkdir(parents=True, exist_ok=True)
    data = ThesisFigures()
    written = []
    for figure in chosen:
        file = folder / _file_name(figure, form)
        write_figure(figure.draw(data), file)
        written.append(WrittenFigure(figure, file))
        step(f"figure {figure.number}")
    earlier = tuple(_earlier_figures(folder, chosen))
    shown = sorted((*written, *earlier), key=lambda item: list(THESIS_FIGURES).index(item.figure.number))
    captions = folder / "figures.md"
    captions.write_text(_captions(shown, data), encoding="utf-8")
    found = findings(data, [item.figure.number for item in shown])
    step("claims")
    tables: tuple[Path, ...] = ()
    if found:
        tables, table = (folder / "claims.csv", folder / "claims.md"), claims_table(found)
        tables[0].write_bytes(csv_bytes(table))
        tables[1].write_text(markdown_text(table), encoding="utf-8")
    return WrittenThesis(tuple(written), earlier, captions, found, tables, len(claims()))


def _file_name(figure: ThesisFigure, form: str) -> str:
    return f"thesis_{figure.number.replace('.', '_')}_{figure.name}.{form}"


def _earlier_figures(folder: Path, drawn: Sequence[ThesisFigure]) -> Iterator[WrittenFigure]:
    """Yield the other figures that the folder holds, each in one of its forms."""
    for figure in THESIS_FIGURES.values():
        files = [folder / _file_name(figure, form) for form in FORMATS]
        file = next((file for file in files if file.exists()), None)
        if figure not in drawn and file is not None:
            yield WrittenFigure(figure, file)


def _captions(written: Sequence[WrittenFigure], data: ThesisFigures) -> str:
    """Write the figures with their captions as Markdown."""
    return "\n".join(
        f"## Figure {item.figure.number}: {item.figure.title}\n\n"
        f"![{item.figure.title}]({item.file.name})\n\n{item.figure.full_caption(data)}\n"
        for item in written
    )
