"""The columns of a jump's output row."""

from __future__ import annotations

from simulator.effects.registry import BOOKED, COSTS

COST_PARTS = ("mechanical", *(energy.name for energy in COSTS))
"""Parts of the cost of a jump, of which each has a column for the stance and one for the jump."""

COLUMNS = (
    "outcome",
    "touchdown_time_s",
    "liftoff_time_s",
    "max_depth_m",
    "unresisted_sink_m",
    "liftoff_body_height_m",
    "liftoff_body_velocity_m_s",
    "liftoff_foot_velocity_m_s",
    "apex_height_m",
    "apex_time_s",
    "next_touchdown_time_s",
    "next_touchdown_body_velocity_m_s",
    *(f"{span}_{part}_J" for span in ("stance", "jump") for part in COST_PARTS),
    "jump_time_s",
    "leg_work_J",
    *(energy.column for energy in BOOKED),
    "energy_residual_J",
    "decision_margin",
    "decision_tick",
    "error_growth",
    "min_leg_length_m",
    "max_leg_length_m",
    "min_body_height_m",
    "capped_time_s",
    "energy_at_play_J",
    "steps",
    "rhs_evaluations",
    "repeats",
    "bottomed",
    "touched_during_reset",
    "touched_before_hold",
    "release_missed",
    "guard_switch",
    "cancelled_liftoff",
    "mode_changes",
)
"""Absent numbers are NaN inside the kernel's rows; `simulator.jump` makes None of them."""

COLUMN = {name: place for place, name in enumerate(COLUMNS)}
COUNTERS = COLUMNS[COLUMNS.index("bottomed") : COLUMNS.index("mode_changes")]
