"""What every function here does with its input first: real numbers of any type, one dimension, nothing infinite."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from numbers import Real
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from data_schema.errors import InputRefused, unknown_name

Missing = Literal["refuse", "drop"]
MISSING: tuple[Missing, ...] = ("refuse", "drop")
"""What to do with values that are NaN: refuse them all, or leave them out and say how many."""

Samples = Mapping[str, ArrayLike] | Sequence[ArrayLike]
"""Samples of values in one unit, by name or in a list."""

NO_VALUE = ("NAType", "NaTType", "NoneType")
"""Types of a missing value, by name: pandas itself need not be loaded."""


@dataclass(frozen=True, slots=True)
class Sample:
    """Finite values, shape (n,), and how many were left out as missing."""

    values: NDArray[np.float64]
    missing: int


def as_sample(name: str, values: ArrayLike | Iterable[Decimal], missing: Missing = "refuse") -> Sample:
    """Return real numbers of any type (also of pandas and xarray), shape (n,), as a sample.

    `name` is what the sentence of a refusal calls them. NaN, None, pandas' NA and masked values are missing: refused,
    or with `missing="drop"` left out and counted. Raises `InputRefused` for infinite values, truth values, text,
    complex numbers, times, and what is no list of one dimension.
    """
    if missing not in MISSING:
        raise unknown_name("way with missing values", missing, MISSING)
    doubles = _doubles(name, values)
    if doubles.ndim != 1:
        raise InputRefused(f"{name} has {doubles.ndim} dimensions where one is allowed: give a plain list of numbers.")
    finite = np.isfinite(doubles)
    if finite.all():  # nearly always
        return Sample(doubles[finite], 0)
    bad = ~finite if missing == "refuse" else np.isinf(doubles)
    if bad.any():
        raise InputRefused(
            f"{name} holds {int(bad.sum())} of {doubles.size} values that are NaN or infinite, the first at position "
            f'{int(np.argmax(bad)) + 1}: leave them out before calling, or, of groups and NaN, say missing="drop".'
        )
    return Sample(doubles[finite], int(doubles.size - finite.sum()))


def as_groups(groups: Any) -> dict[str, ArrayLike]:
    """Return samples by their names, as the columns of a data frame; those of a list are called "1", "2" and so on.

    Raises `InputRefused` for what is no sequence of samples.
    """
    if callable(getattr(groups, "keys", None)):
        return {str(name): groups[name] for name in groups}
    if not isinstance(groups, Sequence) or not groups or any(np.ndim(values) == 0 for values in groups):
        raise InputRefused("the groups are no samples: give one sample of numbers for each, by name or in a list.")
    return {str(place): values for place, values in enumerate(groups, 1)}


def as_values(name: str, values: ArrayLike) -> NDArray[np.float64]:
    """Return `values` as float64 of shape (n,); `name` is what the sentence of a refusal calls them.

    Raises `InputRefused` for what `as_sample` refuses, NaN included.
    """
    return as_sample(name, values).values


def as_number(name: str, value: float, *, low: float = -np.inf, above: float = -np.inf) -> float:
    """Return one finite number that is at least `low` and greater than `above`.

    Raises `InputRefused` otherwise.
    """
    number = _one(name, value)
    if not math.isfinite(number) or number < low or number <= above:
        allowed = "a finite number"
        if low > -np.inf:
            allowed = f"a number of at least {low:g}"
        if above > -np.inf:
            allowed = f"a number greater than {above:g}"
        raise InputRefused(f"{name} is {value!r}: give {allowed}.")
    return number


def as_level(name: str, value: float) -> float:
    """Return a probability strictly between 0 and 1; raises `InputRefused` otherwise."""
    number = _one(name, value)
    if not 0.0 < number < 1.0:
        raise InputRefused(f"{name} is {value!r}: give a number between 0 and 1, for example 0.95.")
    return number


def as_count(name: str, value: float, least: int = 0) -> int:
    """Return one whole number that is at least `least`; raises `InputRefused` otherwise."""
    number = _one(name, value)
    if not math.isfinite(number) or number != int(number) or number < least:
        raise InputRefused(f"{name} is {value!r}: give a whole number of at least {least}.")
    return int(value)


def _one(name: str, value: Any) -> float:
    if type(value) is float:  # nearly always, and asking for the others takes most of the time
        return value
    try:
        if isinstance(value, bool | np.bool_ | str | complex):
            raise TypeError
        return float(value)
    except OverflowError:
        return np.inf
    except (TypeError, ValueError) as error:
        raise InputRefused(f"{name} is {value!r}: give a number.") from error


def _doubles(name: str, values: Any) -> NDArray[np.float64]:
    """Return real numbers of any type as doubles, NaN for missing values."""
    try:
        array = np.asarray(values)
        if array.dtype.kind == "O" and array.ndim == 1:
            array = np.array([_double(value) for value in array.tolist()], np.float64)
        if array.dtype.kind not in "fiu":
            raise TypeError
    except (TypeError, ValueError) as error:
        raise InputRefused(f"{name} holds something that is not a number: give a list of real numbers.") from error
    doubles = array
    if array.dtype != np.float64:
        with np.errstate(over="ignore"):  # a long double that is too large becomes infinite and is refused as such
            doubles = array.astype(np.float64)
    if isinstance(values, np.ma.MaskedArray):
        doubles = np.where(np.ma.getmaskarray(values), np.nan, doubles)
    return doubles


def _double(value: Any) -> float:
    if type(value).__name__ in NO_VALUE:
        return math.nan
    if isinstance(value, bool | np.bool_) or not isinstance(value, Real | Decimal):
        raise TypeError
    return _one("a value", value)


Labels = Sequence[object] | ArrayLike
"""Names of conditions, days or runs, one for each value: words, numbers or anything with a text of its own."""


def as_labels(name: str, labels: Labels) -> list[str]:
    """Return the texts of labels, shape (n,), numbers that are equal by one name, as 0 and 0.0.

    Raises `InputRefused` for a label that is missing or empty: it would be a condition or a day of its own.
    """
    texts = [_label_text(each) for each in np.asarray(labels, dtype=object).ravel().tolist()]
    if "" in texts:
        raise InputRefused(
            f"{name} holds {texts.count('')} of {len(texts)} labels that are missing, the first at position "
            f"{texts.index('') + 1}: leave missing values out before calling."
        )
    return texts


def _label_text(label: Any) -> str:
    if type(label) is str:  # nearly always
        return label if label.strip() else ""
    if type(label).__name__ in NO_VALUE or label != label:
        return ""
    if isinstance(label, Real) and float(label).is_integer():
        return str(int(float(label)))
    return str(label) if str(label).strip() else ""
