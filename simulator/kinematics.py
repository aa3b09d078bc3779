"""Kinematics of the symmetric five-bar leg (thesis 3.2.1).

    u = (l1^2 - l2^2 + r^2) / (2 l1 r),   beta = pi - acos(u),
    J(r) = d beta / d r = (r^2 - l1^2 + l2^2) / (2 l1 r^2 sqrt(1 - u^2))

The leg is folded at r = l2 - l1 and straight at r = l1 + l2; J is singular at both.
"""

from __future__ import annotations

import math

from simulator.compiled import compiled

SMALLEST_SINE = 1e-4
"""Smallest sqrt(1 - u^2) used: reached by trial steps past the singular lengths, never by an accepted stance."""


@compiled
def lever_m(upper_link_m: float, lower_link_m: float, leg_length_m: float) -> float:
    """Lever arm 1 / J(r) of the joint, m: joint torque = force times lever, leg speed = joint speed times lever."""
    square = leg_length_m * leg_length_m
    difference = upper_link_m * upper_link_m - lower_link_m * lower_link_m
    whole = 4.0 * upper_link_m * upper_link_m * square
    cosine_part = difference + square
    sine_part = max(whole - cosine_part * cosine_part, SMALLEST_SINE * SMALLEST_SINE * whole)
    return leg_length_m * math.sqrt(sine_part) / (square - difference)
