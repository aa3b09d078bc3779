"""The figures of ch. 3 that the simulator can make, as data: of what each is drawn, and how."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from matplotlib.figure import Figure

from reports.figures import thesis_comparisons, thesis_jumps
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
