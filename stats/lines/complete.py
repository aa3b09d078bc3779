"""Rows of columns that belong together: a row without a value in any of them is refused, or left out and counted."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal
from numbers import Rational, Real
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from data_schema.errors import InputRefused, unknown_name
from stats.checks import MISSING, NO_VALUE, Missing
from stats.wording import missing_text

Labels = Sequence[object] | ArrayLike
"""Names of conditions, days or runs, one for each value: words, numbers or anything with a text of its own."""

_LARGEST_BROKEN = 2**53
"""From here on doubles are whole numbers."""


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
    """Return the texts of labels, shape (n,), whatever holds them; a label that is missing is refused unless dropped.

    A label that is missing would be a condition or a day of its own: NaN, None, infinite, masked or an empty text. With
    `missing="drop"` it comes back as None.
    """
    array = np.asarray(labels, dtype=object)
    if array.ndim != 1:
        raise InputRefused(
            f"{name} has {array.ndim} dimensions where one is allowed: give a plain list of labels, one for each value."
        )
    lacking = absent(labels if isinstance(labels, np.ndarray) else array)  # which a mask and NaT do not outlive
    texts = np.array([None if gone else label_text(each) for each, gone in zip(array, lacking, strict=True)], object)
    lacking = np.array([text is None or not text.strip() for text in texts], dtype=np.bool_)
    if missing == "refuse" and lacking.any():
        raise InputRefused(
            f"{name} holds {int(lacking.sum())} of {array.size} labels that are missing, the first at position "
            f'{int(np.argmax(lacking)) + 1}: leave missing values out before calling, or say missing="drop".'
        )
    texts[lacking] = None
    return texts


def label_text(label: Any) -> str:
    """Return what a label is called: numbers that are equal, as 0, 0.0 and Decimal(0), by one name; "" if infinite."""
    if isinstance(label, str | bool | np.bool_) or not isinstance(label, Real | Decimal):
        return str(label)
    try:
        whole = int(label)  # type: ignore[arg-type]
    except OverflowError:
        return ""
    if whole == label:
        return str(whole)
    if isinstance(label, Rational | Decimal) and abs(whole) < _LARGEST_BROKEN and float(label) == label:
        return str(float(label))
    return f"{label:f}".rstrip("0") if isinstance(label, Decimal) else str(label)


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


MINIMUM_ROWS = 3
"""Two rows fix a line and leave nothing to measure its uncertainty with."""


def refuse_few(n: int, what: str, left_out: int) -> None:
    """Raise `InputRefused` for fewer rows, `what` in the plural, than show how well a line is known."""
    if n < MINIMUM_ROWS:
        raise InputRefused(
            f"the number of {what} is {n}{missing_text(left_out)}, and the line needs at least {MINIMUM_ROWS}, or "
            "nothing says how well it is known: give more (`fit_linear` gives the bare line of two)."
        )
