"""Rows of columns that belong together: a row without a value in any of them is refused, or left out and counted."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from data_schema.errors import InputRefused, unknown_name
from stats.checks import MISSING, NO_VALUE, Missing

Labels = Sequence[object] | ArrayLike
"""Names of conditions, days or runs, one for each value: words, numbers or anything with a text of its own."""


def complete_rows(columns: Sequence[Any], missing: Missing) -> tuple[list[Any], int]:
    """Return columns of shape (n,) without the rows that lack a value in any, and how many rows those were.

    With `missing="refuse"`, or where lengths differ, the columns come back as they are: who takes them refuses them.
    Types stay what they are; a missing value is NaN, NaT, None, pandas' NA or masked.
    Raises `InputRefused` for lists of unequal lengths in place of values.
    """
    if missing not in MISSING:
        raise unknown_name("way with missing values", missing, MISSING)
    try:
        shapes = {np.shape(column) for column in columns}
    except ValueError as error:
        raise InputRefused("the values are lists of unequal lengths: give one number for each value.") from error
    if missing == "refuse" or len(shapes) != 1 or len(next(iter(shapes))) != 1:
        return list(columns), 0
    lacking = np.any([absent(column) for column in columns], axis=0)
    if not lacking.any():
        return list(columns), 0
    return [np.asarray(column)[~lacking] for column in columns], int(lacking.sum())


def as_labels(name: str, labels: Labels, missing: Missing) -> NDArray[np.object_]:
    """Return labels as an array of shape (n,), whatever holds them; a label that is missing is refused unless dropped.

    NaN as a label would be a condition or a day of its own.
    """
    array = np.asarray(labels, dtype=object).ravel()
    lacking = absent(array)
    if missing == "refuse" and lacking.any():
        raise InputRefused(
            f"{name} holds {int(lacking.sum())} of {array.size} labels that are missing, the first at position "
            f"{int(np.argmax(lacking)) + 1}: leave missing values out before calling."
        )
    return array


def absent(values: Any) -> NDArray[np.bool_]:
    """Return where values or labels of shape (n,) are missing."""
    array = np.asarray(values)
    if isinstance(values, np.ma.MaskedArray):
        return np.asarray(np.ma.getmaskarray(values) | absent(array))
    if array.dtype.kind == "f":
        return np.asarray(np.isnan(array))
    if array.dtype.kind in "mM":
        return np.asarray(np.isnat(array))
    if array.dtype.kind == "O":
        return np.array([_is_absent(value) for value in array.tolist()], dtype=np.bool_)
    return np.zeros(array.shape, dtype=np.bool_)


def _is_absent(value: object) -> bool:
    if type(value).__name__ in NO_VALUE:
        return True
    return value.is_nan() if isinstance(value, Decimal) else isinstance(value, Real) and bool(value != value)
