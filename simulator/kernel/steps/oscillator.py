"""The damped oscillator in closed form: what a linear leg does while the foot is held or in the air."""

from __future__ import annotations

import math

from simulator.compiled import inner
from simulator.kernel.working_row import choose, lanes_in


@inner
def oscillator(rate_1_s: float, square_1_s2: float, t: float) -> tuple[float, float, float]:
    """Fundamental solutions of x'' + 2 rate x' + square x = 0 at t.

    Returns (c, s, d) such that, whatever constant force acts beside, v(t) = c v(0) + s a(0) and
    x(t) = x(0) + s v(0) + d (a(0) + 2 rate v(0)): v satisfies the same equation, and x is its integral.
    Stable from undamped to far overdamped.
    """
    discriminant = square_1_s2 - rate_1_s * rate_1_s
    spread = discriminant * t * t
    s, c = 0.0 * t, 0.0 * t
    near, rings, creeps = abs(spread) < 0.05, spread >= 0.05, spread <= -0.05
    if lanes_in(near) != 0:  # near critical damping or a short time: series of sin(x)/x and cos(x)
        decay = math.exp(-rate_1_s * t)
        sine = decay * t * (1.0 - spread / 6.0 * (1.0 - spread / 20.0 * (1.0 - spread / 42.0 * (1.0 - spread / 72.0))))
        cosine = 1.0 - spread / 2.0 * (
            1.0 - spread / 12.0 * (1.0 - spread / 30.0 * (1.0 - spread / 56.0 * (1.0 - spread / 90.0)))
        )
        s, c = choose(near, sine, s), choose(near, decay * cosine + rate_1_s * sine, c)
    if lanes_in(rings) != 0:
        omega, decay = math.sqrt(choose(rings, discriminant, 1.0)), math.exp(-rate_1_s * t)
        sine = decay * math.sin(omega * t) / omega
        s, c = choose(rings, sine, s), choose(rings, decay * math.cos(omega * t) + rate_1_s * sine, c)
    if lanes_in(creeps) != 0:
        kappa = math.sqrt(choose(creeps, -discriminant, 1.0))
        slow, fast = math.exp(-square_1_s2 / (rate_1_s + kappa) * t), math.exp(-(rate_1_s + kappa) * t)
        sine = (slow - fast) / (2.0 * kappa)
        s, c = choose(creeps, sine, s), choose(creeps, 0.5 * (slow + fast) + rate_1_s * sine, c)
    # d = (1 - c) / square loses digits where the motion has hardly begun: its series there
    begun = choose(square_1_s2 * t * t < 1e-6, rate_1_s * t, 1.0) < 1e-3
    d = (1.0 - c) / choose(begun, 1.0, square_1_s2)
    if lanes_in(begun) != 0:
        two = 2.0 * rate_1_s
        third, fourth = two * two - square_1_s2, two * (two * two - 2.0 * square_1_s2)
        d = choose(begun, t * t * (0.5 - t * (two / 6.0 - t * (third / 24.0 - t * fourth / 120.0))), d)
    return c, s, d
