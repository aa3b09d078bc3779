"""Least squares in rational arithmetic: the normal equations solved exactly, for tests to measure against."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from fractions import Fraction
from pathlib import Path
from typing import Any

NIST = Path(__file__).parents[1] / "stats" / "nist"


@dataclass(frozen=True)
class ExactFit:
    coefficients: list[Fraction]
    variances: list[Fraction]
    """Squares of the standard errors; empty without degrees of freedom."""
    ss_residual: Fraction
    ss_model: Fraction
    """What the columns explain: about the mean where there is an intercept."""
    inverse: list[list[Fraction]]


def exact_fit(y: Iterable[object], columns: Sequence[Iterable[object]], *, intercept: bool = True) -> ExactFit:
    """Fit exactly what the values say; anything that `Fraction` takes, numpy's numbers too."""
    response = [exact(value) for value in y]
    rows = [[exact(value) for value in column] for column in columns]
    if intercept:
        rows.insert(0, [Fraction(1)] * len(response))
    p = len(rows)
    work = [
        [dot(a, b) for b in rows] + [dot(a, response)] + [Fraction(int(i == j)) for j in range(p)]
        for i, a in enumerate(rows)
    ]
    for pivot in range(p):
        best = next(i for i in range(pivot, p) if work[i][pivot] != 0)
        work[pivot], work[best] = work[best], work[pivot]
        work[pivot] = [value / work[pivot][pivot] for value in work[pivot]]
        for i in range(p):
            if i != pivot and work[i][pivot] != 0:
                factor = work[i][pivot]
                work[i] = [a - factor * b for a, b in zip(work[i], work[pivot], strict=True)]
    coefficients = [row[p] for row in work]
    residuals = [value - dot(coefficients, [row[i] for row in rows]) for i, value in enumerate(response)]
    squares, df = dot(residuals, residuals), len(response) - p
    inverse = [row[p + 1 :] for row in work]
    variances = [squares / df * inverse[j][j] for j in range(p)] if df else []
    middle = sum(response, Fraction(0)) / len(response) if intercept else Fraction(0)
    about = [value - middle for value in response]
    return ExactFit(coefficients, variances, squares, dot(about, about) - squares, inverse)


def exact(value: Any) -> Fraction:
    item = value.item() if hasattr(value, "item") else value
    return Fraction(item)


def dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    return sum((one * other for one, other in zip(a, b, strict=True)), Fraction(0))


def root(square: Fraction) -> float:
    """Return the square root, right to the last digit, of what may lie outside the range of doubles."""
    with localcontext() as context:
        context.prec = 40
        return float((Decimal(square.numerator) / Decimal(square.denominator)).sqrt())


def relative_error(found: float, truth: float | Fraction | Decimal) -> float:
    """Return |found - truth| / |truth| in exact arithmetic; |found| where the truth is 0."""
    true = Fraction(truth)
    return float(abs(Fraction(found)) if true == 0 else abs((Fraction(found) - true) / true))


def assert_exact(fit: Any, truth: ExactFit, tolerance: float = 1e-14, se_tolerance: float = 1e-12) -> None:
    """Compare coefficients, standard errors, the sum of squares, R squared and F with exact arithmetic."""
    for value, true in zip(fit.coefficients, truth.coefficients, strict=True):
        assert relative_error(value, true) < tolerance
    for se, variance in zip(fit.standard_errors, truth.variances, strict=True):
        assert relative_error(se, root(variance)) < se_tolerance
    assert relative_error(fit.ss_residual, truth.ss_residual) < se_tolerance
    total = truth.ss_model + truth.ss_residual
    if total:
        assert relative_error(fit.r_squared, truth.ss_model / total) < se_tolerance
    if truth.ss_residual and fit.df:
        f = truth.ss_model / fit.df_model / (truth.ss_residual / fit.df)
        assert relative_error(fit.f, f) < se_tolerance


def nist_data(name: str) -> list[list[float]]:
    """Return the columns of a NIST set, y first, as doubles."""
    with (NIST / f"{name}.csv").open(encoding="utf-8") as file:
        rows = list(csv.reader(file))[1:]
    return [[float(row[j]) for row in rows] for j in range(len(rows[0]))]


def nist_truth(name: str) -> dict[str, Decimal]:
    """Return the exact values of a linear NIST set on its float64 inputs, to 25 digits."""
    with (NIST / "linear_exact.csv").open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["dataset"] == name]
    return {row["quantity"]: Decimal(row["exact_of_float64"]) for row in rows}
