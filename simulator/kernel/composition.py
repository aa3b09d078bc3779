"""From the effects that are on to what a kernel is composed of: the row of parameters and the functions of its slots,
the integrals, the forces on the body, and the guards and states that effects have of their own.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from simulator.basics import BASICS, GRAVITY_M_S2
from simulator.compiled import inlined, inner
from simulator.effects.effect import MODES, BodyForce, Effect, Energy, Function, Guard, Mode, State
from simulator.effects.registry import COSTS, EFFECTS, ENERGIES
from simulator.effects.registry import GUARDS as EFFECT_GUARDS
from simulator.kernel.layout import (
    GUARDS,
    MECHANICAL,
    OF_EFFECTS,
    PARAMETERS,
    SWITCHES,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)
from simulator.parameter import Parameter

Row = NDArray[np.float64]
Maker = Callable[["Composition"], Function]
Functions = dict[str, Function]


@dataclass(frozen=True, slots=True)
class EffectGuard:
    """An effect's guard: its place among the guards, and `(work, row)` for its value and for what happens there."""

    guard: Guard
    place: int
    value: Function
    happens: Function | None


@dataclass(frozen=True, slots=True)
class EffectState:
    """An effect's state: its place, `(work, row)` for its rate, `(work, height_m, velocity_m_s)` for its start."""

    state: State
    place: int
    rate: Function
    start: Function | None


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
        """Whether a foot may be light enough to follow the ground without inertia: on a platform that has none."""
        return self.has("travel_m") and not self.has("platform_mass_kg")

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
        return self.on("touchdown_impact") or (
            self.on("cost_of_whole_jump") and any(energy.singular for energy in self.costs)
        )

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


OF_FORCE = frozenset({"body_force_n", "body_held", "hold_guard", "body_stops", "body_moves"})
"""Functions of a force on the body; all but the first are those of one that holds."""

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


def _after(first: Function, second: Function) -> Function:
    @inner
    def both(work: Row) -> None:
        first(work)
        second(work)

    return both


def compose(effects: Iterable[str]) -> Composition:
    """Compose what is called for; the order in which effects are named does not matter."""
    chosen: tuple[Effect, ...] = tuple(EFFECTS[name] for name in EFFECTS if name in set(effects))
    parameters = tuple(dict.fromkeys((*BASICS, *(parameter for effect in chosen for parameter in effect.parameters))))
    names = [parameter.name for parameter in parameters] + [*_INVERSES]
    names += [name for effect in chosen for name in effect.derived]
    position = {name: PARAMETERS + place for place, name in enumerate(names)}
    called_for = {energy for effect in chosen for energy in effect.all_energies}
    wanted = [energy.name for energy in ENERGIES if energy in called_for and not energy.sudden]
    slots: Functions = {}
    forces: list[tuple[BodyForce, Function]] = []
    guards: list[EffectGuard] = []
    states: list[EffectState] = []
    prepare = _prepare_inverses(position)
    next_state = MECHANICAL + 1 + len(wanted)
    for effect in chosen:
        functions = dict(effect.functions(position.__getitem__))
        if "prepare" in functions:
            prepare = _after(prepare, functions.pop("prepare"))
        values = _values(range(next_state, next_state + len(effect.states)))
        next_state += len(effect.states)
        forces += _force_of(effect, functions, values)
        guards += _guards_of(effect, functions, values)
        states += _states_of(effect, functions, values, next_state - len(effect.states))
        _check_costs(effect, functions)
        if twice := functions.keys() & slots.keys():
            raise ValueError(f"{effect.name} fills {min(twice)}, as another effect does: let both exclude each other.")
        slots |= functions
    return Composition(
        effects=tuple(effect.name for effect in chosen),
        parameters=parameters,
        position=position,
        slots=slots,
        prepare=prepare,
        integrals={name: MECHANICAL + 1 + place for place, name in enumerate(wanted)},
        body_forces=tuple(forces),
        effect_guards=tuple(guards),
        effect_states=tuple(states),
    )


def _values(places: Iterable[int]) -> Function | None:
    """Compose `(work, row)`: the tuple of an effect's states at these places; None without any."""
    found: Function | None = None
    for place in places:
        found = _with_value(found, place)
    return found


