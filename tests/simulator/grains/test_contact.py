"""Two grains, and one on a floor: against Hertz, Antypov & Elliott, and what friction and rolling resistance allow."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulator.compiled import Row
from simulator.grains.contact import Material
from simulator.grains.stepping import ELASTIC, FLOOR, HEIGHT, KINETIC, LOST, Grains, advance, grains_at
from simulator.parameter import GRAVITY_M_S2

WIDTH_M, DENSITY = 0.2, 1000.0
NO_GRAVITY = np.zeros(3)


def two(speed_m_s: float, radii_m: tuple[float, float], offset: float = 0.0) -> Grains:
    """Two grains just before they meet, the second at rest; the first comes along x, `offset` of the radii beside."""
    far = sum(radii_m)
    aside = offset * far
    x = np.array([[0.1 - math.sqrt(far**2 - aside**2) * (1.0 + 1e-9), 0.1, 0.1], [0.1, 0.1 + aside, 0.1]])
    v = np.array([[speed_m_s, 0.0, 0.0], [0.0, 0.0, 0.0]])
    return grains_at(x, np.array(radii_m), DENSITY, NO_GRAVITY, v)


def hertz_duration_s(grains: Grains, material: Material, speed_m_s: float) -> float:
    """How long an elastic collision takes: 2.943 d / v with d the largest overlap (Johnson 1985, eq. 11.24)."""
    mass_kg = grains.mass_kg.prod() / grains.mass_kg.sum()
    radius_m = grains.radius_m.prod() / grains.radius_m.sum()
    overlap_m = (15.0 * mass_kg * speed_m_s**2 / (16.0 * material.contact_modulus_pa * math.sqrt(radius_m))) ** 0.4
    return 2.9432 * overlap_m / speed_m_s


def collided(grains: Grains, material: Material, duration_s: float, steps: int) -> tuple[Grains, Row]:
    """The grains when they have parted, in steps of which a collision takes so many."""
    return advance(grains, material, WIDTH_M, duration_s / steps, 3 * steps, gravity=NO_GRAVITY)


@given(st.floats(0.01, 2.0), st.floats(0.5, 1.0), st.floats(1e6, 1e8))
def test_an_elastic_collision_takes_as_long_as_hertz_says(speed_m_s: float, share: float, young_pa: float) -> None:
    material = Material(young_modulus_pa=young_pa, restitution=1.0 - 1e-12)
    grains = two(speed_m_s, (0.004, 0.004 * share))
    expected_s = hertz_duration_s(grains, material, speed_m_s)
    after, record = collided(grains, material, expected_s, 500)
    assert np.count_nonzero(record[:, ELASTIC]) / 500 == pytest.approx(1.0, abs=0.005)
    assert after.v[1, 0] - after.v[0, 0] == pytest.approx(speed_m_s, rel=1e-5)


@given(st.floats(0.05, 0.98), st.floats(0.01, 2.0))
def test_the_restitution_is_that_of_the_material_at_every_speed(restitution: float, speed_m_s: float) -> None:
    material = Material(restitution=restitution)
    grains = two(speed_m_s, (0.004, 0.003))
    after, _ = advance(
        grains,
        material,
        WIDTH_M,
        hertz_duration_s(grains, material, speed_m_s) / 2000,
        12_000,
        gravity=NO_GRAVITY,
        every=100,
    )
    assert (after.v[1, 0] - after.v[0, 0]) / speed_m_s == pytest.approx(restitution, abs=0.004)


@given(st.floats(0.0, 0.95), st.floats(0.0, 1.0), st.floats(0.0, 0.5), st.floats(0.2, 0.95), st.integers(0, 2**32))
def test_momentum_spin_and_energy_are_kept(
    offset: float, friction: float, rolling: float, restitution: float, seed: int
) -> None:
    material = Material(friction=friction, rolling_friction=rolling, restitution=restitution)
    grains = two(0.5, (0.004, 0.003), offset)
    grains.w[:] = np.random.default_rng(seed).uniform(-100.0, 100.0, (2, 3))
    after, record = collided(grains, material, hertz_duration_s(grains, material, 0.5), 2000)
    inertia = 0.4 * grains.mass_kg * grains.radius_m**2

    def momentum(of: Grains) -> Row:
        return np.concatenate(
            [of.mass_kg @ of.v, (of.mass_kg[:, np.newaxis] * np.cross(of.x, of.v)).sum(axis=0) + inertia @ of.w]
        )

    scale = np.repeat([0.5, 0.05], 3) * grains.mass_kg[0]
    np.testing.assert_allclose(momentum(after) / scale, momentum(grains) / scale, atol=1e-9)
    book_j = record[:, [KINETIC, ELASTIC, LOST]].sum(axis=1)
    assert book_j[-1] == pytest.approx(book_j[0], rel=2e-3)
    assert record[-1, LOST] >= -1e-12


@pytest.mark.parametrize(("restitution", "offset", "order"), [(1.0 - 1e-12, 0.0, 2.0), (0.5, 0.5, 1.0)])
def test_errors_fall_with_the_step(restitution: float, offset: float, order: float) -> None:
    """With its square where forces are smooth; friction and damping begin with a contact, and that within a step."""
    material = Material(restitution=restitution)
    grains = two(0.5, (0.004, 0.003), offset)
    duration_s = hertz_duration_s(grains, material, 0.5)

    def deepest(steps: int) -> Row:
        """Velocities and spins while the grains press each other."""
        after, _ = advance(grains, material, WIDTH_M, 0.5 * duration_s / steps, steps, gravity=NO_GRAVITY)
        return np.concatenate([after.v.ravel(), 0.004 * after.w.ravel()])

    exact = deepest(40_960)
    errors = np.array([np.abs(deepest(steps) - exact).max() for steps in (40, 80, 160, 320)])
    assert np.log2(errors[0] / errors[-1]) / 3.0 == pytest.approx(order, abs=0.2)
    assert errors[0] < 0.01


def on_slope(degrees: float, material: Material, time_s: float) -> tuple[Grains, Row]:
    """A grain that starts at rest on the floor, under gravity turned by this angle, and gravity."""
    gravity = GRAVITY_M_S2 * np.array([math.sin(math.radians(degrees)), 0.0, -math.cos(math.radians(degrees))])
    radius_m, mass_kg = 0.004, DENSITY * 4.0 / 3.0 * math.pi * 0.004**3
    overlap_m = (-gravity[2] * mass_kg / (4.0 / 3.0 * material.contact_modulus_pa * math.sqrt(radius_m))) ** (2.0 / 3.0)
    grains = grains_at(np.array([[0.02, 0.1, radius_m - overlap_m]]), np.array([radius_m]), DENSITY, gravity)
    step_s = 1e-5
    after, _ = advance(grains, material, 10.0, step_s, round(time_s / step_s), gravity=gravity, every=100)
    return after, gravity


@pytest.mark.parametrize(("degrees", "friction", "rolls"), [(10.0, 0.5, True), (50.0, 0.5, True), (70.0, 0.3, False)])
def test_a_sphere_rolls_or_slides_down_a_slope(degrees: float, friction: float, rolls: bool) -> None:
    """It rolls where friction is over 2/7 of the tangent, at 5/7 g sin; else it slides at g (sin - friction cos)."""
    after, gravity = on_slope(degrees, Material(friction=friction, rolling_friction=0.0), 0.2)
    downhill, into = gravity[0], -gravity[2]
    assert rolls == (friction > 2.0 / 7.0 * downhill / into)
    expected = 5.0 / 7.0 * downhill if rolls else downhill - friction * into
    assert after.v[0, 0] / 0.2 == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize(("tangent", "stays"), [(0.09, True), (0.12, False)])
def test_rolling_resistance_holds_a_sphere_up_to_its_limit(tangent: float, stays: bool) -> None:
    """A sphere whose rolling friction is c stands on slopes of a tangent up to c."""
    after, _ = on_slope(math.degrees(math.atan(tangent)), Material(rolling_friction=0.1), 0.5)
    assert (abs(after.v[0, 0]) < 1e-4) == stays


def test_a_column_weighs_on_the_floor() -> None:
    """Six grains on top of each other: the floor bears their weight, each is as flat as that above it makes it."""
    radius_m = np.full(6, 0.004)
    x = np.stack([np.full(6, 0.1), np.full(6, 0.1), 0.004 + 0.008 * np.arange(6)], axis=1)
    gravity = np.array([0.0, 0.0, -GRAVITY_M_S2])
    material = Material()
    after, record = advance(
        grains_at(x, radius_m, DENSITY, gravity), material, WIDTH_M, 2e-5, 20_000, gravity=gravity, every=1000
    )
    weight_n = GRAVITY_M_S2 * float(after.mass_kg.sum())
    assert record[-1, FLOOR] == pytest.approx(weight_n, rel=1e-4)
    above_n = weight_n * np.arange(5, 0, -1) / 6.0
    overlap_m = 0.008 - np.diff(after.x[:, 2])
    pushed_n = 4.0 / 3.0 * material.contact_modulus_pa * math.sqrt(0.002) * overlap_m**1.5
    np.testing.assert_allclose(pushed_n, above_n, rtol=1e-3)
    book_j = record[:, [KINETIC, HEIGHT, ELASTIC, LOST]].sum(axis=1)
    assert np.ptp(book_j) < 1e-3 * record[-1, LOST]
