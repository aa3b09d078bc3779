"""From the effects that are on to what a kernel is composed of: the row of parameters and the functions of its slots,
the integrals, the forces on the body, and the guards and states that effects have of their own.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from simulator.compiled import Function, Row, inner
from simulator.effects.effect import BodyForce, Effect, Energy, Mode
from simulator.effects.registry import COSTS, EFFECTS, ENERGIES
from simulator.kernel.combined import in_turn
from simulator.kernel.effect_functions import EffectGuard, EffectState, Given, sorted_functions
from simulator.kernel.layout import GUARDS, MECHANICAL, PARAMETERS, SWITCHES
from simulator.parameter import BASICS, GRAVITY_M_S2, Parameter

Maker = Callable[["Composition"], Function]


@dataclass(frozen=True, slots=True)
class Composition:
    """What a kernel is built from. `position` holds the place of each parameter in the row, declared ones first."""

    effects: tuple[str, ...]
    parameters: tuple[Parameter, ...]
    position: Mapping[str, int]
    slots: Mapping[str, Function]
    prepare: Function
    integrals: Mapping[str, int]
    """Place in the state of each integral that only some effects call for."""
    body_forces: tuple[tuple[BodyForce, Function], ...]
    """What each effect says of its force on the body, and the function `(work, row)` that gives it, N."""
    effect_guards: tuple[EffectGuard, ...]
    effect_states: tuple[EffectState, ...]
    made: dict[Maker, Function] = field(default_factory=dict, compare=False, repr=False)
    """What `made_once` has composed already."""

    def has(self, slot: str) -> bool:
        """Whether an effect that is on fills this slot."""
        return slot in self.slots

    def slot(self, name: str) -> Any:
        """The function that fills a slot; None where no effect does, for code that `has` keeps from being compiled."""
        return self.slots.get(name)

    def optional(self, name: str) -> tuple[bool, Any]:
        """Whether an effect that is on fills a slot, and the function that does, or None."""
        return self.has(name), self.slot(name)

    def on(self, effect: str) -> bool:
        """Whether this effect is on."""
        return effect in self.effects

    @property
    def row_size(self) -> int:
        """Length of the row that the kernel works in; parameters are the last of it."""
        return PARAMETERS + len(self.position)

    @property
    def integrals_end(self) -> int:
        """Place in the state after motion and integrals."""
        return MECHANICAL + 1 + len(self.integrals)

    @property
    def platform(self) -> int:
        """Place in the state of a sliding platform's height, before that of its speed; -1 where it has no mass."""
        return self.integrals_end + len(self.effect_states) if self.has("platform_mass_kg") else -1

    @property
    def state_size(self) -> int:
        """Number of states: motion and integrals, those of effects, and a platform's."""
        return self.integrals_end + len(self.effect_states) + (2 if self.has("platform_mass_kg") else 0)

    @property
    def follows(self) -> bool:
        """Whether a foot may be light enough to follow the ground without inertia: on a platform that has none, under a
        force that depends on its speed as is commanded.
        """
        return self.has("travel_m") and not self.has("platform_mass_kg") and not self.has("cap_slows")

    @property
    def samples_speed(self) -> bool:
        """Whether active damping takes the foot's speed as it was at the last tick."""
        return self.on("sampled_control") and not self.on("continuous_foot_speed")

    @property
    def costs(self) -> tuple[Energy, ...]:
        """The parts of the cost that effects compute."""
        return tuple(energy for energy in COSTS if energy.name in self.integrals)

    def closed_form(self, mode: Mode) -> bool:
        """Whether neither a force on the body nor a state of an effect keeps the motion in a mode from having one."""
        return not self.effect_states and not any(mode in force.breaks_closed_form for force, _ in self.body_forces)

    @property
    def levered(self) -> bool:
        """Whether anything in force asks for the lever arm of the joint."""
        return bool(self.costs) or self.has("cap_bends") or self.has("cost_cap_n")

    @property
    def straight_ends_flight(self) -> bool:
        """Whether a leg that is straight in flight ends the jump: on hard ground, and where its speed is braked."""
        braked = self.on("cost_of_whole_jump") and any(energy.singular for energy in self.costs)
        return self.on("touchdown_impact") or braked or (self.has("cap_slows") and not self.has("lever_m"))

    @property
    def guards(self) -> int:
        """Number of guards: a controller with a clock needs none for its conditions."""
        return SWITCHES if self.on("sampled_control") else GUARDS

    @property
    def contact_at_the_print(self) -> bool:
        """Whether gains of flight that do not lift the foot cancel a lift-off: on grains, where they differ."""
        alike = self.on("held_gains_in_flight") or self.on("massless_leg_in_flight")
        return self.on("hydrostatic_stiffness") and not self.on("contact_once_risen") and not alike

    @property
    def sleeps_in_flight(self) -> bool:
        """Whether the controller waits for the ground in flight: on grains it does, on hard ground it never looks."""
        return not self.on("touchdown_impact")


