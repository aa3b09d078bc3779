"""Restricted maximum likelihood for y ~ condition + (1 | day) + (1 | day:run), by a solver of its own.

The unknowns are gamma, the variances of days and of runs in residual variances (theta of lme4 squared); means and the
residual variance are profiled out. Rows are turned by orthogonal matrices, day by day, until their covariance is
diagonal, so that nothing is inverted and nothing cancels, however large the days' variance is, and time and memory
grow with the number of runs. Gradient and Hessian of the deviance are exact:

    dD/dg_i       = tr M_ii - nu w_i'w_i / S
    d2D/dg_i dg_j = -|M_ij|^2 + nu (2 w_i'M_ij w_j / S - w_i'w_i w_j'w_j / S^2)

with M_ij = Z_i'PZ_j, w_i = Z_i'Py, S = y'Py, nu = n - k.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

import numpy as np

from stats.days.cells import Blocks, Cells, Floats, blocks_of, pair_squares, parts_of
from stats.exact.numbers import Number


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


DAY, RUN = 0, 1
"""Places of the two variances in gamma."""


def basis_of(cells: Cells) -> Floats:
    """Return columns that compare conditions within runs, then within days, then the parts that share no day.

    Its determinant is 1 or -1, so that the deviance is that of any coding by indicators (lme4's). Conditions are taken
    as they come in the cells, so that their numbers decide the order of the rows alone.
    """
    number = np.argsort(np.argsort(np.unique(cells.condition, return_index=True)[1]))
    condition = number[cells.condition]
    by_day, by_run = parts_of(condition, cells.day), parts_of(condition, cells.run)
    first_in_run = [int(np.argmax(by_run == part)) for part in by_run]
    first_in_day = [int(np.argmax(by_day == part)) for part in by_day]
    places = np.arange(cells.n_conditions)
    within_runs = [places == place for place in places if first_in_run[place] != place]
    firsts = [place for place in places if first_in_run[place] == place]
    within_days = [by_run == by_run[place] for place in firsts if first_in_day[place] != place]
    rest = [by_day == by_day[place] for place in firsts if first_in_day[place] == place]
    return np.asarray(np.column_stack([*within_runs, *within_days, *rest]).astype(np.float64)[number])


@dataclass(frozen=True, slots=True)
class Whitened:
    """The rows of a design at unit variance, and the effects of days and runs on those between runs, at one gamma.

    The effects of a day's runs are turned onto its first row, where the day's own effect is; the effect matrices
    (days, or runs, by rows) are block diagonal by day and never written down.
    """

    days: Blocks
    """The runs by day."""
    rows: Floats
    """Rows within runs, then one for each run; the values in the last column."""
    root: Floats
    """Effect of each run before it is turned, shape (r,)."""
    shrink: Floats
    """Factor of each day's first row, shape (d,)."""
    total: Floats
    """Sum of the squared roots of each day, shape (d,)."""
    day_gamma: float
    log_det: float
    """log det V."""

    def transposed(self, place: int, columns: Floats) -> Floats:
        """Return Z_i' columns, for columns of shape (r, c) over the rows of runs."""
        shrunk = self.shrink[:, None] * columns[self.days.first]
        if place == DAY:
            return np.sqrt(self.total)[:, None] * shrunk
        columns = columns.copy()
        columns[self.days.first] = shrunk
        return self.root[:, None] * self.days.reflected(self.root, columns)

    def effect(self, place: int, size: Floats) -> Floats:
        """Return what effects of these sizes add to the rows of runs, shape (r,)."""
        if place == DAY:
            rows = np.zeros(self.root.size)
            rows[self.days.first] = np.sqrt(self.total) * size
        else:
            rows = self.days.reflected(self.root, (self.root * size)[:, None])[:, 0]
        rows[self.days.first] *= self.shrink
        return rows

    def squares(self, reach: list[Floats]) -> tuple[tuple[float, float], Floats]:
        """Return tr M_ii and |M_ij|^2, shapes (2,) and (2, 2), for how days and runs reach into the estimates.

        Within a day M_ij is the product of the effects less that of the reaches, which alone joins days.
        """
        of_day, of_run = reach
        group, weight = self.days.group, self.root**2
        share = self.shrink**2
        by_day = self.total * share - np.sum(of_day**2, axis=1)
        mixed = weight * share[group] - np.sum(of_day[group] * of_run, axis=1)
        others = weight * (1.0 + self.day_gamma * (self.total[group] - weight)) * share[group]
        by_run = others - np.sum(of_run**2, axis=1)
        # Two runs of a day have in common what the day's variance takes from both, which is one more reach.
        common = math.sqrt(self.day_gamma) * weight * self.shrink[group]
        of_runs, (joined,) = pair_squares([np.column_stack([common, of_run])[:, None, :]], group)
        between, _all = pair_squares([of_day[:, None, :], joined[:, :, 1:]], np.zeros_like(self.days.first))
        between[DAY, DAY] += float(by_day @ by_day)
        between[RUN, RUN] += float(by_run @ by_run) + float(of_runs[0, 0])
        between[DAY, RUN] += float(mixed @ mixed)
        return (float(by_day.sum()), float(by_run.sum())), between


class RemlModel:
    """The deviance of one design as a function of gamma."""

    def __init__(self, cells: Cells) -> None:
        self.degrees = cells.n - cells.n_conditions
        self._basis = basis_of(cells)
        self._run_rows, within = cells.rows(self._basis, cells.run)
        self._inner = np.asarray(np.linalg.qr(within, mode="r")) if within.size else within  # the same at every gamma
        runs = blocks_of(cells.run)
        self._run_size = runs.sums(cells.size)
        self._days = blocks_of(cells.day[runs.first])
        self._within_cells = cells.sum_squares
        self._plain = cells.condition_means if cells.plain(cells.day, cells.run) else None
        self.group_size = np.array([cells.n / self._days.first.size, cells.n / self._run_size.size])
        """Mean number of values a day and a run, shape (2,): the natural units of 1 / gamma."""

    def _whitened(self, gamma: Floats) -> Whitened:
        days, size = self._days, self._run_size
        spread = 1.0 + gamma[RUN] * size
        root = np.sqrt(size / spread)
        total = days.sums(size / spread)
        shrink = 1.0 / np.sqrt(1.0 + gamma[DAY] * total)
        rows = days.reflected(root, self._run_rows / np.sqrt(spread)[:, None])
        rows[days.first] *= shrink[:, None]
        log_det = float(np.log1p(gamma[RUN] * size).sum() + np.log1p(gamma[DAY] * total).sum())
        return Whitened(days, np.concatenate([self._inner, rows]), root, shrink, total, float(gamma[DAY]), log_det)

    def estimates(self, gamma: Floats) -> Estimates:
        """Return the conditions' means at gamma of shape (2,)."""
        rows = self._whitened(gamma).rows
        q, r = np.linalg.qr(rows[:, :-1])
        inverse = np.linalg.solve(r, np.eye(r.shape[0]))
        return Estimates(self._basis, inverse @ (q.T @ rows[:, -1]), inverse, self._plain)

    def _solved(self, rows: Floats) -> tuple[Floats, Floats, Floats, Floats, float]:
        """Return Q, R, Q'y, what is left of y, and S of whitened rows."""
        y = rows[:, -1]
        q, r = np.linalg.qr(rows[:, :-1])
        along = q.T @ y
        residual = y - q @ along
        residual -= q @ (q.T @ residual)
        return q, r, along, residual, self._within_cells + float(residual @ residual)

    def _deviance(self, log_det: float, r: Floats, squares: float) -> float:
        log_det += 2.0 * float(np.log(np.abs(np.diag(r))).sum())
        return log_det + self.degrees * (1.0 + math.log(2.0 * math.pi * squares / self.degrees))

    def deviance(self, gamma: Floats) -> float:
        """Return the deviance without its derivatives."""
        white = self._whitened(gamma)
        _q, r, _along, _residual, squares = self._solved(white.rows)
        return self._deviance(white.log_det, r, squares)

    def at(self, gamma: Floats) -> Profile:
        """Return the deviance and its derivatives at gamma of shape (2,), both at least 0."""
        white = self._whitened(gamma)
        q, r, along, residual, squares = self._solved(white.rows)
        nu = self.degrees
        outer = slice(self._inner.shape[0], None)
        inverse = np.linalg.solve(r, np.eye(r.shape[0]))
        reach = [white.transposed(place, q[outer]) for place in (DAY, RUN)]
        pull = [white.transposed(place, residual[outer, None])[:, 0] for place in (DAY, RUN)]
        force = [float(w @ w) for w in pull]
        traces, norms = white.squares(reach)
        pushed = []  # w_i'Z_i' less what of it the means take up
        for place in (DAY, RUN):
            effect = white.effect(place, pull[place])
            left = -q @ (q[outer].T @ effect)
            left[outer] += effect
            pushed.append(left)
        gradient, hessian = np.zeros(2), np.zeros((2, 2))
        for i, j in ((DAY, DAY), (DAY, RUN), (RUN, RUN)):
            curve = 2.0 * float(pushed[i] @ pushed[j]) / squares - (force[i] / squares) * (force[j] / squares)
            hessian[i, j] = hessian[j, i] = nu * curve - norms[i, j]
            if i == j:
                gradient[i] = traces[i] - nu * force[i] / squares
        return Profile(
            deviance=self._deviance(white.log_det, r, squares),
            gradient=gradient,
            hessian=hessian,
            residual_variance=squares / nu,
            estimates=Estimates(self._basis, np.asarray(inverse @ along), np.asarray(inverse), self._plain),
            reach=(reach[0], reach[1]),
            pulls=(force[0], force[1]),
        )


STEPS = 100
SMALL_STEP = 1e-13
"""Change of log(1 + gamma * group size) at which the search ends; Newton's last step squares the one before."""

NOTHING = 1e-8
"""Below it a variance is 0, as lme4 has it (a standard deviation of 1e-4): where the deviance is flat at the boundary,
rounding would decide whether the variance counts among the unknowns."""


def minimise(model: RemlModel, free: tuple[bool, bool], largest: float) -> Floats:
    """Return the gamma, shape (2,), of the lowest deviance; what is not `free` stays 0, as lme4 leaves out a term.

    The search runs in eta = log(1 + gamma * group size), smooth at the boundary gamma = 0 and logarithmic far from it:
    from every local minimum of a grid up to `largest`, by Newton steps, held at 0 where the deviance rises from there.
    """
    allowed = np.array(free)
    top = math.log1p(largest)
    count = 10 if allowed.sum() == 1 else 7
    axis = top * np.linspace(0.0, 1.0, count) ** 1.5
    axes = [axis if each else np.zeros(1) for each in free]
    grid = np.array([[model.deviance(_gamma(model, np.array([a, b]))) for b in axes[1]] for a in axes[0]])
    ends = [
        _descend(model, np.array([axes[0][i], axes[1][j]]), allowed, 2.0 * top + 10.0)
        for i, j in product(range(grid.shape[0]), range(grid.shape[1]))
        if grid[i, j] <= grid[max(i - 1, 0) : i + 2, max(j - 1, 0) : j + 2].min()
    ]
    end = min(ends, key=lambda end: model.deviance(_gamma(model, end))) if len(ends) > 1 else ends[0]
    return _gamma(model, np.where(end < NOTHING, 0.0, end))


def _gamma(model: RemlModel, eta: Floats) -> Floats:
    return np.asarray(np.expm1(eta) / model.group_size)


def _descend(model: RemlModel, eta: Floats, allowed: np.typing.NDArray[np.bool_], top: float) -> Floats:
    here = model.at(_gamma(model, eta))
    for _ in range(STEPS):
        stretch = np.exp(eta) / model.group_size
        gradient = here.gradient * stretch
        hessian = here.hessian * np.outer(stretch, stretch) + np.diag(gradient)
        moving = allowed & ~((eta == 0.0) & (gradient >= 0.0))
        if not moving.any():
            break
        step = _newton_step(gradient[moving], hessian[np.ix_(moving, moving)])
        slack = 1e-12 * model.degrees * (1.0 + abs(here.deviance) / model.degrees)
        factor = 1.0
        while True:
            trial = eta.copy()
            trial[moving] = np.clip(eta[moving] + factor * step, 0.0, top)
            there = model.at(_gamma(model, trial))
            if there.deviance <= here.deviance + slack or factor < 1e-6:
                break
            factor /= 2.0
        change = float(np.max(np.abs(trial - eta)))
        eta, here = trial, there
        if change <= SMALL_STEP * (1.0 + float(np.max(eta))):
            break
    return eta


def _newton_step(gradient: Floats, hessian: Floats) -> Floats:
    """Return Newton's step with curvatures made positive, no longer than 2 (a factor of 7 in gamma)."""
    curves, directions = np.linalg.eigh(hessian)
    floor = 1e-8 * max(float(np.max(np.abs(curves))), float(np.max(np.abs(gradient))), 1e-300)
    step = -directions @ ((directions.T @ gradient) / np.maximum(np.abs(curves), floor))
    return np.asarray(step * min(1.0, 2.0 / max(float(np.max(np.abs(step))), 1e-300)))
