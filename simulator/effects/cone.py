"""The cone of grains that forms under a flat intruder (thesis 3.1.2; Aguilar & Goldman 2016).

With q = mu / tan(cone_angle), the cone is complete at the depth R / q; s is the depth, at most that.
Arguments: foot radius R in m, q dimensionless, s in m. Effects import this where their functions are made: what
imports a compiled function loads numba.
"""

from __future__ import annotations

import math

from simulator.compiled import inner


@inner
def formed_depth_m(cone_depth_m: float, depth_m: float) -> float:
    """Depth over which the cone has formed, m; `cone_depth_m` is that of the complete cone, R / q."""
    return min(max(depth_m, 0.0), cone_depth_m)


@inner
def flat_area_m2(radius_m: float, q: float, formed_m: float) -> float:
    """Area A(s) of the foot that the cone does not cover yet, m^2."""
    remaining = radius_m - q * formed_m
    return math.pi * remaining * remaining


@inner
def cone_volume_m3(radius_m: float, q: float, formed_m: float) -> float:
    """Volume V(s) of the cone, the integral of A, m^3."""
    covered_m = q * formed_m
    return math.pi * formed_m * (radius_m * (radius_m - covered_m) + covered_m * covered_m * (1.0 / 3.0))
