"""An effect that is off costs nothing: the machine's view of the equations of motion is that of code without it."""

from __future__ import annotations

import re
from collections import Counter
from typing import Any

import numba
import numpy as np
import pytest
from numpy.typing import NDArray

from simulator.compiled import inner
from simulator.effects.cone import cone_volume_m3, flat_area_m2, formed_depth_m
from simulator.effects.effect import Function
from simulator.effects.registry import EFFECTS
from simulator.kernel.composition import Composition, compose
from simulator.kernel.layout import (
    CREEPING,
    FLIGHT,
    INTRUDING,
    LEG_WORK,
    MECHANICAL,
    STIFFNESS,
    V_BODY,
    V_FOOT,
    X_BODY,
    X_FOOT,
)
from simulator.kernel.mechanics.motion import make_rates
from simulator.parameter import GRAVITY_M_S2

Row = NDArray[np.float64]
LEAST = ("hydrostatic_stiffness",)
ADDRESS = numba.types.CPointer(numba.float64)
"""The kernel's row as its functions get it; an array would bring the counting of references with it."""
SIGNATURE = (numba.float64, numba.float64, ADDRESS, numba.int64, numba.int64)
OPCODE = re.compile(r"^  (?:%\S+ = |\"[^\"]*\" = )?(?:tail |musttail |notail )?([a-z]+)\b", re.MULTILINE)
DEFINITION = re.compile(r"^define [^\n]*\{\n(.*?)^\}", re.MULTILINE | re.DOTALL)

IN_RATES = (
    "added_mass",
    "inertial_drag",
    "leg_damping",
    "active_damping",
    "constant_force_cap",
    "torque_cap",
    "motor_heat",
    "drag",
    *(effect.name for effect in EFFECTS.values() if effect.body_force),
)
NOT_IN_RATES = ("sampled_control", "latched_switching", "short_leg_guard", "held_gains_in_flight", "cost_of_whole_jump")


def opcodes(function: Function) -> Counter[str]:
    """How often each instruction occurs in the optimised code of a function and of what it calls."""
    compiled: Any = inner(function)
    compiled.compile(SIGNATURE)
    (result,) = compiled.overloads.values()
    assert result.library.get_pointer_to_function(result.fndesc.mangled_name)  # an inner function is optimised then
    return Counter(OPCODE.findall("".join(DEFINITION.findall(result.library.get_llvm_str()))))


def composed_rates(*effects: str) -> Function:
    rates: Any = make_rates(compose((*LEAST, *effects)))
    function: Function = rates.py_func
    return function


def rates_by_hand(composition: Composition) -> Function:
    """A spring between two masses on grains, without anything else: no effect is known here."""
    at = composition.position
    rest, per_body, per_foot = at["rest_length"], at["inverse_body_mass"], at["inverse_foot_mass"]
    radius, q_at, area_at, complete_at = at["foot_radius"], at["recruitment_slope"], at["foot_area"], at["cone_depth"]
    penetration_at, stress_at, foot = at["penetration_factor"], at["stress_factor"], at["foot_mass"]
    loss = MECHANICAL + 1

    def rates(mode: float, t: float, work: Row, row: int, stage: int) -> None:
        x_b, v_b, x_f, v_f = work[row + X_BODY], work[row + V_BODY], work[row + X_FOOT], work[row + V_FOOT]
        length_m = x_b - x_f
        force_n = work[STIFFNESS] * (length_m - work[rest])
        a_b = -force_n * work[per_body] - GRAVITY_M_S2
        sinking, a_f, loss_w = -v_f, 0.0, 0.0
        if mode == FLIGHT:
            a_f = force_n * work[per_foot] - GRAVITY_M_S2
        elif mode == INTRUDING:
            depth_m = -x_f
            volume = cone_volume_m3(work[radius], work[q_at], formed_depth_m(work[complete_at], depth_m))
            push_n = work[penetration_at] * volume + work[stress_at] * depth_m * (work[area_at] + volume)
            a_f, loss_w = (force_n + push_n) / work[foot] - GRAVITY_M_S2, push_n * -v_f
        elif mode == CREEPING:
            depth_m = -x_f
            formed_m = formed_depth_m(work[complete_at], depth_m)
            volume = cone_volume_m3(work[radius], work[q_at], formed_m)
            flat = flat_area_m2(work[radius], work[q_at], formed_m)
            give = work[penetration_at] * flat + work[stress_at] * (work[area_at] + volume + depth_m * flat)
            before_n = work[STIFFNESS] * (length_m - work[rest])
            after_n = work[STIFFNESS] * (length_m + v_b * 1e-6 - work[rest])
            sinking = -((after_n - before_n) / 1e-6) / give
            volume = cone_volume_m3(work[radius], work[q_at], formed_depth_m(work[complete_at], depth_m))
            push_n = work[penetration_at] * volume + work[stress_at] * depth_m * (work[area_at] + volume)
            loss_w = push_n * sinking
        else:
            sinking = 0.0
        work[stage + X_BODY], work[stage + V_BODY] = v_b, a_b
        work[stage + X_FOOT], work[stage + V_FOOT] = -sinking, a_f
        work[stage + loss] = loss_w
        work[stage + LEG_WORK] = -force_n * (v_b + sinking)
        work[stage + MECHANICAL] = -force_n * (v_b + sinking)

    return rates


@pytest.fixture(scope="module")
def least() -> Counter[str]:
    return opcodes(composed_rates())


def test_with_all_off_the_optimised_code_is_that_of_a_spring_on_grains_written_by_hand(least: Counter[str]) -> None:
    by_hand = opcodes(rates_by_hand(compose(LEAST)))
    assert by_hand["fmul"] > 20
    assert least == by_hand


@pytest.mark.parametrize(
    "name", [name if name == "added_mass" else pytest.param(name, marks=pytest.mark.soak) for name in IN_RATES]
)
def test_an_effect_that_is_on_adds_instructions_and_its_states(name: str, least: Counter[str]) -> None:
    """So that the comparison above has something to find."""
    composition = compose((*LEAST, name))
    own = {energy for energy in EFFECTS[name].all_energies if not energy.sudden} - set(EFFECTS[LEAST[0]].energies)
    assert composition.state_size == compose(LEAST).state_size + len(own) + len(EFFECTS[name].states)
    assert composition.row_size > compose(LEAST).row_size
    with_it = opcodes(composed_rates(name))
    assert with_it.total() > least.total()


def test_effects_of_control_and_cost_leave_the_equations_of_motion_alone(least: Counter[str]) -> None:
    assert opcodes(composed_rates(*NOT_IN_RATES)) == least
