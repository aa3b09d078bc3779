"""A fit's coefficients one by one, as a table holds them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from data_schema.vocabulary import Undefined
from stats.results import Result


@dataclass(frozen=True, slots=True)
class Coefficient(Result):
    """One coefficient of a least-squares fit, in the unit of the response over that of its column."""

    name: str
    """Of its column, or "intercept"."""
    coefficient: float
    """Its estimate, in the unit of the response over that of its column."""
    standard_error: float | Undefined
    """In the unit of the coefficient; 0 where the fit is exact."""
    t: float | Undefined
    """Coefficient over standard error."""
    p: float | Undefined
    """Two-sided, of the coefficient being 0."""
    log10_p: float | Undefined
    """Decimal logarithm of p, right at any size."""
    ci: tuple[float, float] | Undefined
    """Student's interval, of the fit's level."""
    vif: float | Undefined
    """Variance inflation of its column."""


def one_by_one(
    names: Sequence[str],
    coefficients: Sequence[float],
    standard_errors: Sequence[float] | Undefined,
    t: Sequence[float] | Undefined,
    p: Sequence[float] | Undefined,
    log10_p: Sequence[float] | Undefined,
    ci: Sequence[tuple[float, float]] | Undefined,
    vif: Sequence[float | Undefined],
) -> tuple[Coefficient, ...]:
    """Return the coefficients in the order of their names; what is undefined of all is so of each."""
    of_each = [
        [part] * len(names) if isinstance(part, Undefined) else part for part in (standard_errors, t, p, log10_p, ci)
    ]
    return tuple(Coefficient(*row) for row in zip(names, coefficients, *of_each, vif, strict=True))
