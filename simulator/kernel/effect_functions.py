"""What an effect gives a kernel: its functions for slots, force on the body, guards and states, checked."""

from __future__ import annotations

import inspect
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from data_schema.errors import nearest
from simulator.compiled import Function, Row, inlined, inner
from simulator.effects.effect import MODES, BodyForce, Effect, Guard, ParameterIndex, State
from simulator.effects.registry import GUARDS as EFFECT_GUARDS
from simulator.kernel.layout import OF_EFFECTS, V_BODY, V_FOOT, X_BODY, X_FOOT

Functions = dict[str, Function]


@dataclass(frozen=True, slots=True)
class EffectGuard:
    """An effect's guard: its place among the guards, and `(work, row)` for its value and for what happens there.

    The value of one of a force is `(work, lever_m, leg_speed_m_s, force_n)`.
    """

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


OF_FORCE = frozenset({"body_force_n", "body_held", "hold_guard", "body_stops", "body_moves"})
"""Functions of a force on the body; all but the first are those of one that holds."""

SLOTS = (OF_FORCE - {"body_force_n"}).union(
    ("compression_damping_kg_s", "extension_damping_kg_s", "active_damping_kg_m", "cap_n", "cap_bends"),
    ("cap_slows", "lever_m", "cost_force_n", "cost_cap_n", "mechanical_w", "resistance_n", "resistance_slope_n_m"),
    ("quadratic_drag_kg_m", "linear_drag_kg_s", "added_mass_kg", "added_mass_slope_kg_m", "travel_m"),
    ("platform_mass_kg", "control_period_s", "guard_length_m", "switch_compression_m"),
    ("switch_speed_tolerance_m_s", "rest_tolerance_m"),
)
"""The slots of the kernel, each filled by at most one effect of a scene (docs/add-an-effect.md says what they give)."""


@dataclass(frozen=True, slots=True)
class Given:
    """What an effect gives: its functions for slots and powers by name, and the rest by kind."""

    slots: Functions
    prepare: Function | None
    body_force: tuple[BodyForce, Function] | None
    guards: tuple[EffectGuard, ...]
    states: tuple[EffectState, ...]


def sorted_functions(effect: Effect, at: ParameterIndex, first_state: int) -> Given:
    """Sort what an effect gives; its states stand from `first_state` on.

    Raises `ValueError` where a function is missing that the effect's declaration asks for, or one is there for which
    nothing does, or a mode is not one.
    """
    functions = dict(effect.functions(_asking(effect, at)))
    values = _values(range(first_state, first_state + len(effect.states)))
    given = Given(
        prepare=functions.pop("prepare", None),
        body_force=_force_of(effect, functions, values),
        guards=tuple(_guard_of(effect, guard, functions, values) for guard in effect.guards),
        states=tuple(
            EffectState(
                state,
                first_state + number,
                _of_body(_taken(effect, functions, f"{state.name}_rate", 4), values),
                _taken(effect, functions, f"{state.name}_start", 3, optional=True),
            )
            for number, state in enumerate(effect.states)
        ),
        slots=functions,
    )
    powers = {f"{energy.name}_w" for energy in effect.energies if not energy.sign}
    if missing := powers - functions.keys():
        raise ValueError(_lacks(effect, functions, min(missing)))
    if unknown := functions.keys() - powers - SLOTS:
        name = min(unknown)
        near = nearest(name, _known(effect) | powers | SLOTS)
        raise ValueError(
            f"{effect.name} gives {name}, which neither its declaration nor a slot of the kernel asks for"
            f"{f': did you mean {near}?' if near else '.'}"
        )
    return given


def _known(effect: Effect) -> set[str]:
    """Names of the functions that an effect's guards and states may have."""
    of_guards = {f"{guard.name}_{what}" for guard in effect.guards for what in ("guard", "happens")}
    return of_guards | {f"{state.name}_{what}" for state in effect.states for what in ("rate", "start")}


def _asking(effect: Effect, at: ParameterIndex) -> ParameterIndex:
    """Return `at` with a refusal in words."""

    def asking(name: str) -> int:
        try:
            return at(name)
        except KeyError:
            own = (*(parameter.name for parameter in effect.parameters), *effect.derived)
            near = nearest(name, own)
            raise ValueError(
                f"{effect.name} asks for {name}, which no effect that is on declares as a parameter or derived number"
                f"{f': did you mean {near}?' if near else '.'}"
            ) from None

    return asking


def _taken(effect: Effect, functions: Functions, name: str, count: int, *, optional: bool = False) -> Any:
    """Take out a function of so many arguments that an effect's declaration asks for; None where it may be left out.

    Raises `ValueError` where it is missing, or has another number of arguments.
    """
    if name not in functions:
        if optional:
            return None
        raise ValueError(_lacks(effect, functions, name))
    function = functions.pop(name)
    found = len(inspect.signature(getattr(function, "py_func", function)).parameters)
    if found != count:
        with_states = " with its states" if effect.states else ""
        raise ValueError(f"{effect.name} gives {name} of {found} arguments, where it has {count}{with_states}.")
    return function


def _lacks(effect: Effect, functions: Functions, name: str) -> str:
    near = nearest(name, functions)
    hint = f", as {near} may be meant to be" if near else ""
    return f"{effect.name} gives no function {name}, which its declaration asks for: let it give one{hint}."


def _force_of(effect: Effect, functions: Functions, values: Function | None) -> tuple[BodyForce, Function] | None:
    """Take out the function of an effect's force on the body, with its declaration; None where it has none."""
    force, given = effect.body_force, functions.keys() & OF_FORCE
    wanted = set() if force is None else OF_FORCE if force.holds else {"body_force_n"}
    if given != wanted:
        raise ValueError(
            f"{effect.name} gives {sorted(given)}, where its body_force asks for {sorted(wanted)}: an effect that "
            "pushes the body says so by a BodyForce, with the modes in which it acts and breaks the closed form."
        )
    if force is None:
        return None
    if not set(force.breaks_closed_form) <= set(force.modes) <= set(MODES):
        raise ValueError(
            f"{effect.name} acts in {force.modes} and breaks the closed form in {force.breaks_closed_form}: let it act "
            f"wherever it does, of {MODES}."
        )
    return force, _of_body(_taken(effect, functions, "body_force_n", 3 if values is None else 4), values)


def _guard_of(effect: Effect, guard: Guard, functions: Functions, values: Function | None) -> EffectGuard:
    """Take out the functions of one of an effect's guards."""
    if guard.of_force:
        of_force = _taken(effect, functions, f"{guard.name}_guard", 4)
        return EffectGuard(guard, OF_EFFECTS + EFFECT_GUARDS.index(guard), of_force, None)
    count = 5 if values is None else 6
    value = _of_motion(_taken(effect, functions, f"{guard.name}_guard", count), values)
    happens = _taken(effect, functions, f"{guard.name}_happens", count, optional=True)
    place = OF_EFFECTS + EFFECT_GUARDS.index(guard)
    return EffectGuard(guard, place, value, None if happens is None else _of_motion(happens, values))


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
