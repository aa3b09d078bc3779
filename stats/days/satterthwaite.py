"""Degrees of freedom after Satterthwaite, as lmerTest computes them, from exact derivatives of the deviance.

A contrast l'b has the variance v = l'Cl, which depends on the variance parameters (theta, sigma). These are known only
to A, twice the inverse Hessian of the REML deviance; then df = 2 v^2 / (g'Ag) with g the gradient of v. lmerTest takes
both derivatives numerically and keeps them to some 8 digits; its cut-off for small curvatures depends on the unit of
the data (it warns for values in the thousands and more). Here neither happens.
"""

from __future__ import annotations

import numpy as np

from stats.days.blocks import Floats
from stats.days.reml_profile import Profile


class Satterthwaite:
    """The degrees of freedom of any contrast of one fit."""

    def __init__(self, profile: Profile, gamma: Floats, degrees: int) -> None:
        """Take the fit's profile at its gamma, shape (2,), with n - k `degrees`."""
        self._profile = profile
        # At theta = 0 v does not change with theta to first order, nor does it mix with sigma: the parameter drops out.
        inner = np.flatnonzero(gamma > 0.0)
        theta = np.sqrt(gamma[inner])
        squares = profile.residual_variance * degrees
        # Second derivatives of D(theta, log sigma) = log dets + S / sigma^2 + nu log sigma^2 at the minimum.
        force = np.array(profile.pulls)[inner]
        size = inner.size + 1
        hessian = np.zeros((size, size))
        # The profiled Hessian has the term of sigma's minimum in it, -nu (S'/S)^2: take it out again.
        plain = profile.hessian[np.ix_(inner, inner)] + degrees * np.outer(force, force) / squares**2
        hessian[:-1, :-1] = 4.0 * np.outer(theta, theta) * plain + np.diag(2.0 * profile.gradient[inner])
        hessian[:-1, -1] = hessian[-1, :-1] = 4.0 * theta * force * degrees / squares
        hessian[-1, -1] = 4.0 * degrees
        scale = 1.0 / np.sqrt(np.maximum(np.abs(np.diag(hessian)), np.finfo(np.float64).tiny))
        curves, directions = np.linalg.eigh(hessian * np.outer(scale, scale))
        kept = curves > 1e-12
        turned = scale[:, None] * directions[:, kept]
        self._doubt = 2.0 * (turned / curves[kept]) @ turned.T
        self._inner = list(zip(inner.tolist(), theta.tolist(), strict=True))

    def df(self, weights: Floats) -> float:
        """Return the degrees of freedom of the weighted sum of means with weights of shape (k,)."""
        variance = self._profile.estimates.variance(weights)
        by_theta = [2.0 * theta * self._profile.slope(place, weights) for place, theta in self._inner]
        gradient = np.array([*by_theta, 2.0 * variance])
        return 2.0 * variance**2 / float(gradient @ self._doubt @ gradient)

    def f_test(self, contrasts: Floats) -> tuple[float, float] | None:
        """Return F of all contrasts being 0 and its denominator's degrees of freedom.

        `contrasts` has shape (q, k), and its rows add up to 0.

        F is split into t-tests of uncorrelated contrasts whose degrees of freedom are joined through the expected
        values of their squares (Fai and Cornelius); where they differ, the result depends on the contrasts chosen,
        though not on how rows of unit length at right angles to each other are turned.
        None where the contrasts' standard errors are so far apart (1e10) that the smallest is lost.
        """
        estimates = self._profile.estimates
        turn, errors, _right = np.linalg.svd(estimates.root(contrasts), full_matrices=False)
        if errors[-1] <= 1e-10 * errors[0]:
            return None
        turned = turn.T @ contrasts
        q = errors.size
        found = turned[:, 1:] @ estimates.differences()
        f = float(np.sum((found / errors) ** 2)) / (q * self._profile.residual_variance)
        single = [self.df(row) for row in turned]
        if max(single) - min(single) < 1e-8:
            return f, float(np.mean(single))
        if min(single) <= 2.0:
            return f, 2.0
        expected = sum(df / (df - 2.0) for df in single)
        return f, 2.0 * expected / (expected - q)
