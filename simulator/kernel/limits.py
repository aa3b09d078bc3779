"""What a run of the kernel is asked for, as a row of numbers."""

from __future__ import annotations

TOLERANCE, STOP_AFTER, JUMPS_WANTED, MOST_STEPS, FLIP_TICK, FIXED_STEP_S, REPEATS = range(7)
LIMITS = 7
"""`TOLERANCE`: local error allowed, relative. `STOP_AFTER`: see below. `FLIP_TICK`: the tick whose decision is
turned round,
-1 none. `FIXED_STEP_S`: a step length in place of error control, 0 none: for measuring orders.
`REPEATS`: how often a scene may be simulated again with finer steps."""

TOLERANCE_SHARE = 0.5
"""Local error allowed, relative to the goal for the outputs: measured over random scenes (docs/accuracy.md)."""
STOP_AFTER_LIFTOFF, STOP_AFTER_APEX, STOP_AFTER_TOUCHDOWN = range(3)
LONGEST_STANCE_S = 2.0
LONGEST_FLIGHT_S = 20.0
FINEST_TOLERANCE = 1e-14
"""Below it rounding decides, not the step."""
DECISION_SHARE = 0.1
"""Error of the state that a decision at a tick is measured in, as a part of the local error allowed: the errors of the
outputs are of this size (docs/accuracy.md)."""
NEAR_PEAK = 10.0
"""Largest distance of a decision, or of a guard's peak from zero, that is noted as a margin, in units of the same
error."""
EVENT_SHARE = 0.01
"""Part of the local error allowed to the landing on an event."""
SLOW_M_S = 0.1
"""Speed of a foot at contact below which its instant hangs on the last digits of heights."""
MOST_SWITCHES = 4
"""Changes of its phase in a jump beyond which a controller without a clock chatters: each adds its own error, and their
number has no limit as steps become finer."""
SLOW_SWITCH = 3e-3
"""Rate, as a share of gravity or of the speed of a fall through the rest length, at which a condition of such a
controller turns, below which the instant hangs on the last digits of the state."""
