"""Contacts in a plate's force: against hops whose force, impulse and apex are known."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from data_schema.units import STANDARD_GRAVITY_M_S2
from data_schema.vocabulary import Undefined
from simulator.jump import simulate
from simulator.kernel.layout import FLIGHT
from simulator.parameter import GRAVITY_M_S2
from simulator.scene_file import load_scene
from stats.force_plate import Contact, find_contacts, jump_heights
from tests.helpers.stated_campaign import ROBOT_MASS_KG as MASS_KG
from tests.helpers.stated_campaign import hops_in_place

RATE_HZ = 1000
NOISE_N = 2.5
Floats = NDArray[np.float64]


def contacts_in(time_s: Floats, force_n: Floats) -> tuple[Contact, ...]:
    found = find_contacts(time_s, force_n)
    assert not isinstance(found, Undefined), found
    return found


class Hops:
    """Hops in place on rigid ground, apex after apex, the plate empty for a second before and after."""

    def __init__(self, hops: int, *, apex_m: float = 0.345, apex_sd_m: float = 0.004, seed: int = 1) -> None:
        self.random = np.random.default_rng(seed)
        self.each, self.force_n = hops_in_place(self.random.normal(apex_m, apex_sd_m, hops + 1))
        self.time_s = np.arange(self.force_n.size) / RATE_HZ

    def noisy_n(self, noise_n: float = NOISE_N) -> Floats:
        """The force as a plate shows it."""
        return self.force_n + self.random.normal(0.0, noise_n, self.force_n.size)

    def contacts(self, noise_n: float = NOISE_N) -> tuple[Contact, ...]:
        """The contacts found in the noisy force."""
        return contacts_in(self.time_s, self.noisy_n(noise_n))


@pytest.fixture(scope="module")
def hops() -> Hops:
    return Hops(80)


def test_each_contact_has_its_peak_its_times_and_the_impulse_of_its_momentum(hops: Hops) -> None:
    """The largest of some forty samples near the peak lies up to four of the noise's standard deviations above it.

    Noise of a twentieth of the peak moves single ends by some milliseconds; their mean is right to 2 ms. The impulse is
    m (v at take-off + v at touchdown) + m g T, with white noise and a zero known from 125 samples a flight.
    """
    found, errors_s = hops.contacts(), []
    for contact, hop in zip(found, hops.each, strict=True):
        inside = (hops.time_s >= contact.start_s) & (hops.time_s <= contact.end_s)
        true_n = float(hops.force_n[inside].max())
        assert true_n - NOISE_N < contact.peak_n < true_n + 4.5 * NOISE_N
        length_s = hop.lift_off_s - hop.touchdown_s
        errors_s.append(contact.duration_s - length_s)
        true = MASS_KG * (hop.lift_off_speed_m_s + hop.touchdown_speed_m_s + STANDARD_GRAVITY_M_S2 * length_s)
        around_s = length_s + 0.25
        noise = 5 * NOISE_N * math.hypot(math.sqrt(around_s / RATE_HZ), around_s / math.sqrt(125))
        assert contact.impulse_n_s == pytest.approx(true, abs=noise)
    assert abs(np.mean(errors_s)) < 0.002
    assert np.std(errors_s) < 0.006


@pytest.mark.parametrize("count", [4, 12, pytest.param(80, marks=pytest.mark.soak)])
def test_jump_heights_are_right_within_their_standard_error(count: int) -> None:
    """Of the hops' known apexes above take-off; over seeds the errors scatter as stated, or less."""
    scores = []
    for seed in range(20):
        hops = Hops(count, seed=seed)
        jumps = jump_heights(hops.contacts())
        assert not isinstance(jumps, Undefined)
        assert isinstance(jumps.se_m, float)
        true_m = [hop.apex_height_m - hop.lift_off_height_m for hop in hops.each[: len(jumps.heights_m)]]
        scores.append((jumps.mean_m - float(np.mean(true_m))) / jumps.se_m)
        assert jumps.weight_n == pytest.approx(MASS_KG * STANDARD_GRAVITY_M_S2, rel=0.05 / math.sqrt(count))
    assert math.sqrt(np.mean(np.square(scores))) < 1.5
    assert isinstance(jump_heights(Hops(3).contacts()), Undefined)  # too few


