"""Grains in a box over time: cell lists, forces of grains, floor and foot, and steps by velocity Verlet.

The box is periodic in x and y, so that no side wall holds the grains, and has a floor at z = 0. A foot is a vertical
cylinder with a flat end, which moves as it is told: the grains push it, and it does not give way.

Forces depend on velocities: those at a step's end are predicted from the accelerations at its start, which keeps the
second order of velocity Verlet (Groot & Warren 1997) but for the step in which a contact begins. Pairs within a skin of
each other are listed by cells, and listed anew when a grain has moved half the skin (Allen & Tildesley 2017, ch. 5); a
pair keeps its springs.
"""

from __future__ import annotations

import functools
import math
from concurrent.futures import CancelledError
from dataclasses import dataclass, fields

import numba
import numpy as np
from numpy.typing import NDArray

from simulator.compiled import Function, Row, inlined, inner
from simulator.grains.contact import Material, touch
from simulator.kernel.cache import cached_entry

SKIN_SHARE = 0.12
"""Of the largest diameter: pairs nearer than that are listed."""
KINETIC, HEIGHT, ELASTIC, FORCE, WORK, LOST, FLOOR = range(7)
"""Columns of the record: energies of motion, height and normal springs (J), mean force on the foot (N, up), work of the
foot on the grains and what was lost to friction and damping since the start (J), mean force on the floor (N, down)."""


Whole = NDArray[np.int64]
Truths = NDArray[np.bool_]
Pairs = tuple[Whole, Whole, Truths, Row]


@dataclass(frozen=True, slots=True, eq=False)
class Grains:
    """Grains at one time, SI units: centres `x`, velocities `v`, spins `w`, and both accelerations, shape (n, 3).

    Those that may touch are pairs: of grain i those with `other[first[i]:first[i + 1]]`, whose springs are `springs`,
    shape (pairs, 6), where they are `touching`; `at_floor` and `at_foot` are those of floor and foot, shape (n, 6).
    """

    radius_m: Row
    mass_kg: Row
    x: Row
    v: Row
    w: Row
    a: Row
    b: Row
    first: Whole
    other: Whole
    touching: Truths
    springs: Row
    at_floor: Row
    at_foot: Row


def grains_at(x: Row, radius_m: Row, density_kg_m3: float, gravity: Row, v: Row | None = None) -> Grains:
    """Return grains that have touched nothing yet, at rest or with velocities `v`, shape (n, 3)."""
    n = len(x)
    zero = np.zeros((n, 3))
    return Grains(
        radius_m=radius_m,
        mass_kg=density_kg_m3 * 4.0 / 3.0 * math.pi * radius_m**3,
        x=x,
        v=zero if v is None else v,
        w=zero,
        a=np.tile(gravity, (n, 1)),
        b=zero,
        first=np.zeros(n + 1, np.int64),
        other=np.zeros(0, np.int64),
        touching=np.zeros(0, np.bool_),
        springs=np.zeros((0, 6)),
        at_floor=np.zeros((n, 6)),
        at_foot=np.zeros((n, 6)),
    )


@dataclass(frozen=True, slots=True, eq=False)
class FootPath:
    """Heights (m) and velocities (m/s) of a foot of this radius at each step's end, before them those at the start."""

    radius_m: float
    height_m: Row
    velocity_m_s: Row


NO_FOOT = FootPath(0.0, np.zeros(0), np.zeros(0))
NEVER: Whole = np.zeros(1, np.int64)
"""Nobody stops it."""


