"""A foot in a bed of grains: the bed at rest, the motion it follows, what the grains take up, and what is refused."""

from __future__ import annotations

from concurrent.futures import CancelledError
from dataclasses import replace

import numpy as np
import pytest

from data_schema.errors import UnknownName, UsageError
from data_schema.file_cache import without_caches
from reports.figures.grains import draw_grains
from simulator.grains.bed import BEDS, GRAVITY, BedAsked, bed_by_words, settled
from simulator.grains.foot import GrainsStudy, foot_motion, jumps_on_grains
from simulator.grains.stepping import FLOOR, KINETIC, advance
from simulator.jump import simulate
from simulator.parameter import GRAVITY_M_S2
from simulator.scene_file import load_scene
from tests.helpers.wording import refuses

SMALL = BedAsked(diameter_m=0.018, width_m=0.12, depth_m=0.14)


@pytest.fixture(scope="module")
def study() -> GrainsStudy:
    return jumps_on_grains(load_scene("sim1"), SMALL, (0.018, 0.02), 2)


def test_a_bed_rests_level_on_its_floor_and_is_the_same_each_time() -> None:
    bed = settled(SMALL)
    steps = round(0.02 / SMALL.step_s)
    after, record = advance(
        bed.grains, SMALL.material, SMALL.width_m, SMALL.step_s, steps, gravity=GRAVITY, every=steps
    )
    weight_n = GRAVITY_M_S2 * float(bed.grains.mass_kg.sum())
    assert record[0, FLOOR] == pytest.approx(weight_n, rel=0.02)
    assert record[0, KINETIC] < 1e-3 * weight_n * SMALL.diameter_m
    assert np.abs(after.x[:, 2] - bed.grains.x[:, 2]).max() < 0.05 * SMALL.diameter_m
    top_m = (bed.grains.x[:, 2] + bed.grains.radius_m).max()
    assert SMALL.depth_m - SMALL.diameter_m < top_m <= SMALL.depth_m
    assert 0.5 < bed.solid_fraction < 0.64
    with without_caches():
        again = settled(SMALL)
    np.testing.assert_array_equal(again.grains.x, bed.grains.x)
    np.testing.assert_array_equal(again.grains.springs, bed.grains.springs)
    assert not np.array_equal(settled(replace(SMALL, seed=1)).grains.radius_m[:9], bed.grains.radius_m[:9])


@pytest.mark.parametrize("name", ["sim1", "bed"])
def test_the_foot_s_work_is_what_the_robot_loses(name: str) -> None:
    """The bulk model's force, from the accelerations, closes the robot's book of energies and the leg's work."""
    scene = load_scene(name)
    motion = foot_motion(scene)
    result = simulate(scene, trajectory=True)
    sampled = result.trajectory
    assert sampled is not None
    flying_s = result.jump.touchdown_time_s + motion.liftoff_time_s + 0.01
    energy_j = sum(
        scene[f"{part}_mass"]
        * (0.5 * sampled[f"{part}_velocity"].to_numpy() ** 2 + GRAVITY_M_S2 * sampled[f"{part}_height"].to_numpy())
        for part in ("body", "foot")
    )
    lost_j = sampled["leg_work"].to_numpy() - (energy_j - energy_j[0])
    assert motion.bulk_work_j[-1] == pytest.approx(np.interp(flying_s, sampled["time"], lost_j), rel=0.02)
    path = motion.path(0.03, 1e-4, 0.1)
    assert path.height_m.min() == pytest.approx(0.1 - motion.max_depth_m, abs=1e-5)
    np.testing.assert_allclose(np.gradient(path.height_m, 1e-4)[9:-1], path.velocity_m_s[9:-1], atol=0.05)


def test_active_damping_leaves_the_grains_less_energy_in_extension(study: GrainsStudy) -> None:
    for bed in study.beds:
        ce, ad = bed.jumps.ce, bed.jumps.ad
        assert ce.peak_extension_j > 2.0 * ad.peak_extension_j
        assert ce.extension_work_j > 2.0 * ad.extension_work_j
        before = ce.time_s < ce.extension_time_s
        np.testing.assert_allclose(ad.kinetic_j[: len(before)][before], ce.kinetic_j[before], rtol=0.2, atol=1e-4)
        assert max(ce.book_residual, ad.book_residual) < 0.01
        assert ce.force_n[ce.time_s > study.motions.ce.liftoff_time_s + 0.02].max() < 0.05 * ce.force_n.max()


def test_each_bed_and_each_size_is_drawn(study: GrainsStudy) -> None:
    figure = draw_grains(study)
    energies = figure.axes[:2]
    assert [sum(len(line.get_xdata()) > 2 for line in axes.lines) for axes in energies] == [4, 4]


def test_a_bed_that_is_stopped_is_none_and_one_that_nobody_stops_is_kept() -> None:
    asked = replace(SMALL, seed=1_000_003, depth_m=0.08)
    stop = np.ones(1, np.int64)
    with pytest.raises(CancelledError):
        settled(asked, stop)
    assert BEDS.read(asked.name) is None
    stop[0] = 0
    settled(asked, stop)
    assert BEDS.read(asked.name) is not None
    BEDS.folder.joinpath(asked.name).unlink()


def test_what_is_no_bed_of_grains_is_refused() -> None:
    scene = load_scene("sim1")
    with refuses(UsageError, "emulator"):
        jumps_on_grains(load_scene("emulator"), SMALL)
    with refuses(UsageError, "b_ad", "damping_gain"):
        jumps_on_grains(load_scene("bed"), SMALL)
    with refuses(UsageError, "--grain", "depth=0.1"):
        jumps_on_grains(scene, replace(SMALL, depth_m=0.08), (0.01,))
    with refuses(UsageError, "width=0.18"):
        jumps_on_grains(scene, replace(SMALL, width_m=0.1), (0.01,))
    for no_size in (-0.01, 0.0, float("nan")):
        with refuses(UsageError, f"--diameter {no_size:g}", "above 0"):
            jumps_on_grains(scene, SMALL, (no_size,))
    with refuses(UsageError, "--diameter 0.05", "foot of 0.03 m radius"):
        jumps_on_grains(scene, SMALL, (0.05,))
    with refuses(UsageError, "200000"):
        settled(replace(SMALL, diameter_m=0.001))
    with refuses(UnknownName, "friction"):
        bed_by_words(["fricton=0.4"])
    for word in ("friction=much", "restitution=1.5", "depth=nan"):
        with refuses(UsageError, word):
            bed_by_words([word])
    assert bed_by_words(["friction=0.4", "depth=0.2"]).material.friction == 0.4
