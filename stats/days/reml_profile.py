"""What restricted maximum likelihood says at one gamma: estimates of the means, deviance, and their slopes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from stats.days.blocks import Floats
from stats.exact.finite import Number


@dataclass(frozen=True, slots=True)
class Estimates:
    """Generalised least squares at one gamma, in a basis that keeps comparisons apart from the level of days.

    So the variance of a comparison within days does not come out as a difference of two large variances.
    """

    basis: Floats
    """Means of the conditions by coefficient, shape (k, k)."""
    coefficients: Floats
    """Shape (k,), scaled."""
    inverse: Floats
    """Inverse of the triangle of the whitened design, shape (k, k)."""
    plain: tuple[Fraction, ...] | None
    """The means without error where they are the values' own at any gamma, so that what cancels leaves its digits."""

    def means(self) -> Sequence[Number]:
        """Return the k conditions' means."""
        return self.plain or (self.basis @ self.coefficients).tolist()

    def differences(self) -> Floats:
        """Return the means of all conditions but the first minus that of the first, shape (k - 1,)."""
        if self.plain is None:
            return np.asarray((self.basis[1:] - self.basis[0]) @ self.coefficients)
        return np.array([float(mean - self.plain[0]) for mean in self.plain[1:]])

    def root(self, weights: Floats) -> Floats:
        """Return a root A of the covariance AA' of weighted sums, in units of the residual standard deviation."""
        return np.asarray(weights @ self.basis @ self.inverse)

    def variance(self, weights: Floats) -> float:
        """Return the variance of one weighted sum, weights of shape (k,), in units of the residual variance."""
        root = self.root(weights)
        return float(root @ root)


@dataclass(frozen=True, slots=True)
class Profile:
    """The deviance with means and residual variance profiled out, and what follows from it, at one gamma."""

    deviance: float
    """REML criterion, -2 log restricted likelihood, in the scaled unit."""
    gradient: Floats
    """By gamma, shape (2,)."""
    hessian: Floats
    """Shape (2, 2)."""
    residual_variance: float
    estimates: Estimates
    reach: tuple[Floats, Floats]
    """How days and runs reach into the estimates: Z_i' and Q, both whitened."""
    pulls: tuple[float, float]
    """w_i'w_i: minus the derivative of S by gamma."""

    def slope(self, place: int, weights: Floats) -> float:
        """Return the derivative of `estimates.variance(weights)` by one gamma."""
        part = self.reach[place] @ self.estimates.root(weights)
        return float(part @ part)
