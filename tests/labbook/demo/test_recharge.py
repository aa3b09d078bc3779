import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from labbook.demo.files import recharge_course


@given(st.integers(1, 500), st.integers(0, 100))
def test_counter_ends_at_the_charge_and_agrees_with_the_current(charge_mah: int, seed: int) -> None:
    course = recharge_course(seed, charge_mah, 15.4)
    assert course.charge_mah[-1] == charge_mah
    assert np.all(np.diff(course.charge_mah) >= 0)
    integral_mah = np.trapezoid(course.current_a, course.time_s) / 3.6
    # At most one second of the full current too much, by which the charger overshoots.
    assert charge_mah <= integral_mah + 1e-9 <= charge_mah + 1 / 3.6 + 1e-6


def test_four_cells_make_the_pack_and_end_at_the_storage_voltage() -> None:
    course = recharge_course(1, 150, 15.4)
    assert course.cell_v.shape == (course.time_s.size, 4)
    np.testing.assert_allclose(course.pack_v, course.cell_v.sum(axis=1), atol=0.006)
    assert course.pack_v[-1] == pytest.approx(15.4, abs=0.02)
    assert course.current_a.max() == 1.0