def _with_value(before: Function | None, place: int) -> Function:
    if before is None:
        return inner(lambda work, row: (work[row + place],))
    return inner(lambda work, row: (*before(work, row), work[row + place]))


def _of_body(function: Function, values: Function | None) -> Function:
    """Compose `(work, row)` of a function of the body's height and velocity, and of an effect's states."""
    if values is None:
        return inlined(lambda work, row: function(work, work[row + X_BODY], work[row + V_BODY]))
    return inlined(lambda work, row: function(work, work[row + X_BODY], work[row + V_BODY], values(work, row)))


def _of_motion(function: Function, values: Function | None) -> Function:
    """Compose `(work, row)` of a function of heights and velocities of body and foot, and of an effect's states."""
    if values is None:

        @inlined
        def of_motion(work: Row, row: int) -> Any:
            return function(work, work[row + X_BODY], work[row + V_BODY], work[row + X_FOOT], work[row + V_FOOT])

        return of_motion

    @inlined
    def of_motion_and_states(work: Row, row: int) -> Any:
        x_b, v_b, x_f, v_f = work[row + X_BODY], work[row + V_BODY], work[row + X_FOOT], work[row + V_FOOT]
        return function(work, x_b, v_b, x_f, v_f, values(work, row))

    return of_motion_and_states


def _taken(effect: Effect, functions: Functions, name: str) -> Function:
    """Take a function that the effect's guards and states ask for; raises `ValueError` where there is none."""
    if name not in functions:
        raise ValueError(f"{effect.name} does not give {name}, which its guards and states ask for: let it give one.")
    return functions.pop(name)


def _guards_of(effect: Effect, functions: Functions, values: Function | None) -> list[EffectGuard]:
    """Take an effect's guards out of its functions."""
    found = []
    for guard in effect.guards:
        value = _of_motion(_taken(effect, functions, f"{guard.name}_guard"), values)
        happens = functions.pop(f"{guard.name}_happens", None)
        place = OF_EFFECTS + EFFECT_GUARDS.index(guard)
        found.append(EffectGuard(guard, place, value, None if happens is None else _of_motion(happens, values)))
    return found


def _states_of(effect: Effect, functions: Functions, values: Function | None, first: int) -> list[EffectState]:
    """Take an effect's states, which stand from a place on, out of its functions."""
    return [
        EffectState(
            state,
            first + number,
            _of_body(_taken(effect, functions, f"{state.name}_rate"), values),
            functions.pop(f"{state.name}_start", None),
        )
        for number, state in enumerate(effect.states)
    ]


def _check_costs(effect: Effect, functions: Mapping[str, Function]) -> None:
    """Raise `ValueError` where an effect gives the power of no energy, or a part of the cost without its power."""
    powers = {name for name in functions if name.endswith("_w")}
    wanted = {f"{energy.name}_w" for energy in effect.energies if not energy.sign}
    if powers != wanted:
        raise ValueError(f"{effect.name} gives {sorted(powers)}, where its energies ask for {sorted(wanted)}.")


def _force_of(effect: Effect, functions: Functions, values: Function | None) -> tuple[tuple[BodyForce, Function], ...]:
    """Take out what gives an effect's force on the body, with what it says of it; nothing where it has none.

    Raises `ValueError` where it does not say in which modes the force acts, or where one of both is missing.
    """
    said, given = effect.body_force, functions.keys() & OF_FORCE
    wanted = set() if said is None else OF_FORCE if said.holds else {"body_force_n"}
    if given != wanted:
        raise ValueError(
            f"{effect.name} gives {sorted(given)}, where its body_force asks for {sorted(wanted)}: an effect that "
            "pushes the body says so by a BodyForce, with the modes in which it acts and breaks the closed form."
        )
    if said is None:
        return ()
    if not set(said.breaks_closed_form) <= set(said.modes) <= set(MODES):
        raise ValueError(
            f"{effect.name} acts in {said.modes} and breaks the closed form in {said.breaks_closed_form}: let it act "
            f"wherever it does, of {MODES}."
        )
    return ((said, _of_body(functions.pop("body_force_n"), values)),)
