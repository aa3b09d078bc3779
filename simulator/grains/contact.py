"""How two grains push, rub and roll on each other: Hertz and Mindlin with damping, friction and rolling resistance.

With `R*`, `m*` the reduced radius and mass, `d` the overlap, `a = sqrt(R* d)` the contact's radius, and `E*`, `G*` the
moduli of the contact of two equal materials:

    normal      4/3 E* a d + eta v_n                 eta = alpha sqrt(4/3 E* a m*)
    tangential  8 G* a xi + x_t eta v_t              at most friction times the normal force
    rolling     k_r xi_r + g_r v_r                   at most rolling friction times the normal force

`xi` and `xi_r` are what the surfaces have slid and rolled since they met, turned with the contact; neither the spring
nor the whole exceeds the limit. (A spring that makes up for the dashpot where the whole is at its limit, as in some
programs, begins with a stretch that has no bound as steps get shorter.) `alpha = -sqrt(5) ln e / sqrt(ln^2 e + pi^2)`
gives the coefficient of restitution `e` at every speed, with the pull at the end of a collision that follows from it.

Sources: Hertz 1882; Mindlin 1949; Tsuji, Tanaka & Ishida 1992 and Antypov & Elliott 2011 (damping); Luding 2008
(rolling as a pseudo-force with spring, dashpot and slider).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simulator.compiled import Row, inlined

STIFFNESS, SHEAR, DAMPING, SHEAR_DAMPING, FRICTION, ROLLING_STIFFNESS, ROLLING_DAMPING, ROLLING_FRICTION = range(8)
"""Places in the row that `Material.law` returns."""


@dataclass(frozen=True, slots=True)
class Material:
    """What grains, floor and foot are made of, in SI units; restitution and friction are those of any two of them."""

    young_modulus_pa: float = 1e7
    poisson_ratio: float = 0.3
    restitution: float = 0.5
    friction: float = 0.5
    rolling_friction: float = 0.1

    @property
    def contact_modulus_pa(self) -> float:
        """E* of two equal bodies."""
        return self.young_modulus_pa / (2.0 * (1.0 - self.poisson_ratio**2))

    @property
    def contact_shear_modulus_pa(self) -> float:
        """G* of two equal bodies."""
        return self.young_modulus_pa / (4.0 * (1.0 + self.poisson_ratio) * (2.0 - self.poisson_ratio))

    def rayleigh_time_s(self, radius_m: float, density_kg_m3: float) -> float:
        """Return how long a surface wave takes round a grain, of which a step must be a part (Li et al. 2005)."""
        shear_modulus_pa = self.young_modulus_pa / (2.0 * (1.0 + self.poisson_ratio))
        wave = math.sqrt(density_kg_m3 / shear_modulus_pa)
        return math.pi * radius_m * wave / (0.1631 * self.poisson_ratio + 0.8766)

    def law(self, radius_m: float, mass_kg: float) -> Row:
        """Return the constants of the forces between grains of about this size, shape (8,)."""
        log = math.log(self.restitution)
        rolling_n_m = ROLLING_STIFFNESS_SHARE * self.young_modulus_pa * radius_m
        return np.array(
            [
                4.0 / 3.0 * self.contact_modulus_pa,
                8.0 * self.contact_shear_modulus_pa,
                -math.sqrt(5.0) * log / math.hypot(log, math.pi),
                math.sqrt(4.0 * self.contact_shear_modulus_pa / self.contact_modulus_pa),
                self.friction,
                rolling_n_m,
                ROLLING_DAMPING_SHARE * math.sqrt(rolling_n_m * mass_kg),
                self.rolling_friction,
            ]
        )


ROLLING_STIFFNESS_SHARE = 0.05
"""Of E r: as stiff as the shear of a contact that 1 N presses together."""
ROLLING_DAMPING_SHARE = 0.3


@inlined
def limited(
    k: float, c: float, most: float, vx: float, vy: float, vz: float, half: float, h: Row, at: int
) -> tuple[float, float, float]:
    """Return the force of a spring, a dashpot and a slider; the spring's stretch is in `h` from place `at` on.

    It is kept half a step ahead, so that its sum over steps is the trapezoidal rule.
    """
    sx, sy, sz = h[at] + vx * half, h[at + 1] + vy * half, h[at + 2] + vz * half
    size = k * math.sqrt(sx * sx + sy * sy + sz * sz)
    if size > most:
        share = most / size
        sx, sy, sz = share * sx, share * sy, share * sz
    fx, fy, fz = -k * sx - c * vx, -k * sy - c * vy, -k * sz - c * vz
    size = math.sqrt(fx * fx + fy * fy + fz * fz)
    if size > most:
        share = most / size
        fx, fy, fz = share * fx, share * fy, share * fz
    h[at], h[at + 1], h[at + 2] = sx + vx * half, sy + vy * half, sz + vz * half
    return fx, fy, fz


@inlined
def touch(
    law: Row,
    dt: float,
    reduced_radius: float,
    reduced_mass: float,
    overlap: float,
    nx: float,
    ny: float,
    nz: float,
    vx: float,
    vy: float,
    vz: float,
    wx: float,
    wy: float,
    wz: float,
    h: Row,
) -> tuple[float, float, float, float, float, float, float, float, float]:
    """Return the force on the first of two bodies, in three parts, and what it costs.

    `n` points to the first body, `v` is the velocity of its surface at the contact less that of the other's, `w` its
    spin less the other's. `h`, shape (6,), are the springs' stretches. Returned are the normal force, the tangential
    force (3), the torque of rolling (3), the power that is lost, which includes what goes into the springs of
    friction and rolling, and the normal spring's energy, in J.
    """
    a = math.sqrt(reduced_radius * overlap)
    eta = law[DAMPING] * math.sqrt(law[STIFFNESS] * a * reduced_mass)
    approach = vx * nx + vy * ny + vz * nz
    spring = law[STIFFNESS] * a * overlap
    normal = spring - eta * approach
    limit = abs(normal)
    tx, ty, tz = vx - approach * nx, vy - approach * ny, vz - approach * nz
    rx = reduced_radius * (wy * nz - wz * ny)
    ry = reduced_radius * (wz * nx - wx * nz)
    rz = reduced_radius * (wx * ny - wy * nx)
    for at in (0, 3):
        out = h[at] * nx + h[at + 1] * ny + h[at + 2] * nz
        h[at] -= out * nx
        h[at + 1] -= out * ny
        h[at + 2] -= out * nz
    half = 0.5 * dt
    fx, fy, fz = limited(law[SHEAR] * a, law[SHEAR_DAMPING] * eta, law[FRICTION] * limit, tx, ty, tz, half, h, 0)
    gx, gy, gz = limited(
        law[ROLLING_STIFFNESS], law[ROLLING_DAMPING], law[ROLLING_FRICTION] * limit, rx, ry, rz, half, h, 3
    )
    lost = eta * approach * approach - (fx * tx + fy * ty + fz * tz) - (gx * rx + gy * ry + gz * rz)
    return (
        normal,
        fx,
        fy,
        fz,
        reduced_radius * (ny * gz - nz * gy),
        reduced_radius * (nz * gx - nx * gz),
        reduced_radius * (nx * gy - ny * gx),
        lost,
        0.4 * spring * overlap,
    )
