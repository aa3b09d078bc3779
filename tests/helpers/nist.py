"""NIST's reference data and what exact arithmetic makes of them (`tests/stats/nist/README.txt`)."""

from __future__ import annotations

import csv
import io
import math
import zipfile
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from pathlib import Path

from mpmath import mpf

FOLDER = Path(__file__).parents[1] / "stats" / "nist"


@dataclass(frozen=True, slots=True)
class Quantity:
    """One certified number."""

    dataset: str
    kind: str
    name: str
    certified: str
    of_decimals: mpf
    of_doubles: mpf


@cache
def quantities(kind: str) -> tuple[Quantity, ...]:
    """Return all certified numbers of a kind of sets: "univariate", "anova" or "linear"."""
    with (FOLDER / "exact.csv").open(newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["kind"] == kind]
    exact, of_doubles = "exact_decimal_25d", "exact_of_float64_input_25d"
    return tuple(
        Quantity(row["dataset"], kind, row["quantity"], row["certified"], _number(row[exact]), _number(row[of_doubles]))
        for row in rows
    )


def _number(text: str) -> mpf:
    return mpf(text.replace("Infinity", "inf"))


@cache
def names(kind: str) -> tuple[str, ...]:
    """Return the names of the sets of a kind."""
    return tuple(dict.fromkeys(quantity.dataset for quantity in quantities(kind)))


@cache
def columns(dataset: str) -> dict[str, tuple[Decimal, ...]]:
    """Return the columns of a set, as decimals."""
    with zipfile.ZipFile(FOLDER / "data.zip") as file:
        rows = list(csv.DictReader(io.StringIO(file.read(f"{dataset}.csv").decode())))
    return {name: tuple(Decimal(row[name]) for row in rows) for name in rows[0]}


@cache
def groups(dataset: str) -> dict[str, tuple[Decimal, ...]]:
    """Return the groups of an ANOVA set, as decimals."""
    parts: dict[str, list[Decimal]] = {}
    table = columns(dataset)
    for group, value in zip(table["group"], table["y"], strict=True):
        parts.setdefault(str(group), []).append(value)
    return {name: tuple(values) for name, values in parts.items()}


def exact(dataset: str, kind: str, name: str, decimals: bool = False) -> mpf:
    """Return one number, on the doubles or on the decimals."""
    (found,) = (one for one in quantities(kind) if (one.dataset, one.name) == (dataset, name))
    return found.of_decimals if decimals else found.of_doubles


def digits(found: float, right: mpf) -> float:
    """Return how many digits are right: -log10 of the relative error, 17 where there is none."""
    error = abs(mpf(found) - right) / (abs(right) if right != 0 else 1)
    return 17.0 if error == 0 else min(17.0, -math.log10(error))
