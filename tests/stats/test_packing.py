import math

import numpy as np
import pytest

from data_schema.errors import InputRefused
from data_schema.vocabulary import Undefined
from stats.packing import (
    DENSEST,
    fraction_from_height,
    fraction_from_mass,
    fraction_from_water,
    unbounded_fraction,
)
from tests.helpers.exact_fit import exact_fit, relative_error, root
from tests.helpers.wording import refuses, says

RADII = np.array([0.02, 0.03, 0.045, 0.06, 0.08])
GRAIN = 0.0034


def test_the_bed_of_the_thesis_from_its_mass():
    """Thesis 5.1.2: a box of 0.3 x 0.3 m filled to 0.16 m with glass beads (2500 kg/m^3), at 0.62 so 22.32 kg."""
    found = fraction_from_height(22.32, 2500.0, 0.3 * 0.3, 0.16, height_se_m=0.001, mass_se_kg=0.01)
    assert found.fraction == pytest.approx(0.62, rel=1e-12)
    assert found.se == pytest.approx(0.62 * math.hypot(0.001 / 0.16, 0.01 / 22.32), rel=1e-12)
    assert dict(found.error_terms)["height"] == pytest.approx(0.62 / 160.0, rel=1e-12)
    says(found.sentence(), "volume fraction is", "0.6200", "0.0039")
    same = fraction_from_mass(22.32, 2500.0, 0.0144)
    assert same.fraction == pytest.approx(found.fraction, rel=1e-14)
    assert same.se == 0.0
    says(same.sentence(), "volume fraction is", "0.62")


def test_the_standard_error_is_that_of_repeated_measurements():
    rng = np.random.default_rng(3)
    mass, density, volume = (
        rng.normal(mean, se, 200_000) for mean, se in ((22.32, 0.2), (2500.0, 30.0), (0.0144, 0.0001))
    )
    found = fraction_from_mass(22.32, 2500.0, 0.0144, mass_se_kg=0.2, grain_density_se_kg_m3=30.0, volume_se_m3=0.0001)
    assert found.se == pytest.approx(np.std(mass / (density * volume)), rel=0.02)
    water = fraction_from_water(1e-3, 0.39e-3, container_se_m3=4e-6, water_se_m3=3e-6)
    draws = 1.0 - rng.normal(0.39e-3, 3e-6, 200_000) / rng.normal(1e-3, 4e-6, 200_000)
    assert water.fraction == pytest.approx(0.61, rel=1e-14)
    assert water.se == pytest.approx(np.std(draws), rel=0.02)


@pytest.mark.parametrize("bulk", [0.61, 0.63])
def test_flasks_of_five_sizes_give_the_published_fractions_without_walls(bulk):
    """Thesis 5.1.2, figure 5.2: 0.61 loose and 0.63 compacted, at grain size / container radius = 0."""
    ratio = GRAIN / RADII
    scatter = np.array([1.0, -2.0, 0.5, 1.5, -1.0]) * 1e-3
    found = unbounded_fraction(RADII, bulk - 0.25 * ratio + scatter, GRAIN)
    assert found.ci[0] < bulk < found.ci[1]
    assert found.wall_effect == pytest.approx(-0.25, abs=3.0 * found.wall_effect_se)
    truth = exact_fit(bulk - 0.25 * ratio + scatter, [ratio])
    assert relative_error(found.fraction, truth.coefficients[0]) < 1e-14
    assert relative_error(found.se, root(truth.variances[0])) < 1e-12
    assert f"{bulk:.2f}"[:3] in found.sentence()
    says(found.sentence(), "n = 5", "measurements")


def test_fractions_on_one_line_have_no_interval():
    found = unbounded_fraction([1.0, 2.0, 4.0], [0.5, 0.5, 0.5], 0.001)
    assert (found.fraction, found.se) == (0.5, 0.0)
    assert isinstance(found.ci, Undefined)
    says(found.sentence(), "Without walls the", "0.5", "95 %")


def test_too_few_containers_are_refused():
    with refuses(InputRefused, "number of measurements", "2", "3"):
        unbounded_fraction(RADII[:2], [0.6, 0.61], GRAIN)
    with refuses(InputRefused, "3 radii", "2 fractions"):
        unbounded_fraction(RADII[:3], [0.6, 0.61], GRAIN)


def test_more_than_spheres_can_fill_is_said():
    found = fraction_from_water(1.0, 0.2, water_se_m3=0.01)
    assert found.denser_than_spheres
    says(found.sentence(), "equal spheres can")
    assert not fraction_from_water(1.0, 1.0 - DENSEST).denser_than_spheres


def test_what_cannot_be_is_refused():
    with pytest.raises(InputRefused, match="check the units"):
        fraction_from_mass(22.32, 2.5, 0.0144)
    with refuses(InputRefused, "check which is"):
        fraction_from_water(1.0, 1.1)
    with refuses(InputRefused, "the height is", "0"):
        fraction_from_height(1.0, 2500.0, 0.09, 0.0)
    with refuses(InputRefused, "standard error of"):
        fraction_from_mass(1.0, 2500.0, 0.09, mass_se_kg=-1.0)
    with refuses(InputRefused, "radii greater than", "0"):
        unbounded_fraction([0.0, 1.0, 2.0], [0.6, 0.6, 0.6], GRAIN)
    with pytest.raises(InputRefused, match="is constant"):
        unbounded_fraction([1.0, 1.0, 1.0], [0.6, 0.61, 0.6], GRAIN)
