"""The columns of a jump's output row."""

from __future__ import annotations

from simulator.effects.registry import BOOKED

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
    "stance_heat_J",
    "stance_mechanical_J",
    "stance_drag_J",
    "jump_heat_J",
    "jump_mechanical_J",
    "jump_drag_J",
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
