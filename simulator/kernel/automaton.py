"""The hybrid automaton as a table: by event, its guard, what happens there, and where it leads from each contact mode.

The kernel's functions of `simulator.kernel.events` do this, compiled; a test sees that they go nowhere else.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from simulator.effects.effect import MODES, Mode
from simulator.effects.registry import GUARDS
from simulator.kernel.limits import LONGEST_FLIGHT_S, LONGEST_STANCE_S

Leads = Mapping[Mode, tuple[Mode, ...]]
SETTLED: tuple[Mode, ...] = ("jammed", "flight", "intruding", "creeping")
"""What a foot at rest does next: it is held, or lifted (F > m_f g), or the ground yields ((m_f + m_a) g > F + K) and it
sinks, on very stiff ground without inertia."""
ENDS: tuple[Mode, ...] = ()
"""Modes after an event that ends the jump."""


@dataclass(frozen=True, slots=True)
class Event:
    """An event, in the modes that `leads` names: by each, the modes that may follow.

    `guard` is what rises through zero there; `happens` what the event does beside changing the mode. It may end the
    jump by the outcomes of `ends`.
    """

    name: str
    guard: str
    happens: str
    leads: Leads
    ends: tuple[str, ...] = ()


def _stays(*modes: Mode) -> dict[Mode, tuple[Mode, ...]]:
    return {mode: (mode,) for mode in modes or MODES}


def _from(modes: tuple[Mode, ...], leads: tuple[Mode, ...]) -> dict[Mode, tuple[Mode, ...]]:
    return dict.fromkeys(modes, leads)


EVENTS = (
    Event(
        "stops",
        "v_f",
        "the foot rests, and leaves the grains that moved with it; in flight, a platform that slid on alone rests",
        {"intruding": SETTLED, "flight": ("flight",)},
    ),
    Event("yields", "(m_f + m_a) g - F - K", "the ground gives way", {"jammed": SETTLED}),
    Event(
        "lifts",
        "F - m_f g, on a moving platform less m_f times its acceleration",
        "lift-off: the gains become those of flight, which may cancel it",
        {"jammed": SETTLED, "intruding": ("flight",), "carried": ("flight",)},
    ),
    Event(
        "touches",
        "height of the ground, the print or the platform less x_f",
        "the foot takes the speed of ground that does not yield; the jump ends where the body falls",
        {"flight": ("intruding", "jammed", "carried", "flight")},
        ("touchdown",),
    ),
    Event(
        "clears",
        "v_f; x_f less the print; x_f",
        "a foot in its print rises; has risen above it, and may touch again; is clear of the surface",
        _stays("flight"),
    ),
    Event(
        "cap_kink",
        "size of F less its cap, or back",
        "the force is clipped, or no longer",
        _stays() | _from(("creeping",), ("creeping", "intruding")),
    ),
    Event("folds", "l2 - l1 - r", "the leg is folded", _from(MODES, ENDS), ("leg_folded",)),
    Event(
        "straightens",
        "r - l1 - l2",
        "the leg is straight; in flight on grains, a corner of the motors' lever",
        _from(MODES, ENDS) | _stays("flight"),
        ("leg_straight",),
    ),
    Event(
        "releases",
        "r - l + release_tolerance",
        "the ratchet lets the platform go, and the foot on it stops",
        _stays("jammed", "flight") | _from(("intruding", "creeping"), SETTLED),
    ),
    Event(
        "bottoms",
        "z - platform_travel",
        "the platform is at its end, and the foot on it stops",
        _stays("flight") | _from(("intruding", "creeping"), SETTLED),
    ),
    Event("settles", "rate of F; F + K - (m_f + m_a) g", "the foot rests", {"creeping": ("jammed",)}),
    Event(
        "hold_turns",
        "v_b; size of the force on a held body less its hold",
        "the body stops, and is held or goes on",
        _stays(),
    ),
    Event("cost_kink", "size of F less the cap of the cost, or back", "the cost counts its cap, or F", _stays()),
    Event(
        "falls",
        "- v_b",
        "the apex; on ground that does not yield, an extending leg no longer lifts the foot",
        _from(MODES, ENDS) | _stays("flight"),
        ("apex", "touchdown", "no_liftoff"),
    ),
    *(Event(guard.name, guard.expression, guard.happens, _stays(*guard.modes)) for guard in GUARDS),
)
"""In the order of their guards' places (`simulator.kernel.layout`)."""

OTHERS = (
    Event(
        "switches",
        "each condition of a controller without a clock",
        "phase and gains of the leg change; the jump ends where both phases hold the body",
        _stays("flight", "intruding", "carried") | _from(("jammed", "creeping"), SETTLED),
        ("no_liftoff",),
    ),
    Event(
        "tick",
        "t less the next tick of the clock",
        "the controller looks: phase, gains, sampled speed or held force",
        _stays("flight", "intruding", "carried") | _from(("jammed", "creeping"), SETTLED),
    ),
    Event(
        "timer",
        "t less the end of the emulator's state",
        "the platform is held, released, reset, engaged, in turn",
        _stays("flight", "intruding", "creeping") | {"jammed": (*SETTLED, "carried"), "carried": SETTLED},
    ),
    Event(
        "inertia",
        "looked at after a step",
        "inertia of the foot no longer counts, or counts again",
        {"intruding": ("creeping",), "creeping": ("intruding",)},
    ),
    Event(
        "lasts",
        f"t - {LONGEST_STANCE_S:g} s; in flight t - {LONGEST_FLIGHT_S:g} s; steps",
        "the jump is given up",
        _from(MODES, ENDS),
        ("no_liftoff", "no_trigger", "carried", "timeout", "step_limit", "too_stiff"),
    ),
)
"""Those of the controller, the clocks and the method."""
