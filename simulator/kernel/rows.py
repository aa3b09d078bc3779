"""What the kernel gives for each jump: the columns of its output row, with units and meanings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from simulator.effects.registry import BOOKED, COSTS


@dataclass(frozen=True, slots=True)
class Output:
    """A number of a jump. `kind`: f8 is a number (NaN where there is none), i4 a count (-1 there), i1 a flag.

    `meaning` is short enough for the axis of a figure; `comment` says what else is to be known of it.
    """

    name: str
    unit: str
    meaning: str
    kind: Literal["f8", "i4", "i1"] = "f8"
    comment: str = ""
    flags: tuple[tuple[int, str], ...] = ()


_ABOVE = "above the undisturbed surface"
_REACHED = "NaN where not reached, outcome tells why"

_COSTS = {"mechanical": "mechanical part of the cost", **{energy.name: energy.meaning for energy in COSTS}}
COST_PARTS = tuple(_COSTS)
"""Parts of the cost of a jump, of which each has a column for the stance and one for the jump."""


def _perhaps(name: str, unit: str, meaning: str, comment: str = "") -> Output:
    """Return an output that a jump may not come to."""
    return Output(name, unit, meaning, comment=f"{comment}; {_REACHED}" if comment else _REACHED)


def _count(name: str, meaning: str, comment: str = "") -> Output:
    return Output(name, "1", meaning, "i4", comment)


KERNEL_OUTPUTS = (
    Output("outcome", "1", "how the jump ended", "i1"),
    Output("touchdown_time_s", "s", "time of touchdown since the start"),
    _perhaps("liftoff_time_s", "s", "time of lift-off since touchdown", "of the last lift-off before the apex"),
    Output("max_depth_m", "m", "greatest depth of the foot", comment="below the undisturbed surface"),
    Output(
        *("unresisted_sink_m", "m", "unresisted sink of the lifted foot"),
        comment="how far it sank below its print without meeting the ground",
    ),
    _perhaps("liftoff_body_height_m", "m", "height of the body at lift-off", _ABOVE),
    _perhaps("liftoff_body_velocity_m_s", "m/s", "velocity of the body at lift-off"),
    _perhaps("liftoff_foot_velocity_m_s", "m/s", "velocity of the foot at lift-off"),
    _perhaps("apex_height_m", "m", "height of the body at the apex", _ABOVE),
    _perhaps("apex_foot_height_m", "m", "height of the foot at the apex", _ABOVE),
    _perhaps("apex_time_s", "s", "time of the apex since touchdown"),
    _perhaps("next_touchdown_time_s", "s", "time of the next touchdown since touchdown"),
    _perhaps("next_touchdown_body_velocity_m_s", "m/s", "velocity of the body at the next touchdown"),
    *(
        Output(f"{span}_{part}_J", "J", f"{meaning}, {span}", comment=f"from touchdown to {end}")
        for span, end in (("stance", "lift-off"), ("jump", "the jump's end"))
        for part, meaning in _COSTS.items()
    ),
    Output("jump_time_s", "s", "time from touchdown to the jump's end"),
    Output("leg_work_J", "J", "work of the leg's motors on body and foot"),
    *(Output(energy.column, "J", energy.meaning) for energy in BOOKED),
    Output("energy_residual_J", "J", "what the energy book cannot account for"),
    Output("energy_at_play_J", "J", "energy that the book turns over"),
    Output(
        *("decision_margin", "1", "distance of the closest decision"),
        comment="in local errors; infinite where none was within 10",
    ),
    _count("decision_tick", "tick of the closest decision", "-1 where there was none"),
    Output("error_growth", "1", "growth of errors", comment="by sampled damping, or by contact of a slow foot"),
    Output("min_leg_length_m", "m", "shortest length of the leg"),
    Output("max_leg_length_m", "m", "longest length of the leg"),
    Output("min_body_height_m", "m", "lowest height of the body", comment=_ABOVE),
    Output("capped_time_s", "s", "time during which the leg's force was capped"),
    _count("steps", "steps taken"),
    _count("rhs_evaluations", "evaluations of the right-hand side"),
    _count("repeats", "times simulated again with finer steps"),
    _count("bottomed", "times the platform came to its end"),
    _count("touched_during_reset", "touchdowns while the platform was reset"),
    _count("touched_before_hold", "touchdowns before the ratchet held"),
    _count("release_missed", "releases of the ratchet that were missed"),
    _count("guard_switch", "switches to extension by a short leg"),
    _count("cancelled_liftoff", "lift-offs that the gains of flight took back"),
    _count("mode_changes", "changes of the contact mode"),
)
"""In the order of the row. Absent numbers are NaN there; `simulator.jump` makes None of them."""

COLUMNS = tuple(output.name for output in KERNEL_OUTPUTS)
COLUMN = {name: place for place, name in enumerate(COLUMNS)}
COUNTERS = COLUMNS[COLUMN["bottomed"] : COLUMN["mode_changes"]]