def made_once(make: Maker) -> Maker:
    """Let parts that compose the same function share one, which is then compiled once."""

    @functools.wraps(make)
    def made(composition: Composition) -> Function:
        if make not in composition.made:
            composition.made[make] = make(composition)
        return composition.made[make]

    return made


_INVERSES = (
    "inverse_body_mass",
    "inverse_foot_mass",
    "inverse_rest_length",
    "inverse_fall_speed",
    "inverse_lift_energy",
)
"""Derived in every scene, as a multiplication takes a fifth of the time of a division: for the equations of motion, and
for the error of a step (the speed of a fall through the rest length, the energy to lift the robot by it)."""


def _prepare_inverses(position: Mapping[str, int]) -> Function:
    body, foot, rest = position["body_mass"], position["foot_mass"], position["rest_length"]
    per_body, per_foot, per_rest, per_fall, per_lift = (position[name] for name in _INVERSES)

    @inner
    def prepare(work: Row) -> None:
        work[per_body], work[per_foot] = 1.0 / work[body], 1.0 / work[foot]
        work[per_rest] = 1.0 / work[rest]
        work[per_fall] = 1.0 / math.sqrt(GRAVITY_M_S2 * work[rest])
        work[per_lift] = 1.0 / ((work[body] + work[foot]) * GRAVITY_M_S2 * work[rest])

    return prepare


def compose(effects: Iterable[str]) -> Composition:
    """Compose what is called for; the order in which effects are named does not matter."""
    chosen: tuple[Effect, ...] = tuple(EFFECTS[name] for name in EFFECTS if name in set(effects))
    parameters = tuple(dict.fromkeys((*BASICS, *(parameter for effect in chosen for parameter in effect.parameters))))
    names = [parameter.name for parameter in parameters] + [*_INVERSES]
    names += [name for effect in chosen for name in effect.derived]
    _check_names("parameter or derived number", names)
    position = {name: PARAMETERS + place for place, name in enumerate(names)}
    called_for = {energy for effect in chosen for energy in effect.all_energies}
    wanted = [energy.name for energy in ENERGIES if energy in called_for and not energy.sudden]
    prepare, given = _prepare_inverses(position), list[Given]()
    next_state = MECHANICAL + 1 + len(wanted)
    slots: dict[str, Function] = {}
    for effect in chosen:
        one = sorted_functions(effect, position.__getitem__, next_state)
        next_state += len(one.states)
        if one.prepare is not None:
            prepare = in_turn((prepare, one.prepare))
        if twice := one.slots.keys() & slots.keys():
            raise ValueError(f"{effect.name} fills {min(twice)}, as another effect does: let both exclude each other.")
        slots |= one.slots
        given.append(one)
    guards = tuple(guard for one in given for guard in one.guards)
    states = tuple(state for one in given for state in one.states)
    _check_names("guard", [one.guard.name for one in guards])
    _check_names("state or energy", [one.state.name for one in states] + [energy.name for energy in called_for])
    return Composition(
        effects=tuple(effect.name for effect in chosen),
        parameters=parameters,
        position=position,
        slots=slots,
        prepare=prepare,
        integrals={name: MECHANICAL + 1 + place for place, name in enumerate(wanted)},
        body_forces=tuple(one.body_force for one in given if one.body_force is not None),
        effect_guards=guards,
        effect_states=states,
    )


def _check_names(what: str, names: list[str]) -> None:
    """Raise `ValueError` where two things that effects declare have one name."""
    for name in sorted(set(names)):
        if names.count(name) > 1:
            raise ValueError(f"{names.count(name)} times there is a {what} {name}: let each have a name of its own.")
