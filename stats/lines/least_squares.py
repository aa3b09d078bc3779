"""Least squares to the last digit: QR of the scaled design, refined on residuals in double-double.

Source: A. Bjorck, Numerical Methods for Least Squares Problems (1996), 2.9 and 6.6: the factor R alone serves for
every correction (corrected seminormal equations), which gains about 16 - log10(condition) digits a step when the
residuals have twice the digits. The inverse factor is corrected likewise, so that standard errors keep theirs.

Coefficients of a fit that leaves nothing over are rational: an intercept of 0 is 0, and not 1e-31. That nothing is left
over is known to about 28 digits before. Rational coefficients are those of as many places as fix them, which are chosen
well apart, and are taken where they are right at places between, too.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from stats.exact.error_free import Floats, Pair, multiply, product_of_halves, split, sum_pairs, two_sum
from stats.exact.finite import to_double

_EPS = float(np.finfo(np.float64).eps)
_STEPS = 12
"""Steps of refinement at most; one or two are usual, and nothing that gets past the rank check needs more than 8."""
_DONE = 1e-27
"""Relative error, in the norm of the fitted values, at which refinement ends."""
_ZERO_RESIDUAL = 2.0**-94
"""Residuals below this share of what they are the difference of are rounding of double-doubles: the fit is exact."""
_GOOD_CONDITION = 100.0
"""Below it the inverse factor is right to 13 digits without correction."""
_BLOCK = 8192
"""Numbers worked on at a time."""
_FOLLOWS = 0.01
"""A column this close to the span of the others, as a share of its scatter, follows them (VIF 10 000)."""
_SMALLEST_DISTANCE = 8.0 * _EPS
"""A column no further than this share of its size from the span of the others differs from it by rounding only."""


@dataclass(frozen=True, slots=True)
class Design:
    """Regressors as rows of double-doubles, each scaled to about 1; ones first where there is an intercept."""

    high: Floats
    """Shape (p, n)."""
    low: Floats | None
    """Shape (q, n), for the q rows that are not the intercept's ones; None when all are 0."""
    intercept: bool
    sizes: Floats
    """Norms of the rows as they were given, uncentred: rounding is a share of these. Shape (p,)."""

    @property
    def first(self) -> int:
        """The first row that is not ones."""
        return int(self.intercept)

    def blocks(self) -> list[slice]:
        """Return the columns in blocks that stay in a processor's cache."""
        p, n = self.high.shape
        width = max(_BLOCK // p, 1)
        return [slice(start, start + width) for start in range(0, n, width)]


@dataclass(frozen=True, slots=True)
class Factor:
    """What a design says without the response."""

    triangle: Floats
    """R of the QR factorisation; shape (p, p)."""
    inverse: Floats
    """S with (A A')^-1 = S S'; shape (p, p)."""
    plain: Floats
    """The inverse of R as doubles have it."""
    rotation: Floats | None
    """S = plain @ rotation, where the condition calls for a correction."""
    distances: Floats
    """Distance of each row from the span of the others; shape (p,)."""
    norms: Floats
    """Norm of each row; shape (p,)."""
    condition: float
    """2-norm condition of the rows scaled to norm 1."""

    def carried(self, back: Floats) -> Floats:
        """Return back @ S; shape (p, p).

        Where columns are nearly collinear the rows of S nearly cancel in the intercept's: with all digits first.
        """
        if self.rotation is None:
            return back @ self.inverse
        left, right = back[:, np.newaxis], self.plain.T[np.newaxis]
        product: Floats = sum_pairs(*product_of_halves(left, split(left), right, split(right)))[0] @ self.rotation
        return product


@dataclass(frozen=True, slots=True)
class Solution:
    """Least-squares coefficients in the design's scale."""

    coefficients: Pair
    """Shape (p,)."""
    fitted: Floats
    """What is fitted of the response, shape (n,): large coefficients that cancel in it leave its digits."""
    residuals: Floats
    """Shape (n,); exactly 0 where the fit is exact."""


def factorise(design: Design) -> Factor | tuple[int, ...]:
    """Return the factor of a design with at least as many columns as rows, or the rows that are collinear."""
    triangle = _triangle(design)
    norms: Floats = np.sqrt((triangle * triangle).sum(axis=0))
    singular = np.linalg.svd(triangle / norms, compute_uv=False)
    if singular[-1] <= _EPS * singular[0] / 16.0:
        return _participants(triangle / norms)
    inverse: Floats = np.asarray(np.linalg.inv(triangle), dtype=np.float64)
    distances: Floats = 1.0 / np.sqrt((inverse * inverse).sum(axis=1))
    # A column that itself varies by little more than its rounding is what it says; one that follows others is not.
    rounding = np.minimum(_SMALLEST_DISTANCE * design.sizes, _FOLLOWS * norms)
    if (distances <= np.maximum(rounding, _SMALLEST_DISTANCE * norms)).any():
        return _participants(triangle / norms)
    condition = float(singular[0] / singular[-1])
    if condition <= _GOOD_CONDITION:
        return Factor(triangle, inverse, inverse, None, distances, norms, condition)
    rotation = _rotation(inverse, design)
    if rotation is None:
        return _participants(triangle / norms)
    plain = inverse
    inverse = np.asarray(plain @ rotation, dtype=np.float64)
    distances = np.asarray(1.0 / np.sqrt((inverse * inverse).sum(axis=1)), dtype=np.float64)
    return Factor(triangle, inverse, plain, rotation, distances, norms, condition)


def _triangle(design: Design) -> Floats:
    """Return R of the QR factorisation, shape (p, p): that of the blocks' own, which stay in a processor's cache."""
    parts = [np.linalg.qr(design.high[:, block].T, mode="r") for block in design.blocks()]
    whole = parts[0] if len(parts) == 1 else np.linalg.qr(np.concatenate(parts), mode="r")
    return np.asarray(whole, dtype=np.float64)


def solve(design: Design, factor: Factor, response: Pair) -> Solution:
    """Return the coefficients of a response, a pair of shape (n,) scaled to about 1."""
    inverse = factor.inverse
    coefficients = inverse @ (inverse.T @ (design.high @ response[0])), np.zeros(len(inverse))
    gain = 16.0 * len(inverse) * _EPS * factor.condition
    high = low = response[0]
    for _ in range(_STEPS):
        high, low, products = _residuals(design, response, coefficients)
        rotated = inverse.T @ products
        correction = inverse @ rotated
        step = float(np.abs(rotated).max())
        if step == 0.0:
            break
        total, error = two_sum(coefficients[0], correction)
        coefficients = two_sum(total, error + coefficients[1])
        # Both in the norm of the fitted values: the triangle times the coefficients.
        size = float(np.abs(factor.triangle @ coefficients[0]).max())
        if step <= 1e-13 * size and step * gain <= _DONE * size:
            # So small a correction moves the residuals by what doubles can say.
            low = low - correction @ design.high
            break
    result = high + low
    fitted, error = two_sum(response[0], -high)
    fitted += error + (response[1] - low)
    rounding = _ZERO_RESIDUAL * (1.0 + float(np.abs(coefficients[0]).sum()))
    if float(result @ result) <= rounding * rounding * result.size:
        result = np.zeros_like(result)
    return Solution(coefficients, fitted, result)


def _residuals(design: Design, response: Pair, coefficients: Pair) -> tuple[Floats, Floats, Floats]:
    """Return the residuals as a pair, and their scalar products with the rows, shape (p,)."""
    first = design.first
    factor = coefficients[0][first:, np.newaxis]
    halves_of_factor, factor_low = split(factor), coefficients[1][first:, np.newaxis]
    refined = bool(coefficients[1].any())
    parts = []
    for block in design.blocks():
        rows = design.high[first:, block]
        rows_low = None if design.low is None else design.low[:, block]
        halves = split(rows)
        products, errors = product_of_halves(rows, halves, factor, halves_of_factor)
        if refined:
            errors += rows * factor_low
        if rows_low is not None:
            errors += rows_low * factor
        high, low = response[0][block], response[1][block] - (errors[0] if len(errors) == 1 else errors.sum(axis=0))
        if first:
            high, error = two_sum(high, -float(coefficients[0][0]))
            low += error
            low -= coefficients[1][0]
        for product in np.negative(products, out=products):
            high, error = two_sum(high, product)
            low += error
        high, low = two_sum(high, low)
        parts.append((high, low, *_products(rows, rows_low, halves, (high, low), first)))
    if len(parts) == 1:
        return parts[0][:3]
    sums, errors = (np.array([part[which] for part in parts]).T for which in (2, 3))
    high, low = (np.concatenate([part[which] for part in parts]) for which in (0, 1))
    return high, low, sum_pairs(sums, errors)[0]


def _products(rows: Floats, rows_low: Floats | None, halves: Pair, vector: Pair, ones: int) -> Pair:
    """Return the scalar product of every row, and of `ones` rows of ones before them, with a vector of pairs."""
    products, errors = product_of_halves(rows, halves, vector[0], split(vector[0]))
    errors += rows * vector[1]
    if rows_low is not None:
        errors += rows_low * vector[0]
    if ones:
        products = np.concatenate((vector[0][np.newaxis], products))
        errors = np.concatenate((vector[1][np.newaxis], errors))
    return sum_pairs(products, errors)


def _rotation(inverse: Floats, design: Design) -> Floats | None:
    """Return L with (A A')^-1 = S L L' S', from what S'A A'S, in double-double, differs from the identity.

    The rows are turned before they are multiplied, so that the error grows with the condition and not with its square.
    None where R has no digit right in some direction.
    """
    p, n = design.high.shape
    gram = np.zeros((p, p)), np.zeros((p, p))
    for block in design.blocks():
        low = np.zeros((p, min(block.stop, n) - block.start))
        if design.low is not None:
            low[design.first :] = design.low[:, block]
        turned = _turned(inverse, design.high[:, block], low)
        for i in range(p):
            # Half of a symmetric matrix: row i with rows 0 to i.
            row = turned[0][i], turned[1][i]
            sums = sum_pairs(*multiply((turned[0][: i + 1], turned[1][: i + 1]), row))
            total, error = two_sum(gram[0][i, : i + 1], sums[0])
            gram[0][i, : i + 1], gram[1][i, : i + 1] = total, gram[1][i, : i + 1] + (error + sums[1])
    excess = (gram[0] - np.eye(p)) + gram[1]
    excess = np.tril(excess) + np.tril(excess, -1).T
    if float(np.abs(excess).max()) * p > 0.5:
        return None
    square = np.asarray(np.linalg.inv(np.eye(p) + excess), dtype=np.float64)
    rotation: Floats = np.asarray(np.linalg.cholesky(0.5 * (square + square.T)), dtype=np.float64)
    return rotation


def _turned(inverse: Floats, rows: Floats, low: Floats) -> Pair:
    """Return S'A, as a pair of the shape of the rows: rows of norm 1 that are nearly orthogonal."""
    halves = split(rows)
    parts = []
    for column in inverse.T:
        factor = column[:, np.newaxis]
        products, errors = product_of_halves(rows, halves, factor, split(factor))
        parts.append(sum_pairs(products.T, (errors + low * factor).T))
    return np.array([part[0] for part in parts]), np.array([part[1] for part in parts])


def _participants(triangle: Floats) -> tuple[int, ...]:
    """Return the rows with a share in the direction that the data do not fix."""
    share = np.abs(np.linalg.svd(triangle)[2][-1])
    return tuple(int(row) for row in np.flatnonzero(share > 1e-8 * share.max()))


_BETWEEN = 6
"""Places at which the coefficients are checked beside those that fix them."""


def deciding_places(design: Design, factor: Factor) -> list[int]:
    """Return the places that fix the p coefficients, each the farthest from those before, and some between."""
    left = factor.inverse.T @ design.high
    fixing: list[int] = []
    for _ in range(len(left)):
        if fixing:
            direction = left[:, fixing[-1]] / np.linalg.norm(left[:, fixing[-1]])
            left -= np.outer(direction, direction @ left)
        fixing.append(int(np.argmax((left * left).sum(axis=0))))
    between = np.linspace(0, left.shape[1] - 1, _BETWEEN).astype(int).tolist()
    return list(dict.fromkeys([*fixing, *between]))


def exact_coefficients(columns: Sequence[Sequence[Fraction]], y: Sequence[Fraction]) -> list[Fraction] | None:
    """Return the coefficients of p columns, each of shape (n,), whose sum is y, shape (n,), at every place.

    None where no coefficients do that, or where the columns do not fix them.
    """
    places = iter(zip(*columns, y, strict=True))
    solved: dict[int, list[Fraction]] = {}
    while len(solved) < len(columns):
        place = next(places, None)
        if place is None:
            return None
        rest = list(place)
        for column, equation in solved.items():
            rest = _less(rest, rest[column], equation)
        pivot = next((column for column, weight in enumerate(rest[:-1]) if weight), None)
        if pivot is not None:
            equation = [weight / rest[pivot] for weight in rest]
            solved = {column: _less(row, row[pivot], equation) for column, row in solved.items()}
            solved[pivot] = equation
        elif rest[-1]:
            return None
    coefficients = [solved[column][-1] for column in range(len(columns))]
    for *weights, value in places:
        if sum((c * weight for c, weight in zip(coefficients, weights, strict=True)), Fraction(0)) != value:
            return None
    return coefficients


def in_scale(coefficients: Sequence[Fraction], units: Sequence[tuple[float, int]]) -> list[float]:
    """Return coefficients over the powers of two of their units; infinite where doubles end."""
    return [
        to_double(value / Fraction(2) ** exponent) for value, (_, exponent) in zip(coefficients, units, strict=True)
    ]


def _less(row: Sequence[Fraction], times: Fraction, other: Sequence[Fraction]) -> list[Fraction]:
    return [value - times * taken for value, taken in zip(row, other, strict=True)]
