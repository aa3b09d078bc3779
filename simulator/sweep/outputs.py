"""What a sweep gives for each jump: names, units, meanings and how they are stored."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from simulator.effects.registry import BOOKED, COSTS
from simulator.error_bars import NOT_OUTPUTS
from simulator.kernel.layout import OUTCOMES
from simulator.kernel.rows import COLUMN

NOT_MADE = "not_made"
"""Outcome of the jumps of a scene after its last: the robot did not come down again."""
REFUSED = "refused"
"""Outcome of all jumps of a scene that cannot be simulated, since its values do not fit together."""
REFUSED_FLAG, NOT_MADE_FLAG = -2, -1


@dataclass(frozen=True, slots=True)
class Output:
    """A variable of the result. `kind`: f8 is a number (NaN where there is none), i4 a count (-1 there), i1 a flag."""

    name: str
    unit: str
    meaning: str
    kind: Literal["f8", "i4", "i1"] = "f8"
    flags: tuple[tuple[int, str], ...] = ()


OUTCOME_FLAGS = ((REFUSED_FLAG, REFUSED), (NOT_MADE_FLAG, NOT_MADE), *enumerate(OUTCOMES))
_YES_OR_NO = ((NOT_MADE_FLAG, NOT_MADE), (0, "no"), (1, "yes"))
_REACHED = "; NaN where not reached, outcome tells why"

_COSTS = {"mechanical": "mechanical part of the cost", **{energy.name: energy.meaning for energy in COSTS}}

OUTPUTS = (
    Output("outcome", "1", "how the jump ended", "i1", OUTCOME_FLAGS),
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
    Output("passive_J", "J", "passive draw of the electronics from touchdown to the jump's end"),
    Output("cost_J", "J", "cost of the jump: heat, mechanical, drag and passive draw"),
    Output("ill_conditioned", "1", "whether the jump hangs on a decision or on rounding", "i1", _YES_OR_NO),
    Output("under_surface", "1", "whether the body gets under the surface of the grains", "i1", _YES_OR_NO),
    Output("open_book", "1", "whether the energy book does not close within the accuracy", "i1", _YES_OR_NO),
)
"""In the order of a chunk's columns: those of the kernel first, then what is computed from them."""

ERRORS = tuple(
    Output(f"{output.name}_error", output.unit, f"estimated error of {output.name}; NaN where none was estimated")
    for output in OUTPUTS
    if output.kind == "f8" and output.name not in NOT_OUTPUTS
)
"""What a sweep with error bars gives beside them: columns after those of the outputs."""

FLAGS = ("ill_conditioned", "under_surface", "open_book")
"""What may be remarked of a jump: a sweep counts the jumps."""
PLACE = {output.name: place for place, output in enumerate(OUTPUTS)}
FROM_KERNEL = tuple(output.name for output in OUTPUTS if output.name in COLUMN)
