import numpy as np
import pytest

from data_schema.units import STANDARD_GRAVITY_M_S2
from labbook.demo.plate import PlateRecord
from labbook.demo.studies.force_plate import hopping_record
from simulator.scene_file import load_scene


def plate_record(seed: int, hops: int) -> PlateRecord:
    return hopping_record(seed, 400, hops)


def test_mean_force_over_the_hops_is_the_robots_weight() -> None:
    record = plate_record(1, 40)
    fz_n = record.force_n[1000:-1000, 2]
    scene = load_scene("force_plate")
    weight_n = (scene["body_mass"] + scene["foot_mass"]) * STANDARD_GRAVITY_M_S2
    assert fz_n.mean() == pytest.approx(weight_n, rel=0.02)


def test_plate_is_unloaded_before_and_after_and_in_flight() -> None:
    record = plate_record(1, 40)
    fz_n = record.force_n[:, 2]
    assert abs(fz_n[:1000].mean()) < 0.5
    assert abs(fz_n[-1000:].mean()) < 0.5
    smooth_n = np.convolve(fz_n, np.full(15, 1 / 15), mode="same")
    assert np.count_nonzero(np.diff((smooth_n > 15).astype(int)) == 1) == 40


def test_centre_of_pressure_is_the_quotient_within_its_limit() -> None:
    record = plate_record(1, 5)
    loaded = record.force_n[:, 2] > 40
    np.testing.assert_allclose(
        record.cop_m[loaded, 0], -record.moment_nm[loaded, 1] / record.force_n[loaded, 2], rtol=1e-12
    )
    np.testing.assert_allclose(
        record.cop_m[loaded, 1], record.moment_nm[loaded, 0] / record.force_n[loaded, 2], rtol=1e-12
    )
    assert np.abs(record.cop_m).max() <= 1.28
    assert np.abs(record.cop_m[loaded]).max() < 0.1


def test_clock_is_20_ppm_slow() -> None:
    time_ms = plate_record(1, 2).time_ms
    np.testing.assert_allclose(np.diff(time_ms), 1.00002, rtol=1e-9)
