"""Fits of several columns: a plane, a line through 0 and a cubic, their coefficients and the test of all of them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import special

from benchmarks.stats_evidence.sizes.design import EVERY_N, RATIOS, Design, Floats, Groups
from benchmarks.stats_evidence.sizes.method import (
    LEVEL,
    Method,
    alike,
    of_interval,
    of_one_interval,
    of_one_p,
    of_p,
    there,
)
from stats.lines.regression import fit_linear, fit_polynomial

WAVES = 5.0
"""Of the second column, which is a sine of the first."""


@dataclass(frozen=True, slots=True)
class Columns:
    """A fit whose true coefficients are all 0."""

    name: str
    design: Callable[[Floats], Floats]
    """Columns at places x from 0 to 1, shape (n, p); the last coefficient's interval is looked at."""
    library: Callable[[Floats, Floats], tuple[tuple[float, float], float]]
    """Interval of the last coefficient and p of the F-test, of y over x."""
    intercept: bool = True

    def designs(self) -> tuple[Design, ...]:
        """Return sizes that leave scatter; the SD grows along x by `sd_ratio` in all."""
        p = self.design(np.zeros(1)).shape[1]
        return tuple(Design((n,), ratio) for n in EVERY_N for ratio in RATIOS if n > p)

    def data(self, groups: Groups, design: Design) -> tuple[Floats, Floats]:
        """Return x, shape (n,), and y of each study."""
        (noise,) = groups
        x = np.linspace(0.0, 1.0, design.n[0])
        return x, np.asarray(noise * design.sd_ratio**x / design.sds[0])

    def many(self, groups: Groups, design: Design) -> tuple[Floats, Floats]:
        """Return the interval of the last coefficient and p of the F-test of all but the intercept."""
        x, y = self.data(groups, design)
        columns = self.design(x)
        n, p = columns.shape
        base, upper = np.linalg.qr(columns)
        weights = y @ base
        residual = ((y - weights @ base.T) ** 2).sum(axis=1) / (n - p)
        last, length = weights[:, -1] / upper[-1, -1], 1.0 / abs(upper[-1, -1])
        half = -special.stdtrit(n - p, (1.0 - LEVEL) / 2.0) * np.sqrt(residual) * length
        of_model = (weights[:, self.intercept :] ** 2).sum(axis=1) / (p - self.intercept)
        return of_interval(last - half, last + half, 0.0), of_p(
            special.fdtrc(p - self.intercept, n - p, of_model / residual)
        )

    def methods(self) -> tuple[Method, Method]:
        """Return the interval of the last coefficient, and the F-test."""
        return (
            Method(
                f"{self.name}_ci",
                "coverage",
                self.designs(),
                lambda groups, design: of_one_interval(self.library(*self.data(groups, design))[0], 0.0),
                lambda groups, design: self.many(groups, design)[0],
                alike,
            ),
            Method(
                f"{self.name}_f_test",
                "size",
                self.designs(),
                lambda groups, design: of_one_p(self.library(*self.data(groups, design))[1]),
                lambda groups, design: self.many(groups, design)[1],
                alike,
            ),
        )


def _wave(x: Floats) -> Floats:
    return np.asarray(np.sin(WAVES * x))


def _plane(x: Floats, y: Floats) -> tuple[tuple[float, float], float]:
    found = fit_linear(y, {"x": x, "wave": _wave(x)})
    return there(found.ci)[-1], there(found.f_p)


def _through_0(x: Floats, y: Floats) -> tuple[tuple[float, float], float]:
    found = fit_linear(y, {"x": x}, intercept=False)
    return there(found.ci)[-1], there(found.f_p)


def _cubic(x: Floats, y: Floats) -> tuple[tuple[float, float], float]:
    found = fit_polynomial(x, y, 3)
    return there(found.ci)[-1], there(found.f_p)


ALL = (
    Columns("fit_linear_of_two", lambda x: np.column_stack([np.ones_like(x), x, _wave(x)]), _plane),
    Columns("fit_linear_through_0", lambda x: x[:, None], _through_0, intercept=False),
    Columns("fit_polynomial_cubic", lambda x: np.vander(x, 4, increasing=True), _cubic),
)
METHODS = tuple(method for columns in ALL for method in columns.methods())
