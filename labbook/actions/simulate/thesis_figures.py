"""What `labbook sim figures` does: the figures of ch. 3 drawn, its claims judged, both written to a folder."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from matplotlib.figure import Figure

from data_schema.errors import UsageError, unknown_name
from labbook.presenting.simulation.published import claims_table
from reports.figures import thesis_comparisons as comparisons
from reports.figures import thesis_jumps as single
from reports.figures.kind import write_figure
from reports.tables.formats import csv_bytes, markdown_text
from simulator.thesis.claims import Finding, chapter_3_findings
from simulator.thesis.figures import Jumps, ThesisFigures

FORMATS = ("png", "pdf", "svg")


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


def _over_speed(data: ThesisFigures) -> tuple[Jumps, ...]:
    return data.over_velocity.jumps.ce, data.over_velocity.jumps.ad


def _over_ground(data: ThesisFigures) -> tuple[Jumps, ...]:
    return data.over_ground.jumps.ce, data.over_ground.jumps.ad


_ALL = (
    ThesisFigure(
        "3.2",
        "ground_functions",
        "The ground's stiffness, drag and added mass",
        single.GROUND_FUNCTIONS_CAPTION,
        lambda data: single.draw_ground_functions(data.ground_functions),
    ),
    ThesisFigure(
        "3.4",
        "body_and_toe",
        "Body and toe of a jump with either controller",
        single.BODY_AND_TOE_CAPTION,
        lambda data: single.draw_body_and_toe(data.example),
    ),
    ThesisFigure(
        "3.5",
        "energies",
        "Mechanical energies of a jump",
        single.ENERGIES_CAPTION,
        lambda data: single.draw_energies(data.energies),
    ),
    ThesisFigure(
        "3.6",
        "power_surface",
        "Power that the ground takes from the foot",
        single.POWER_SURFACE_CAPTION,
        lambda data: single.draw_power_surface(data.power_surface),
    ),
    ThesisFigure(
        "3.8",
        "cost_over_velocity",
        "Cost and efficiency over the initial velocity",
        comparisons.COST_OVER_SPEED_CAPTION,
        lambda data: comparisons.draw_over_speed(data.over_velocity, comparisons.COST),
        _over_speed,
    ),
    ThesisFigure(
        "3.9",
        "apex_over_velocity",
        "Apex height and mechanical energy over the initial velocity",
        comparisons.APEX_OVER_SPEED_CAPTION,
        lambda data: comparisons.draw_over_speed(data.over_velocity, comparisons.APEX),
        _over_speed,
    ),
    ThesisFigure(
        "3.11",
        "cost_over_ground",
        "Cost and efficiency over the ground",
        comparisons.COST_OVER_GROUNDS_CAPTION,
        lambda data: comparisons.draw_over_grounds(data.over_ground, comparisons.COST),
        _over_ground,
    ),
    ThesisFigure(
        "3.12",
        "apex_over_ground",
        "Apex height and mechanical energy over the ground",
        comparisons.APEX_OVER_GROUNDS_CAPTION,
        lambda data: comparisons.draw_over_grounds(data.over_ground, comparisons.APEX),
        _over_ground,
    ),
    ThesisFigure(
        "3.13",
        "joules_by_damping",
        "Cost over active damping, for feet, gains and grounds",
        comparisons.JOULES_BY_DAMPING_CAPTION,
        lambda data: comparisons.draw_joules_by_damping(data.over_damping),
        lambda data: (data.over_damping.jumps,),
    ),
)
THESIS_FIGURES: dict[str, ThesisFigure] = {figure.number: figure for figure in _ALL}
"""Number in the thesis -> figure; 3.1, 3.3 and 3.7 are sketches and measurements, `labbook sim grains` draws 3.10."""


@dataclass(frozen=True, slots=True)
class WrittenThesis:
    """What was written: the figures' files, that of the captions, the claims, and the files of these where any are."""

    figures: dict[str, Path]
    captions: Path
    findings: tuple[Finding, ...]
    tables: tuple[Path, ...]


def write_thesis_figures(folder: Path, form: str, only: Sequence[str], step: Callable[[str], None]) -> WrittenThesis:
    """Simulate, draw and write the figures of these numbers (all without any), and judge the claims about them."""
    if form not in FORMATS:
        raise unknown_name("format", form, FORMATS)
    for number in only:
        if number not in THESIS_FIGURES:
            raise UsageError(
                f"{number!r} is no figure of ch. 3 that a simulation makes: give one of {', '.join(THESIS_FIGURES)}."
            )
    folder.mkdir(parents=True, exist_ok=True)
    data, files, texts = ThesisFigures(), dict[str, Path](), list[str]()
    for number, figure in THESIS_FIGURES.items():
        if only and number not in only:
            continue
        file = folder / f"thesis_{number.replace('.', '_')}_{figure.name}.{form}"
        write_figure(figure.draw(data), file)
        files[number] = file
        texts.append(
            f"## Figure {number}: {figure.title}\n\n![{figure.title}]({file.name})\n\n{figure.full_caption(data)}\n"
        )
        step(f"figure {number}")
    captions = folder / "figures.md"
    captions.write_text("\n".join(texts), encoding="utf-8")
    found = chapter_3_findings(data, list(files))
    step("claims")
    tables: tuple[Path, ...] = ()
    if found:
        tables, table = (folder / "claims.csv", folder / "claims.md"), claims_table(found)
        tables[0].write_bytes(csv_bytes(table))
        tables[1].write_text(markdown_text(table), encoding="utf-8")
    return WrittenThesis(files, captions, found, tables)