def test_the_simulator_s_impulse_and_height_are_found() -> None:
    """The robot lands with another leg length than it leaves with: heights from flight times are 5 % too low."""
    scene = load_scene("force_plate").changed(jumps=20)
    result = simulate(scene, trajectory=True)
    motion, body_kg, foot_kg = result.trajectory, scene["body_mass"], scene["foot_mass"]
    assert motion is not None
    time_s = motion["time"].to_numpy()
    pressing = motion["mode"].to_numpy() != FLIGHT
    force_n = np.where(
        pressing, body_kg * (motion["body_acceleration"].to_numpy() + GRAVITY_M_S2) + foot_kg * GRAVITY_M_S2, 0.0
    )
    grid_s = np.arange(0.0, time_s[-1] + 0.8, 1 / RATE_HZ)
    on_plate_n = np.interp(grid_s, time_s, force_n, right=0.0)
    for jump in result.jumps:  # the foot stops within two samples
        before = int(np.searchsorted(time_s, jump.touchdown_time_s)) - 3
        at = int(np.searchsorted(grid_s, jump.touchdown_time_s))
        on_plate_n[at : at + 2] -= foot_kg * float(motion["foot_velocity"][before]) * RATE_HZ / 2
    noisy_n = on_plate_n + np.random.default_rng(3).normal(0.0, 0.5, grid_s.size)
    contacts = contacts_in(grid_s, noisy_n)
    jumps = jump_heights(contacts)
    assert not isinstance(jumps, Undefined)
    assert isinstance(jumps.se_m, float)
    speeds_m_s = [body_kg * (jump.liftoff_body_velocity_m_s or 0.0) / (body_kg + foot_kg) for jump in result.jumps]
    known_m = float(np.mean([speed**2 / (2 * GRAVITY_M_S2) for speed in speeds_m_s]))
    assert jumps.mean_m == pytest.approx(known_m, abs=2 * jumps.se_m)
    assert jumps.se_m < 0.03 * known_m
    assert jumps.weight_n == pytest.approx((body_kg + foot_kg) * GRAVITY_M_S2, rel=5e-3)
    stances_s = [jump.liftoff_time_s for jump in result.jumps if jump.liftoff_time_s is not None]
    assert np.mean([contact.duration_s for contact in contacts]) == pytest.approx(np.mean(stances_s), abs=0.002)
    flights_s = np.array([contact.flight_s for contact in contacts if contact.flight_s is not None])
    assert float(np.mean(flights_s)) ** 2 * GRAVITY_M_S2 / 8 < 0.96 * known_m


@given(st.floats(-500.0, 500.0), st.floats(-0.2, 0.2), st.floats(0.1, 50.0), st.integers(0, 2**16))
def test_zero_drift_and_scale_do_not_matter(offset_n: float, drift_n_s: float, scale: float, seed: int) -> None:
    hops = Hops(5, seed=seed)
    noisy = hops.noisy_n(0.5)
    plain = contacts_in(hops.time_s, noisy)
    moved = contacts_in(hops.time_s, scale * noisy + offset_n + drift_n_s * hops.time_s)
    assert len(plain) == 5
    for one, other in zip(plain, moved, strict=True):
        assert other.peak_n == pytest.approx(scale * one.peak_n, rel=1e-2, abs=0.3)
        assert other.duration_s == pytest.approx(one.duration_s, abs=0.012)


def test_a_contact_with_missing_samples_or_at_an_end_is_left_out(hops: Hops) -> None:
    time_s, force_n, whole = hops.time_s, hops.noisy_n(), hops.contacts()
    force_n[300:305] += 60.0  # a knock is no contact
    assert len(contacts_in(time_s, force_n)) == len(whole)
    middle = int(RATE_HZ * (whole[3].start_s + whole[3].end_s) / 2)
    lost = slice(middle, middle + 3)
    force_n[lost] = np.nan
    assert len(contacts_in(time_s, force_n)) == len(whole) - 1
    assert len(contacts_in(np.delete(time_s, lost), np.delete(force_n, lost))) == len(whole) - 1
    begun = slice(int(RATE_HZ * (whole[0].start_s + 0.1)), None)
    assert len(contacts_in(time_s[begun], force_n[begun])) == len(whole) - 2


@pytest.mark.parametrize(
    "force_n",
    [
        np.random.default_rng(1).normal(0.0, 2.5, 5000),
        20.0 + np.random.default_rng(1).normal(0.0, 2.5, 5000),
        np.full(5, np.nan),
    ],
)
def test_without_contacts_nothing_is_made_up(force_n: Floats) -> None:
    found = find_contacts(np.arange(force_n.size) / RATE_HZ, force_n)
    assert isinstance(found, Undefined) or found == ()
