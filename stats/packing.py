"""How densely grains lie: the volume fraction of a bed, and that of a bed without walls (thesis 5.1.2).

The thesis poured its beads into five flasks, measured the water that fills the gaps, and extrapolated the fraction over
grain size / container radius to 0, where no grain touches a wall: 0.61 loose, 0.63 compacted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from data_schema.errors import InputRefused
from data_schema.rounding import number_text
from data_schema.vocabulary import Undefined
from stats.checks import Missing, as_number, as_values, complete_rows, refuse_few
from stats.exact.numbers import refuse_beyond
from stats.lines.regression import LinearFit, fit_linear
from stats.results import Result, bounded_texts, missing_text, share_text

DENSEST = math.pi / math.sqrt(18.0)
"""0.7405: no packing of equal spheres is denser (Hales 2005)."""

WALL = "grain size / radius"
"""What fractions are extrapolated over, to 0; dimensionless."""


@dataclass(frozen=True, slots=True)
class PackingFraction(Result):
    """Share of a volume that grains fill."""

    fraction: float
    """Volume of the grains over the volume of the bed, 0 to 1."""
    se: float
    """Standard error from those of the measurements, to first order, as if independent."""
    error_terms: tuple[tuple[str, float], ...]
    """What each measurement's standard error contributes: name and size, of the fraction; shape (terms,)."""
    denser_than_spheres: bool
    """Whether it exceeds 0.7405, which equal spheres cannot: a measurement is off, or the grains differ in size."""

    def sentence(self) -> str:
        """Return the fraction in words, with its standard error and the largest cause of it."""
        text = f"The volume fraction is {number_text(self.fraction, error=self.se)}"
        if self.se > 0.0:
            name, _ = max(self.error_terms, key=lambda term: abs(term[1]))
            text += f" (standard error {number_text(self.se, 2)}, most of it from the {name})"
        return f"{text}, more than equal spheres can fill." if self.denser_than_spheres else f"{text}."


@dataclass(frozen=True, slots=True)
class UnboundedPacking(Result):
    """Line through fractions in containers of several sizes, read where the wall is infinitely far away."""

    fraction: float
    """At grain size / container radius = 0; 0 to 1."""
    se: float
    """Standard error of the fraction."""
    ci: tuple[float, float] | Undefined
    """Student's interval of the fraction; undefined where the fit is exact."""
    level: float
    """Level of the interval."""
    wall_effect: float
    """Change of the fraction per unit of grain size / container radius."""
    wall_effect_se: float
    """Its standard error, likewise dimensionless."""
    r_squared: float | Undefined
    """Of the line, about the mean."""
    df: int
    """Number of measurements minus 2."""
    n: int
    """Number of measurements."""
    fit: LinearFit
    """All that least squares says of the line over `WALL`."""
    missing: int = 0
    """Measurements left out because a value was NaN."""

    def sentence(self) -> str:
        """Return the fraction without walls in words, with interval, R squared and n."""
        fraction, interval = bounded_texts(self.fraction, self.ci, self.se, self.level)
        return (
            f"Without walls the volume fraction is {fraction} ({interval}; "
            f"line over grain size / container radius, R squared {share_text(self.r_squared)}, df = {self.df}, "
            f"n = {self.n} measurements{missing_text(self.missing)})."
        )


def fraction_from_mass(
    mass_kg: float,
    grain_density_kg_m3: float,
    volume_m3: float,
    *,
    mass_se_kg: float = 0.0,
    grain_density_se_kg_m3: float = 0.0,
    volume_se_m3: float = 0.0,
) -> PackingFraction:
    """Return mass / (density of a grain * volume of the bed); raises `InputRefused` for a fraction above 1."""
    return _quotient(
        {"mass": (mass_kg, mass_se_kg)},
        {"grain density": (grain_density_kg_m3, grain_density_se_kg_m3), "volume": (volume_m3, volume_se_m3)},
    )


