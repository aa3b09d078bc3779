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
from dataclasses import dataclass

import numpy as np

from stats.days.blocks import Blocks, Floats, blocks_of, pair_squares, parts_of
from stats.days.cells import Cells
from stats.days.reml_profile import Estimates, Profile

DAY, RUN = 0, 1
"""Places of the two variances in gamma."""


def basis_of(cells: Cells) -> Floats:
    """Return columns that compare conditions within runs, then within days, then the parts that share no day.

    Its determinant is 1 or -1, so that the deviance is that of any coding by indicators (lme4's).
    """
    by_day, by_run = parts_of(cells.condition, cells.day), parts_of(cells.condition, cells.run)
    first_in_run = [int(np.argmax(by_run == part)) for part in by_run]
    first_in_day = [int(np.argmax(by_day == part)) for part in by_day]
    places = np.arange(cells.n_conditions)
    within_runs = [places == place for place in places if first_in_run[place] != place]
    firsts = [place for place in places if first_in_run[place] == place]
    within_days = [by_run == by_run[place] for place in firsts if first_in_day[place] != place]
    rest = [by_day == by_day[place] for place in firsts if first_in_day[place] == place]
    return np.column_stack([*within_runs, *within_days, *rest]).astype(np.float64)


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
