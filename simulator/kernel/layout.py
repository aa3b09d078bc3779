"""Where numbers stand in the one row that a kernel works in: held values, flags, guards, states, rates, parameters.

One row, because a compiled function gets an array as seven words: five arrays for each call took longer than the
physics.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from simulator.effects.effect import MODES as MODES
from simulator.effects.registry import ENERGIES, STATES
from simulator.effects.registry import GUARDS as EFFECT_GUARDS


def places(first: int, end: int, step: int) -> Any:
    """Places that functions take as arguments: of Python's integers numba would compile a function for each value."""
    return np.arange(first, end, step)


X_BODY, V_BODY, X_FOOT, V_FOOT = range(4)
LEG_WORK, MECHANICAL = 4, 5
"""The state: heights (m) and speeds (m/s), then integrals over time (J); further integrals follow as effects call for
them (`Composition.integrals`), states of effects, and a platform's height and speed."""
WIDTH = MECHANICAL + 1 + len(ENERGIES) + 2 + len(STATES)
"""Room for a state or its rates, whatever effects are on."""

JAMMED, INTRUDING, FLIGHT, CREEPING, CARRIED = range(5)

COMPRESSION, EXTENSION = 0, 1
SINKING, IN_PRINT, ABOVE_PRINT, CLEAR = -2, -1, 0, 1
"""Where a flying foot is: pressed down by the gains of flight, or below its print and rising, both without contact;
risen above its print, where it may meet it again; or clear of the surface."""
HOLD, RELEASE, RESET, ENGAGE = range(4)
"""States of the ground emulator (thesis 4.2.3)."""

(
    STIFFNESS,
    DAMPING,
    ACTIVE_DAMPING,
    SAMPLED_SPEED,
    HELD_FORCE,
    DEEPEST,
    EMULATOR_SINCE,
    RESET_FROM,
    HOLD_SINCE,
    IMPACT,
    START_ENERGY,
    SHORTEST,
    LONGEST,
    LOWEST,
    DEPTH,
    CAPPED,
    MARGIN,
    MARGIN_TICK,
    GROWTH,
    WORST_GROWTH,
    TIME,
    OFFSET,
    STEP,
    STRIDE,
    TOLERANCE,
    LENGTH_UNIT,
    SPEED_UNIT,
    ALLOWED,
    DECIDED,
    UNRESISTED,
    SPARE,
) = range(31)
"""Numbers that stay between events: gains, the lowest point of the foot, timers,
sudden losses (J), extremes, the smallest decision margin, the clock since touchdown (s), the step to try next, what
error is allowed, one more than the tick at which a step was cut because of a decision, how far a lifted foot has sunk
below its print, and how far a decision is at least, in local errors beyond those that are noted."""

(
    MODE,
    PHASE,
    TICK,
    CLEARED,
    EMULATOR,
    AIRBORNE,
    SATURATED,
    RELEASED,
    FRESH,
    STALE,
    STEPS,
    EVALUATIONS,
    EVENTS,
    TRACED,
    BOTTOMED,
    TOUCHED_DURING_RESET,
    TOUCHED_BEFORE_HOLD,
    RELEASE_MISSED,
    GUARD_SWITCHES,
    SLIDES,
    BEYOND,
    COST_CAPPED,
    ASLEEP,
    CANCELLED,
    STEPS_ALLOWED,
    SWITCHED,
    HOLDS,
) = range(31, 58)
"""Whole numbers that stay between events: modes, phases, what the next step must know, counts, whether the platform
moves on without the foot, whether a flying leg is longer than its links, the sign of the force at the cap of the cost,
whether the controller sleeps until the foot has risen and met the ground again, lift-offs that were cancelled, the
number of the step before which it is looked ahead how many there will be, how often a controller without a clock has
changed its phase, and (from `HOLDS` on) which conditions of its rule hold."""

CONDITIONS = 4
"""How many conditions such a rule has at most."""
ARMED = HOLDS + CONDITIONS
"""Place of the first number that says whether the event of an effect has not happened since its guard was negative."""
PERSISTENT = ARMED + len(EFFECT_GUARDS) + (ARMED + len(EFFECT_GUARDS)) % 2
"""Number of values that stay between events, even, as registers hold several."""

(
    STOPS,
    YIELDS,
    LIFTS,
    TOUCHES,
    CLEARS,
    CAP_KINK,
    FOLDS,
    STRAIGHTENS,
    RELEASES,
    BOTTOMS,
    SETTLES,
    HOLD_TURNS,
    COST_KINK,
    FALLS,
) = range(14)
PROMPT, OF_EFFECTS = 13, 14
SWITCHES = OF_EFFECTS + len(EFFECT_GUARDS) + len(EFFECT_GUARDS) % 2
GUARDS = SWITCHES + CONDITIONS
"""Functions of the state whose rise through zero is an event (`simulator.kernel.events.guards`), each smooth between
events. From `OF_EFFECTS` on stand those that effects declare, in the order of `EFFECT_GUARDS` and, as registers hold
several, an even number of places; from `SWITCHES` on each condition of the rule of a controller without a clock has
one; a kernel with a clock has none of these (`Composition.guards`). They and the first `PROMPT` are never positive
while their mode lasts: one that is at the start of a step, because two events fell together, happens there.
"""

GUARDS_EARLIER, GUARDS_BEFORE, GUARDS_AFTER, GUARDS_BETWEEN = places(PERSISTENT, PERSISTENT + 4 * GUARDS, GUARDS)
"""Places of the guards' values at the start of the part of a step before, of a part, at its end, and at an instant
between."""

QUINTICS = PERSISTENT + 4 * GUARDS
"""Place of the dense output's coefficients: six for the body, six for the foot, six for a platform that slides."""

_STATES = QUINTICS + 18
NOW, TRIAL, QUARTER, HALF, THREE_QUARTERS, BETWEEN = places(_STATES, _STATES + 6 * WIDTH, WIDTH)
"""Places of states: at the start of a step, at its end, three inside it, and one interpolated."""

_RATES = _STATES + 6 * WIDTH
K1, K2, K3, K4, K5, K6, K7 = places(_RATES, _RATES + 7 * WIDTH, WIDTH)
"""Places of rates: those of the stages of a step; the first is its start, the last its end."""

ERROR = _RATES + 7 * WIDTH
"""Place of the estimated error of a step."""

NEAR = ERROR + WIDTH
"""Place of the distances from zero within which a peak of each guard is noted, as the error of the state may decide
whether its event happens; 0 where it may not change the jump at once."""

PARAMETERS = NEAR + GUARDS
"""Place of the first parameter; before it, everything has the same place in every kernel."""

OUTCOMES = (
    "liftoff",
    "apex",
    "touchdown",
    "no_liftoff",
    "leg_folded",
    "leg_straight",
    "timeout",
    "step_limit",
    "no_trigger",
    "carried",
)
(
    LIFTOFF_REACHED,
    APEX,
    TOUCHDOWN,
    NO_LIFTOFF,
    LEG_FOLDED,
    LEG_STRAIGHT,
    TIMEOUT,
    STEP_LIMIT,
    NO_TRIGGER,
    CARRIED_ROUND,
) = range(10)
