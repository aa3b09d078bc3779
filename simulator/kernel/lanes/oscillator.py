"""The damped oscillator of every lane in closed form, `simulator.kernel.steps.oscillator` without branches."""

from __future__ import annotations

import math
from typing import Any

from simulator.compiled import inner
from simulator.kernel.lanes.numbers import lanes_in
from simulator.kernel.working_row import choose

Lanes = Any


@inner
def oscillator(rate_1_s: Lanes, square_1_s2: Lanes, t: Lanes) -> tuple[Lanes, Lanes, Lanes]:
    """Fundamental solutions (c, s, d) of x'' + 2 rate x' + square x = 0 at t."""
    discriminant = square_1_s2 - rate_1_s * rate_1_s
    spread = discriminant * t * t
    decay = math.exp(-rate_1_s * t)
    s = decay * t * (1.0 - spread / 6.0 * (1.0 - spread / 20.0 * (1.0 - spread / 42.0 * (1.0 - spread / 72.0))))
    cosine = 1.0 - spread / 2.0 * (
        1.0 - spread / 12.0 * (1.0 - spread / 30.0 * (1.0 - spread / 56.0 * (1.0 - spread / 90.0)))
    )
    c = decay * cosine + rate_1_s * s
    rings = spread >= 0.05
    if lanes_in(rings) != 0:
        omega = math.sqrt(choose(rings, discriminant, 1.0))
        sine = decay * math.sin(omega * t) / omega
        s, c = choose(rings, sine, s), choose(rings, decay * math.cos(omega * t) + rate_1_s * sine, c)
    creeps = spread <= -0.05
    if lanes_in(creeps) != 0:
        kappa = math.sqrt(choose(creeps, -discriminant, 1.0))
        slow, fast = math.exp(-square_1_s2 / (rate_1_s + kappa) * t), math.exp(-(rate_1_s + kappa) * t)
        sine = (slow - fast) / (2.0 * kappa)
        s, c = choose(creeps, sine, s), choose(creeps, 0.5 * (slow + fast) + rate_1_s * sine, c)
    two = 2.0 * rate_1_s
    third, fourth = two * two - square_1_s2, two * (two * two - 2.0 * square_1_s2)
    begun = (square_1_s2 * t * t < 1e-6) & (rate_1_s * t < 1e-3)
    d = choose(
        begun, t * t * (0.5 - t * (two / 6.0 - t * (third / 24.0 - t * fourth / 120.0))), (1.0 - c) / square_1_s2
    )
    return c, s, d
