"""Every effect, by name: a new one is a file beside this one and a line here."""

from __future__ import annotations

from simulator.effects import (
    active_damping,
    added_mass,
    air_drag,
    constant_force_cap,
    contact_once_risen,
    continuous_foot_speed,
    cost_of_commanded_force,
    cost_of_whole_jump,
    cost_torque_cap,
    drag,
    emulated_ground,
    held_force,
    held_gains_in_flight,
    hydrostatic_stiffness,
    inertial_drag,
    latched_switching,
    leg_damping,
    linear_active_damping,
    linear_leg,
    massless_leg_in_flight,
    motor_heat,
    no_regeneration,
    passive_draw,
    platform_mass,
    rail_friction,
    rigid_ground,
    sampled_control,
    scaled_active_damping,
    short_leg_guard,
    torque_cap,
    touchdown_impact,
    voltage_cap,
)
from simulator.effects.effect import Effect, Energy, Guard, State

EFFECTS: dict[str, Effect] = {
    module.EFFECT.name: module.EFFECT
    for module in (
        hydrostatic_stiffness,
        inertial_drag,
        added_mass,
        rigid_ground,
        emulated_ground,
        platform_mass,
        touchdown_impact,
        linear_leg,
        leg_damping,
        active_damping,
        scaled_active_damping,
        linear_active_damping,
        sampled_control,
        continuous_foot_speed,
        held_force,
        latched_switching,
        short_leg_guard,
        constant_force_cap,
        torque_cap,
        voltage_cap,
        contact_once_risen,
        held_gains_in_flight,
        massless_leg_in_flight,
        motor_heat,
        drag,
        cost_of_commanded_force,
        cost_torque_cap,
        no_regeneration,
        cost_of_whole_jump,
        passive_draw,
        rail_friction,
        air_drag,
    )
}

ENERGIES: tuple[Energy, ...] = tuple(
    dict.fromkeys(energy for effect in EFFECTS.values() for energy in effect.all_energies)
)
"""Every energy that an effect turns over."""
BOOKED = tuple(energy for energy in ENERGIES if energy.sign)
COSTS = tuple(energy for energy in ENERGIES if not energy.sign)
"""Those in the energy book, and the parts of the cost beside the mechanical one."""
GUARDS: tuple[Guard, ...] = tuple(dict.fromkeys(guard for effect in EFFECTS.values() for guard in effect.guards))
STATES: tuple[State, ...] = tuple(dict.fromkeys(state for effect in EFFECTS.values() for state in effect.states))
"""Every event and every state that an effect has of its own."""
