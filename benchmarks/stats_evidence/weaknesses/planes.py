"""W18 to W20: planes through force over displacement and velocity, and planes that the data do not fix."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from benchmarks.stats_evidence.weaknesses.case import NoNumber, Number, Peer, Question, Weakness
from benchmarks.stats_evidence.weaknesses.peers import module, numpy, pg, pingouin, sklearn, statsmodels
from stats.lines.regression import fit_linear
from tests.helpers.exact_fit import ExactFit, exact_fit

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Plane:
    """Forces at displacements and velocities, shape (n,) each."""

    x: Floats
    v: Floats
    force: Floats

    @property
    def columns(self) -> Mapping[str, Floats]:
        """What force is fitted over."""
        return {"x": self.x, "v": self.v}

    @property
    def design(self) -> Floats:
        """Ones, displacements and velocities, shape (n, 3)."""
        return np.column_stack([np.ones(self.x.size), self.x, self.v])


NOISE = 0.05


def _plane(offset: float, x_unit: float) -> Plane:
    rng = np.random.default_rng(18)
    x, v = rng.uniform(-0.02, 0.02, 300), rng.uniform(-1.0, 1.0, 300)
    x = offset + x
    return Plane(x_unit * x, v, 20000.0 * x + 15.0 * v + rng.normal(0.0, NOISE, 300))


X = np.linspace(-0.02, 0.02, 300)
FAR, IN_NM = _plane(1e6, 1.0), _plane(0.0, 1e9)
STILL = Plane(X, np.full(300, 0.1), 20000.0 * X + 15.0 * 0.1 + 100.0)
AT_REST = Plane(X, np.zeros(300), 20000.0 * X + 100.0)
ONE_LINE = Plane(X, -5.0 * X, 20000.0 * X + 15.0 * -5.0 * X)


@cache
def _exact(name: str) -> ExactFit:
    plane = {"far": FAR, "nm": IN_NM}[name]
    return exact_fit(plane.force, [plane.x, plane.v])


def _lstsq(plane: Plane, number: int) -> float:
    return float(np.linalg.lstsq(plane.design, plane.force)[0][number])


def _normal(plane: Plane, number: int) -> float:
    design = plane.design
    return float((np.linalg.inv(design.T @ design) @ (design.T @ plane.force))[number])


def _ols(plane: Plane, number: int) -> float:
    return float(module("statsmodels.api").OLS(plane.force, plane.design).fit().params[number])


def _pingouin(plane: Plane, number: int) -> float:
    return float(
        pingouin().linear_regression(module("pandas").DataFrame(plane.columns), plane.force)["coef"].iloc[number]
    )


def _sklearn(plane: Plane, number: int) -> float:
    fit = module("sklearn.linear_model").LinearRegression().fit(plane.design[:, 1:], plane.force)
    return float(fit.coef_[number - 1] if number else fit.intercept_)


NAMES = ("force at zero", "stiffness", "damping")


def _known(name: str, plane: Plane, number: int, *others: Peer, digits: int = 6) -> Question:
    return Question(
        NAMES[number],
        Number(lambda: float(_exact(name).coefficients[number]), "exact arithmetic"),
        lambda: fit_linear(plane.force, plane.columns).coefficients[number],
        others,
        digits,
    )


def _not_fixed(what: str, plane: Plane, number: int, cause: str, *others: Peer) -> Question:
    return Question(
        f"{NAMES[number]}, {what}",
        NoNumber(cause),
        lambda: fit_linear(plane.force, plane.columns).coefficients[number],
        others,
    )


CASES = (
    Weakness(
        "W18",
        "a plane far from the origin",
        f"300 points, x from 1e6 - 0.02 to 1e6 + 0.02, v from -1 to 1, force 20000 x + 15 v, standard deviation "
        f"{NOISE}, drawn at random for this table",
        (
            _known(
                "far",
                FAR,
                0,
                numpy("lstsq", lambda: _lstsq(FAR, 0), 0.02),
                statsmodels("OLS", lambda: _ols(FAR, 0), 138824.0),
                pg("linear_regression", lambda: _pingouin(FAR, 0), 0.02),
            ),
            _known(
                "far",
                FAR,
                1,
                numpy("lstsq", lambda: _lstsq(FAR, 1), 20000.0),
                numpy("inv(X.T @ X) @ X.T @ y", lambda: _normal(FAR, 1), -7478.0),
                pg("linear_regression", lambda: _pingouin(FAR, 1), 20000.0),
                digits=7,
            ),
        ),
    ),
    Weakness(
        "W19",
        "columns of very different size",
        f"300 points, x in nm, v in m/s, force 2e-5 x + 15 v, standard deviation {NOISE}, drawn at random for this "
        "table",
        (_known("nm", IN_NM, 2, sklearn("LinearRegression", lambda: _sklearn(IN_NM, 2), -4.9e-14), digits=4),),
    ),
    Weakness(
        "W20",
        "planes that the data do not fix",
        "300 points, x from -0.02 to 0.02, force 20000 x + 15 v (+ 100 where v is constant), without scatter",
        (
            _not_fixed(
                "v = 0.1",
                STILL,
                2,
                "the column 'v' is constant",
                numpy("lstsq", lambda: _lstsq(STILL, 2), 10.05),
                statsmodels("OLS", lambda: _ols(STILL, 2), 10.05),
                sklearn("LinearRegression", lambda: _sklearn(STILL, 2), 0.0),
            ),
            _not_fixed(
                "v = 0",
                AT_REST,
                2,
                "the column 'v' is constant",
                numpy("lstsq", lambda: _lstsq(AT_REST, 2), 0.0),
                statsmodels("OLS", lambda: _ols(AT_REST, 2), 0.0),
                sklearn("LinearRegression", lambda: _sklearn(AT_REST, 2), 0.0),
            ),
            _not_fixed(
                "v = -5 x",
                ONE_LINE,
                1,
                "'x' and 'v' are collinear",
                numpy("lstsq", lambda: _lstsq(ONE_LINE, 1), 766.3),
                statsmodels("OLS", lambda: _ols(ONE_LINE, 1), 766.3),
                pg("linear_regression", lambda: _pingouin(ONE_LINE, 1), 766.3),
                sklearn("LinearRegression", lambda: _sklearn(ONE_LINE, 1), 766.3),
            ),
            _not_fixed(
                "v = -5 x",
                ONE_LINE,
                2,
                "'x' and 'v' are collinear",
                numpy("lstsq", lambda: _lstsq(ONE_LINE, 2), -3832.0),
                statsmodels("OLS", lambda: _ols(ONE_LINE, 2), -3832.0),
                sklearn("LinearRegression", lambda: _sklearn(ONE_LINE, 2), -3832.0),
            ),
        ),
    ),
)
