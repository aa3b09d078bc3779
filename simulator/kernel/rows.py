"""What the kernel gives for each jump: the columns of its output row, with units and meanings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from simulator.effects.registry import BOOKED, COSTS


@dataclass(frozen=True, slots=True)
class Output:
    """A number of a jump. `kind`: f8 is a number (NaN where there is none), i4 a count (-1 there), i1 a flag."""

    name: str
    unit: str
    meaning: str
    kind: Literal["f8", "i4", "i1"] = "f8"
    flags: tuple[tuple[int, str], ...] = ()


_REACHED = "; NaN where not reached, outcome tells why"

_COSTS = {"mechanical": "mechanical part of the cost", **{energy.name: energy.meaning for energy in COSTS}}
COST_PARTS = tuple(_COSTS)
"""Parts of the cost of a jump, of which each has a column for the stance and one for the jump."""

KERNEL_OUTPUTS = (
    Output("outcome", "1", "how the jump ended", "i1"),
    Output("touchdown_time_s", "s", "time of touchdown since the start"),
    Output("liftoff_time_s", "s", f"time of the last lift-off before the apex, since touchdown{_REACHED}"),
    Output("max_depth_m", "m", "greatest depth of the foot below the undisturbed surface"),
    Output("unresisted_sink_m", "m", "how far the lifted foot sank below its print without meeting the ground"),
    Output("liftoff_body_height_m", "m", f"height of the body at lift-off above the undisturbed surface{_REACHED}"),
    Output("liftoff_body_velocity_m_s", "m/s", f"velocity of the body at lift-off{_REACHED}"),
    Output("liftoff_foot_velocity_m_s", "m/s", f"velocity of the foot at lift-off{_REACHED}"),
    Output("apex_height_m", "m", f"height of the body at the apex above the undisturbed surface{_REACHED}"),
    Output("apex_time_s", "s", f"time of the apex since touchdown{_REACHED}"),
    Output("next_touchdown_time_s", "s", f"time of the next touchdown since touchdown{_REACHED}"),
    Output("next_touchdown_body_velocity_m_s", "m/s", f"velocity of the body at the next touchdown{_REACHED}"),
    *(
        Output(f"{span}_{part}_J", "J", f"{meaning} from touchdown to {end}")
        for span, end in (("stance", "lift-off"), ("jump", "the jump's end"))
        for part, meaning in _COSTS.items()
    ),
    Output("jump_time_s", "s", "time from touchdown to the jump's end"),
    Output("leg_work_J", "J", "work of the leg's motors on body and foot"),
    *(Output(energy.column, "J", energy.meaning) for energy in BOOKED),
    Output("energy_residual_J", "J", "what the energy book cannot account for"),
    Output("energy_at_play_J", "J", "energy that the book turns over"),
    Output("decision_margin", "1", "distance of the closest decision, in local errors; infinite where none was close"),
    Output("decision_tick", "1", "tick of the closest decision; -1 where there was none", "i4"),
    Output("error_growth", "1", "factor by which sampled damping, or contact of a slow foot, lets an error grow"),
    Output("min_leg_length_m", "m", "shortest length of the leg"),
    Output("max_leg_length_m", "m", "longest length of the leg"),
    Output("min_body_height_m", "m", "lowest height of the body above the undisturbed surface"),
    Output("capped_time_s", "s", "time during which the leg's force was capped"),
    Output("steps", "1", "steps taken", "i4"),
    Output("rhs_evaluations", "1", "evaluations of the right-hand side", "i4"),
    Output("repeats", "1", "times the scene was simulated again with finer steps", "i4"),
    Output("bottomed", "1", "times the platform came to the end of its travel", "i4"),
    Output("touched_during_reset", "1", "touchdowns while the platform was reset", "i4"),
    Output("touched_before_hold", "1", "touchdowns before the ratchet held", "i4"),
    Output("release_missed", "1", "releases of the ratchet that were missed", "i4"),
    Output("guard_switch", "1", "switches to extension because the leg was short", "i4"),
    Output("cancelled_liftoff", "1", "lift-offs that the gains of flight took back", "i4"),
    Output("mode_changes", "1", "changes of the contact mode", "i4"),
)
"""In the order of the row. Absent numbers are NaN there; `simulator.jump` makes None of them."""

COLUMNS = tuple(output.name for output in KERNEL_OUTPUTS)
COLUMN = {name: place for place, name in enumerate(COLUMNS)}
COUNTERS = COLUMNS[COLUMN["bottomed"] : COLUMN["mode_changes"]]