def fraction_from_height(
    mass_kg: float,
    grain_density_kg_m3: float,
    base_area_m2: float,
    height_m: float,
    *,
    mass_se_kg: float = 0.0,
    grain_density_se_kg_m3: float = 0.0,
    base_area_se_m2: float = 0.0,
    height_se_m: float = 0.0,
) -> PackingFraction:
    """Return the fraction of a bed with straight walls, filled to a height, as `fraction_from_mass` does."""
    return _quotient(
        {"mass": (mass_kg, mass_se_kg)},
        {
            "grain density": (grain_density_kg_m3, grain_density_se_kg_m3),
            "base area": (base_area_m2, base_area_se_m2),
            "height": (height_m, height_se_m),
        },
    )


def fraction_from_water(
    container_m3: float, water_m3: float, *, container_se_m3: float = 0.0, water_se_m3: float = 0.0
) -> PackingFraction:
    """Return 1 - water / container: the water fills what the grains leave of a full container (thesis 5.1.2).

    >>> round(fraction_from_water(1.0e-3, 0.39e-3).fraction, 3)
    0.61
    """
    container = as_number("the container's volume", container_m3, above=0.0)
    water = as_number("the water's volume", water_m3, low=0.0)
    if water > container:
        raise InputRefused(f"{water:g} m^3 of water in a container of {container:g} m^3: check which is which.")
    terms = {
        "water": as_number("the water's standard error", water_se_m3, low=0.0) / container,
        "container": as_number("the container's standard error", container_se_m3, low=0.0)
        * (water / container)
        / container,
    }
    return _fraction((container - water) / container, terms)


def unbounded_fraction(
    container_radius_m: ArrayLike,
    fraction: ArrayLike,
    grain_size_m: float,
    *,
    level: float = 0.95,
    missing: Missing = "refuse",
) -> UnboundedPacking:
    """Extrapolate fractions in containers of radius R, both of shape (n,), to R = infinity over grain size / R.

    Raises `InputRefused` for fewer than 3 measurements, a single radius, lengths that differ, radii and sizes that are
    not positive, infinite values, for NaN unless `missing` is "drop" (which leaves out measurements), and where an
    uncertainty is beyond the doubles.
    """
    (container_radius_m, fraction), left_out = complete_rows([container_radius_m, fraction], missing)
    radii, fractions = as_values("the radii", container_radius_m), as_values("the fractions", fraction)
    grain = as_number("the grain size", grain_size_m, above=0.0)
    if radii.size and float(radii.min()) <= 0.0:
        raise InputRefused(f"a container's radius is {float(radii.min()):g} m: give radii greater than 0.")
    if radii.size != fractions.size:
        raise InputRefused(
            f"there are {radii.size} radii and {fractions.size} fractions: give the fraction in each container."
        )
    refuse_few(radii.size, "measurements", left_out)
    with np.errstate(over="ignore"):
        shares = np.divide(grain, radii)
    refuse_beyond("a grain size over a radius", shares.tolist())
    fit = fit_linear(fractions, {WALL: shares}, level=level)
    errors, _sd = fit.spread("the fraction without walls")
    return UnboundedPacking(
        fraction=fit.coefficients[0],
        se=errors[0],
        ci=fit.intervals()[0],
        level=fit.level,
        wall_effect=fit.coefficients[1],
        wall_effect_se=errors[1],
        r_squared=fit.r_squared,
        df=fit.df,
        n=fit.n,
        fit=fit,
        missing=left_out,
    )


_Measured = dict[str, tuple[float, float]]


def _quotient(above: _Measured, below: _Measured) -> PackingFraction:
    """Return a product over a product; relative errors add in squares."""
    value, relative = 1.0, {}
    for name, (measured, se) in {**above, **below}.items():
        number = as_number(f"the {name}", measured, above=0.0)
        relative[name] = as_number(f"the standard error of the {name}", se, low=0.0) / number
        value = value * number if name in above else value / number
    refuse_beyond("the fraction that was measured", [value])
    return _fraction(value, {name: share * value for name, share in relative.items()})


def _fraction(value: float, terms: dict[str, float]) -> PackingFraction:
    if value > 1.0:
        raise InputRefused(f"the grains would fill {value:.3g} of the volume: check the units of what was measured.")
    refuse_beyond("what a standard error makes of the fraction", [math.hypot(*terms.values())])
    return PackingFraction(value, math.hypot(*terms.values()), tuple(terms.items()), value > DENSEST)