def advance(
    grains: Grains,
    material: Material,
    width_m: float,
    step_s: float,
    steps: int,
    *,
    gravity: Row,
    foot: FootPath = NO_FOOT,
    every: int = 1,
    stop: Whole = NEVER,
) -> tuple[Grains, Row]:
    """Return the grains after so many steps, and the record after `every` steps each, shape (records, 7).

    Raises `CancelledError` where another thread writes a number other than 0 into `stop`, shape (1,).
    """
    radius_m = float(grains.radius_m.mean())
    given = [np.array(getattr(grains, one.name)) for one in fields(Grains)]
    record = np.zeros((steps // every, 7))
    lists = compiled_steps()(
        material.law(radius_m, float(grains.mass_kg.mean())),
        np.array([width_m, step_s, foot.radius_m]),
        np.asarray(gravity, np.float64),
        foot.height_m,
        foot.velocity_m_s,
        steps,
        every,
        stop,
        *given,
        record,
    )
    if stop[0]:
        raise CancelledError
    names = [one.name for one in fields(Grains)]
    after = dict(zip(names, given, strict=True)) | dict(zip(names[7:11], lists, strict=True))
    return Grains(**after), record


@functools.cache
def compiled_steps() -> Function:
    """Return the compiled steps; compiled at the first call, which takes half a minute once."""
    row, table, whole = numba.float64[::1], numba.float64[:, ::1], numba.int64
    lists = (whole[::1], whole[::1], numba.boolean[::1], table)
    types = (row, row, row, row, row, whole, whole, whole[::1], row, row, *(table,) * 5, *lists, table, table, table)
    return cached_entry(_advance, types, "grains", ())


@inlined
def nearest(d: float, width: float) -> float:
    """Return the difference of two places in a periodic box."""
    if d > 0.5 * width:
        return d - width
    if d < -0.5 * width:
        return d + width
    return d


@inner
def listed(
    width: float, skin: float, x: Row, radius: Row, first: Whole, other: Whole, touching: Truths, springs: Row
) -> Pairs:
    """Return the pairs within the skin, with the springs that they had."""
    n = len(x)
    size = 2.0 * radius.max() + skin
    low = x[:, 2].min()
    across = max(1, int(width / size))
    up = max(1, int((x[:, 2].max() - low) / size) + 1)
    up = min(up, 4 * n + 1)
    tall = max(size, (x[:, 2].max() - low) / up * (1.0 + 1e-12))
    cell = np.empty((n, 3), np.int64)
    begin = np.zeros(across * across * up + 1, np.int64)
    for i in range(n):
        for axis in range(2):
            x[i, axis] -= width * math.floor(x[i, axis] / width)
            cell[i, axis] = min(int(x[i, axis] / width * across), across - 1)
        cell[i, 2] = min(int((x[i, 2] - low) / tall), up - 1)
        begin[(cell[i, 0] * across + cell[i, 1]) * up + cell[i, 2] + 1] += 1
    begin = np.cumsum(begin)
    filled = begin.copy()
    members = np.empty(n, np.int64)
    for i in range(n):
        place = (cell[i, 0] * across + cell[i, 1]) * up + cell[i, 2]
        members[filled[place]] = i
        filled[place] += 1
    reach = 1 if across >= 3 else 0
    new_first = np.zeros(n + 1, np.int64)
    new_other = np.empty(16 * n, np.int64)
    count = 0
    for i in range(n):
        for p in range(-1, 2) if reach else range(across):
            for q in range(-1, 2) if reach else range(across):
                cx = (cell[i, 0] + p) % across
                cy = (cell[i, 1] + q) % across
                for cz in range(max(cell[i, 2] - 1, 0), min(cell[i, 2] + 2, up)):
                    place = (cx * across + cy) * up + cz
                    for k in range(begin[place], begin[place + 1]):
                        j = members[k]
                        if j > i:
                            dx = nearest(x[i, 0] - x[j, 0], width)
                            dy = nearest(x[i, 1] - x[j, 1], width)
                            dz = x[i, 2] - x[j, 2]
                            far = radius[i] + radius[j] + skin
                            if dx * dx + dy * dy + dz * dz < far * far:
                                new_other[count] = j
                                count += 1
        new_first[i + 1] = count
    new_touching = np.zeros(count, np.bool_)
    new_springs = np.zeros((count, 6))
    for i in range(n):
        for k in range(new_first[i], new_first[i + 1]):
            for old in range(first[i], first[i + 1]):
                if other[old] == new_other[k]:
                    new_touching[k] = touching[old]
                    new_springs[k] = springs[old]
    return new_first, new_other[:count].copy(), new_touching, new_springs


@inner
def pushed(
    law: Row,
    dt: float,
    width: float,
    radius: Row,
    mass: Row,
    x: Row,
    v: Row,
    w: Row,
    first: Whole,
    other: Whole,
    touching: Truths,
    springs: Row,
    f: Row,
    t: Row,
) -> tuple[float, float]:
    """Add the forces and torques of the pairs; return the power lost and the energy of the normal springs."""
    lost = elastic = 0.0
    for i in range(len(x)):
        for k in range(first[i], first[i + 1]):
            j = other[k]
            dx = nearest(x[i, 0] - x[j, 0], width)
            dy = nearest(x[i, 1] - x[j, 1], width)
            dz = x[i, 2] - x[j, 2]
            far = radius[i] + radius[j]
            square = dx * dx + dy * dy + dz * dz
            if square >= far * far:
                if touching[k]:
                    touching[k] = False
                    springs[k] = 0.0
                continue
            touching[k] = True
            distance = math.sqrt(square)
            nx, ny, nz = dx / distance, dy / distance, dz / distance
            overlap = far - distance
            arm_i, arm_j = radius[i] - 0.5 * overlap, radius[j] - 0.5 * overlap
            sx = arm_i * w[i, 0] + arm_j * w[j, 0]
            sy = arm_i * w[i, 1] + arm_j * w[j, 1]
            sz = arm_i * w[i, 2] + arm_j * w[j, 2]
            normal, fx, fy, fz, rx, ry, rz, power, stored = touch(
                law,
                dt,
                radius[i] * radius[j] / far,
                mass[i] * mass[j] / (mass[i] + mass[j]),
                overlap,
                nx,
                ny,
                nz,
                v[i, 0] - v[j, 0] - (sy * nz - sz * ny),
                v[i, 1] - v[j, 1] - (sz * nx - sx * nz),
                v[i, 2] - v[j, 2] - (sx * ny - sy * nx),
                w[i, 0] - w[j, 0],
                w[i, 1] - w[j, 1],
                w[i, 2] - w[j, 2],
                springs[k],
            )
            lost += power
            elastic += stored
            ax, ay, az = ny * fz - nz * fy, nz * fx - nx * fz, nx * fy - ny * fx
            fx, fy, fz = fx + normal * nx, fy + normal * ny, fz + normal * nz
            f[i, 0] += fx
            f[i, 1] += fy
            f[i, 2] += fz
            f[j, 0] -= fx
            f[j, 1] -= fy
            f[j, 2] -= fz
            t[i, 0] += rx - arm_i * ax
            t[i, 1] += ry - arm_i * ay
            t[i, 2] += rz - arm_i * az
            t[j, 0] -= rx + arm_j * ax
            t[j, 1] -= ry + arm_j * ay
            t[j, 2] -= rz + arm_j * az
    return lost, elastic


@inner
def held(
    law: Row,
    dt: float,
    radius: float,
    mass: float,
    gap: float,
    nx: float,
    ny: float,
    nz: float,
    moves: float,
    v: Row,
    w: Row,
    h: Row,
    f: Row,
    t: Row,
) -> tuple[float, float, float]:
    """Add what a body that moves upwards at `moves` does to a grain at this gap from its centre.

    Returns the upward force on the grain, the power lost and the energy of the normal spring.
    """
    if gap >= radius:
        if h[0] != 0.0 or h[1] != 0.0 or h[2] != 0.0:
            h[:] = 0.0
        return 0.0, 0.0, 0.0
    overlap = radius - gap
    arm = radius - 0.5 * overlap
    normal, fx, fy, fz, rx, ry, rz, lost, elastic = touch(
        law,
        dt,
        radius,
        mass,
        overlap,
        nx,
        ny,
        nz,
        v[0] - arm * (w[1] * nz - w[2] * ny),
        v[1] - arm * (w[2] * nx - w[0] * nz),
        v[2] - moves - arm * (w[0] * ny - w[1] * nx),
        w[0],
        w[1],
        w[2],
        h,
    )
    t[0] += rx - arm * (ny * fz - nz * fy)
    t[1] += ry - arm * (nz * fx - nx * fz)
    t[2] += rz - arm * (nx * fy - ny * fx)
    fx, fy, fz = fx + normal * nx, fy + normal * ny, fz + normal * nz
    f[0] += fx
    f[1] += fy
    f[2] += fz
    return fz, lost, elastic


@inner
def by_foot(
    law: Row,
    dt: float,
    width: float,
    foot: float,
    z: float,
    moves: float,
    radius: float,
    mass: float,
    x: Row,
    v: Row,
    w: Row,
    h: Row,
    f: Row,
    t: Row,
) -> tuple[float, float, float]:
    """Do what `held` does for a grain at the foot, whose end is at height `z`, in the middle of the box."""
    dx, dy = nearest(x[0] - 0.5 * width, width), nearest(x[1] - 0.5 * width, width)
    beside = math.sqrt(dx * dx + dy * dy)
    if beside <= foot:  # under its end
        return held(law, dt, radius, mass, z - x[2], 0.0, 0.0, -1.0, moves, v, w, h, f, t)
    out, down = beside - foot, max(z - x[2], 0.0)  # beside it, or at its edge
    gap = math.sqrt(out * out + down * down)
    across = out / (gap * beside)
    return held(law, dt, radius, mass, gap, across * dx, across * dy, -down / gap, moves, v, w, h, f, t)


def _advance(  # type: ignore[no-untyped-def]
    law, box, gravity, foot_z, foot_v, steps, every, stop, radius, mass, x, v, w, a, b, first, other, touching, springs,
    at_floor, at_foot, record,
):  # fmt: skip
    width, dt, foot = box
    n = len(x)
    skin = SKIN_SHARE * 2.0 * radius.max()
    before_a, before_b = np.empty_like(a), np.empty_like(b)
    listed_at = x.copy()
    has_pairs = False
    work = lost = force = floor = 0.0
    for step in range(steps):
        if stop[0] != 0:
            break
        moved = 0.0
        for i in range(n):
            far = 0.0
            for axis in range(3):
                x[i, axis] += dt * (v[i, axis] + 0.5 * dt * a[i, axis])
                v[i, axis] += dt * a[i, axis]
                w[i, axis] += dt * b[i, axis]
                before_a[i, axis], before_b[i, axis] = a[i, axis], b[i, axis]
                a[i, axis] = b[i, axis] = 0.0
                far += (x[i, axis] - listed_at[i, axis]) ** 2
            moved = max(moved, far)
        if not has_pairs or 4.0 * moved > skin * skin:
            has_pairs = True
            first, other, touching, springs = listed(width, skin, x, radius, first, other, touching, springs)
            listed_at[:] = x
        power, elastic = pushed(law, dt, width, radius, mass, x, v, w, first, other, touching, springs, a, b)
        on_foot = on_floor = 0.0
        for i in range(n):
            if x[i, 2] < 2.0 * radius[i]:
                up, more, stored = held(
                    law, dt, radius[i], mass[i], x[i, 2], 0.0, 0.0, 1.0, 0.0, v[i], w[i], at_floor[i], a[i], b[i]
                )
                on_floor += up
                power += more
                elastic += stored
            if foot > 0.0 and x[i, 2] + 2.0 * radius[i] > foot_z[step + 1]:
                up, more, stored = by_foot(
                    law, dt, width, foot, foot_z[step + 1], foot_v[step + 1], radius[i], mass[i],
                    x[i], v[i], w[i], at_foot[i], a[i], b[i],
                )  # fmt: skip
                on_foot -= up
                power += more
                elastic += stored
        kinetic = height = 0.0
        for i in range(n):
            inertia = 0.4 * mass[i] * radius[i] * radius[i]
            for axis in range(3):
                a[i, axis] = a[i, axis] / mass[i] + gravity[axis]
                b[i, axis] /= inertia
                v[i, axis] += 0.5 * dt * (a[i, axis] - before_a[i, axis])
                w[i, axis] += 0.5 * dt * (b[i, axis] - before_b[i, axis])
                kinetic += 0.5 * (mass[i] * v[i, axis] ** 2 + inertia * w[i, axis] ** 2)
                height -= mass[i] * gravity[axis] * x[i, axis]
        pushing = -on_foot * foot_v[step + 1] if foot > 0.0 else 0.0
        lost += dt * power
        work += dt * pushing
        force += on_foot
        floor += on_floor
        if (step + 1) % every == 0:
            row = record[(step + 1) // every - 1]
            row[KINETIC], row[HEIGHT], row[ELASTIC] = kinetic, height, elastic
            row[FORCE], row[FLOOR] = force / every, floor / every
            row[WORK], row[LOST] = work - 0.5 * dt * pushing, lost - 0.5 * dt * power  # trapezoidal, so far
            force = floor = 0.0
    return first, other, touching, springs
