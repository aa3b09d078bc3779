"""The figures of ch. 3 that the simulator can make: the data of each, as its drawing takes it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from matplotlib.figure import Figure

from reports import thesis_content as content
from reports.figures import (
    thesis_apex_over_grounds,
    thesis_apex_over_speed,
    thesis_body_and_toe,
    thesis_cost_over_grounds,
    thesis_cost_over_speed,
    thesis_energies,
    thesis_ground_functions,
    thesis_joules_by_damping,
    thesis_power_surface,
)
from simulator.thesis.controllers import Pair
from simulator.thesis.energies import JumpEnergies
from simulator.thesis.figures import ThesisFigures
from simulator.thesis.jump_grid import Jumps
from simulator.thesis.motions import Motion


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


def _ground_functions(figures: ThesisFigures) -> Figure:
    data = figures.ground_functions
    return thesis_ground_functions.draw_ground_functions(
        content.GroundCurves(data.depth_m, data.resistance_n, data.drag_kg_m, data.added_mass_kg, data.cone_depth_m)
    )


def _path(motion: Motion) -> content.JumpPath:
    return content.JumpPath(
        time_s=motion.time_s,
        body_height_m=motion.body_height_m,
        toe_height_m=motion.foot_height_m,
        toe_velocity_m_s=motion.foot_velocity_m_s,
        switch_time_s=motion.switch_time_s,
        liftoff_time_s=motion.liftoff_time_s,
    )


def _paths(motions: Pair[Motion]) -> content.TwoPaths:
    return content.TwoPaths(ce=_path(motions.ce), ad=_path(motions.ad))


def _body_and_toe(figures: ThesisFigures) -> Figure:
    return thesis_body_and_toe.draw_body_and_toe(_paths(figures.example))


def _energy_curves(energies: JumpEnergies) -> content.EnergyCurves:
    return content.EnergyCurves(
        time_s=energies.motion.time_s,
        leg_spring_j=energies.leg_spring_j,
        body_kinetic_j=energies.body_kinetic_j,
        body_gravity_j=energies.body_gravity_j,
        ground_spring_j=energies.ground_spring_j,
        foot_kinetic_j=energies.foot_kinetic_j,
        foot_gravity_j=energies.foot_gravity_j,
        total_j=energies.total_j,
        switch_time_s=energies.motion.switch_time_s,
        liftoff_time_s=energies.motion.liftoff_time_s,
    )


def _energies(figures: ThesisFigures) -> Figure:
    pair = figures.energies
    return thesis_energies.draw_energies(content.TwoEnergies(ce=_energy_curves(pair.ce), ad=_energy_curves(pair.ad)))


def _power_surface(figures: ThesisFigures) -> Figure:
    data = figures.power_surface
    paths = tuple(_paths(motions) for motions in data.motions)
    return thesis_power_surface.draw_power_surface(
        content.PowerMap(data.depth_m, data.velocity_m_s, data.power_w, paths)
    )


def _measures(jumps: Jumps) -> content.Measures:
    return content.Measures(jumps.cost_j, jumps.efficiency, jumps.apex_height_m, jumps.mechanical_j)


def _speed_jumps(figures: ThesisFigures) -> tuple[Jumps, ...]:
    return figures.over_velocity.jumps.ce, figures.over_velocity.jumps.ad


def _ground_jumps(figures: ThesisFigures) -> tuple[Jumps, ...]:
    return figures.over_ground.jumps.ce, figures.over_ground.jumps.ad


def _over_speed(figures: ThesisFigures) -> content.OverSpeed:
    data = figures.over_velocity
    return content.OverSpeed(data.touchdown_speed_m_s, ce=_measures(data.jumps.ce), ad=_measures(data.jumps.ad))


def _over_grounds(figures: ThesisFigures) -> content.OverGrounds:
    data, scene = figures.over_ground, figures.set_1
    return content.OverGrounds(
        stress_n_m3=data.sigma_n_m3,
        drag_scale=data.drag_scale,
        nominal_stress_n_m3=scene["sigma"],
        nominal_drag_scale=scene["b_g"],
        ce=_measures(data.jumps.ce),
        ad=_measures(data.jumps.ad),
    )


def _joules_by_damping(figures: ThesisFigures) -> Figure:
    data = figures.over_damping
    return thesis_joules_by_damping.draw_joules_by_damping(
        content.DampingCosts(
            stiffness_factors=data.stiffness_factors,
            drag_factors=data.drag_factors,
            extension_gains=data.extension_gains,
            extension_stiffnesses_n_m=data.extension_stiffnesses_n_m,
            foot_radii_m=data.foot_radii_m,
            active_damping_kg_m=data.active_damping_kg_m,
            cost_j=data.jumps.cost_j,
        )
    )


_ALL = (
    ThesisFigure(
        "3.2",
        "ground_functions",
        "The ground's stiffness, drag and added mass",
        thesis_ground_functions.CAPTION,
        _ground_functions,
    ),
    ThesisFigure(
        "3.4",
        "body_and_toe",
        "Body and toe of a jump with either controller",
        thesis_body_and_toe.CAPTION,
        _body_and_toe,
    ),
    ThesisFigure("3.5", "energies", "Mechanical energies of a jump", thesis_energies.CAPTION, _energies),
    ThesisFigure(
        "3.6",
        "power_surface",
        "Power that the ground takes from the foot",
        thesis_power_surface.CAPTION,
        _power_surface,
    ),
    ThesisFigure(
        "3.8",
        "cost_over_velocity",
        "Cost and efficiency over the initial velocity",
        thesis_cost_over_speed.CAPTION,
        lambda figures: thesis_cost_over_speed.draw_cost_over_speed(_over_speed(figures)),
        _speed_jumps,
    ),
    ThesisFigure(
        "3.9",
        "apex_over_velocity",
        "Apex height and mechanical energy over the initial velocity",
        thesis_apex_over_speed.CAPTION,
        lambda figures: thesis_apex_over_speed.draw_apex_over_speed(_over_speed(figures)),
        _speed_jumps,
    ),
    ThesisFigure(
        "3.11",
        "cost_over_ground",
        "Cost and efficiency over the ground",
        thesis_cost_over_grounds.CAPTION,
        lambda figures: thesis_cost_over_grounds.draw_cost_over_grounds(_over_grounds(figures)),
        _ground_jumps,
    ),
    ThesisFigure(
        "3.12",
        "apex_over_ground",
        "Apex height and mechanical energy over the ground",
        thesis_apex_over_grounds.CAPTION,
        lambda figures: thesis_apex_over_grounds.draw_apex_over_grounds(_over_grounds(figures)),
        _ground_jumps,
    ),
    ThesisFigure(
        "3.13",
        "joules_by_damping",
        "Cost over active damping, for feet, gains and grounds",
        thesis_joules_by_damping.CAPTION,
        _joules_by_damping,
        lambda figures: (figures.over_damping.jumps,),
    ),
)
THESIS_FIGURES: dict[str, ThesisFigure] = {figure.number: figure for figure in _ALL}
"""Number in the thesis -> figure; 3.1, 3.3, 3.7 and 3.10 are sketches, measurements and another simulator's."""
