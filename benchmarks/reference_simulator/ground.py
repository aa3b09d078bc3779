"""Granular ground under a flat foot on a tape: stiffness, inertial drag and added mass (thesis 3.1.2)."""

import mpmath

from benchmarks.reference_simulator.fixed_point import FixedPoint
from benchmarks.reference_simulator.parameters import GRAVITY, GranularParameters
from benchmarks.reference_simulator.power_series import Series, SeriesTape


class Ground:
    """The ground's constants, and its reaction on a foot that moves down in virgin material."""

    def __init__(self, parameters: GranularParameters, number: FixedPoint) -> None:
        p, of = parameters, number.of
        self.number = number
        self.gravity = of(GRAVITY)
        self.foot_mass = of(p.foot_mass_kg)
        multiply, divide = number.multiply, number.divide
        pi = number.evaluate(lambda: mpmath.pi)
        self._radius = of(p.foot_radius_m)
        self._slope = number.evaluate(lambda mu, theta: mu / mpmath.tan(theta), p.recruitment_rate, p.cone_angle_rad)
        self._pi = pi
        self.cone_depth = divide(self._radius, self._slope)
        self._disk = multiply(pi, of(p.foot_radius_m**2))
        self._full_volume = divide(multiply(pi, of(p.foot_radius_m**3)), 3 * self._slope)
        # K = penetration V + stress z (disk + V);  D = drag (grains A + shed);  m_a = grains V + shed z
        self._penetration = divide(of(p.stiffness_scale * p.penetration_stiffness_n_m), self._disk)
        self._stress = number.evaluate(
            lambda stress, theta: stress / mpmath.cos(theta), p.stiffness_scale * p.depth_stress_n_m3, p.cone_angle_rad
        )
        self._drag = of(p.drag_scale * p.inertial_drag_factor * p.surrounding_mass_factor)
        self._grains = of(p.packing_fraction * p.grain_density_kg_m3 * p.recruitment_rate)
        self._shed = of(p.shed_mass_kg_m)

    def area_and_volume(self, tape: SeriesTape, depth: Series, *, cone_complete: bool) -> tuple[Series, Series]:
        """Flat area left under the foot and its integral over depth, as series; constant once the cone is complete."""
        if cone_complete:
            return tape.constant(0), tape.constant(self._full_volume)
        radius, slope = self._radius, self._slope
        multiply = self.number.multiply
        left = tape.combine([(-slope, depth)], radius)
        area = tape.combine([(self._pi, tape.multiply(left, left))])
        # V = pi z (R^2 - q R z + q^2 z^2 / 3)
        squared = tape.multiply(depth, depth)
        bracket = tape.combine(
            [(-multiply(slope, radius), depth), (multiply(slope, slope) // 3, squared)], multiply(radius, radius)
        )
        return area, tape.combine([(self._pi, tape.multiply(depth, bracket))])

    def stiffness_force(self, tape: SeriesTape, depth: Series, volume: Series) -> Series:
        """The hydrostatic force K(z) in newtons."""
        loaded = tape.combine([(self.number.one, volume)], self._disk)
        return tape.combine([(self._penetration, volume), (self._stress, tape.multiply(depth, loaded))])

    def added_mass(self, tape: SeriesTape, depth: Series, volume: Series) -> Series:
        """The mass m_a(z) of the grains that move with the foot, in kilograms."""
        return tape.combine([(self._grains, volume), (self._shed, depth)])

    def added_mass_slope(self, tape: SeriesTape, area: Series) -> Series:
        """The derivative of the added mass with depth, in kg/m."""
        return tape.combine([(self._grains, area)], self._shed)

    def drag_coefficient(self, tape: SeriesTape, slope: Series) -> Series:
        """The inertial drag D(z), in N / (m/s)^2."""
        return tape.combine([(self._drag, slope)])
