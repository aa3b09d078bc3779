"""The damped oscillator in closed form: what a linear leg does while the foot is held or in the air."""

from __future__ import annotations

import math

from simulator.compiled import inner


@inner
def oscillator(rate_1_s: float, square_1_s2: float, t: float) -> tuple[float, float, float]:
    """Fundamental solutions of x'' + 2 rate x' + square x = 0 at t.

    Returns (c, s, d) such that, whatever constant force acts beside, v(t) = c v(0) + s a(0) and
    x(t) = x(0) + s v(0) + d (a(0) + 2 rate v(0)): v satisfies the same equation, and x is its integral.
    Stable from undamped to far overdamped.
    """
    discriminant = square_1_s2 - rate_1_s * rate_1_s
    spread = discriminant * t * t
    if abs(spread) < 0.05:  # near critical damping or a short time: series of sin(x)/x and cos(x)
        decay = math.exp(-rate_1_s * t)
        s = decay * t * (1.0 - spread / 6.0 * (1.0 - spread / 20.0 * (1.0 - spread / 42.0 * (1.0 - spread / 72.0))))
        cosine = 1.0 - spread / 2.0 * (
            1.0 - spread / 12.0 * (1.0 - spread / 30.0 * (1.0 - spread / 56.0 * (1.0 - spread / 90.0)))
        )
        c = decay * cosine + rate_1_s * s
    elif discriminant > 0.0:
        omega = math.sqrt(discriminant)
        decay = math.exp(-rate_1_s * t)
        s = decay * math.sin(omega * t) / omega
        c = decay * math.cos(omega * t) + rate_1_s * s
    else:
        kappa = math.sqrt(-discriminant)
        slow = math.exp(-square_1_s2 / (rate_1_s + kappa) * t)
        fast = math.exp(-(rate_1_s + kappa) * t)
        s = (slow - fast) / (2.0 * kappa)
        c = 0.5 * (slow + fast) + rate_1_s * s
    # d = (1 - c) / square loses digits where the motion has hardly begun: its series there
    if square_1_s2 * t * t < 1e-6 and rate_1_s * t < 1e-3:
        two = 2.0 * rate_1_s
        third, fourth = two * two - square_1_s2, two * (two * two - 2.0 * square_1_s2)
        d = t * t * (0.5 - t * (two / 6.0 - t * (third / 24.0 - t * fourth / 120.0)))
    else:
        d = (1.0 - c) / square_1_s2
    return c, s, d
